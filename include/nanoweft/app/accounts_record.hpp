/// Energy accounts in the record of a run, exactly.
#pragma once

#include "nanoweft/motion/system.hpp"
#include "nanoweft/state/state_file.hpp"

namespace nanoweft {

/// Sums over all ranks. Collective.
void saveAccounts(RunRecord& record, const EnergyAccounts& accounts, MPI_Comm comm);
/// The sums go on on rank 0. Throws InputError when one is missing.
void restoreAccounts(EnergyAccounts& accounts, const RunRecord& record, int rank);

}  // namespace nanoweft
