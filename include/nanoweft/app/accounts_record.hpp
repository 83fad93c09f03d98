/// Saves the energy accounts in the record of a run and restores them, without rounding.
#pragma once

#include "nanoweft/motion/system.hpp"
#include "nanoweft/state/state_file.hpp"

namespace nanoweft {

/// Sums over all ranks. Collective.
void saveAccounts(RunRecord& record, const EnergyAccounts& accounts, MPI_Comm comm);
/// Rank 0 takes up the sums. Throws InputError when one is missing.
void restoreAccounts(EnergyAccounts& accounts, const RunRecord& record, int rank);

}  // namespace nanoweft
