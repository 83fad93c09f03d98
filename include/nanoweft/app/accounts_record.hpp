/// Saves the energy accounts in the record of a run and restores them, without rounding.
#pragma once

#include "nanoweft/motion/system.hpp"
#include "nanoweft/state/state_file.hpp"

namespace nanoweft {

/// Sums over all ranks. `heated`: of a run with a thermostat, whose record has an account of heat.
/// Collective.
void saveAccounts(RunRecord& record, const EnergyAccounts& accounts, bool heated, MPI_Comm comm);
/// Rank 0 takes up the sums. Throws InputError when one is missing.
void restoreAccounts(EnergyAccounts& accounts, const RunRecord& record, bool heated, int rank);

}  // namespace nanoweft
