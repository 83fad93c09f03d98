/// Where the results of a run come from, and which checkpoints a run may go on from.
#pragma once

#include <mpi.h>

#include <string>

#include "nanoweft/base/options.hpp"
#include "nanoweft/base/provenance.hpp"
#include "nanoweft/state/state_file.hpp"

namespace nanoweft {

/// The provenance of a run that has read all its options. `start`: of the file that the state comes
/// from, or null. In a restart (from the checkpoint `start`) the input is that of the first piece;
/// a -scene_file that is given again must be the same. Throws InputError. Collective.
Provenance readProvenance(MPI_Comm comm, const Options& options, const StateHeader* start,
                          bool restart);

/// Reads the header of a checkpoint, and puts its options in force. Throws InputError, with what to
/// do instead, for a file that a run cannot go on from. Collective.
StateHeader openCheckpoint(MPI_Comm comm, const std::string& file, Options& options);

/// Throws InputError that names what is missing of a checkpoint of a state with such fields.
void requireParts(const StateHeader& checkpoint, const ExtraFields& extras);

}  // namespace nanoweft
