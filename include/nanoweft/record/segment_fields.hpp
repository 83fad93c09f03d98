/// Fields of the segments for pictures: the strain of the bond to the next segment (zero without
/// one), and each segment's share of the energies.
///
/// Half of a bond's or a pair's energy belongs to each of its two segments, so the sums over all
/// segments are the totals of the run. All is evaluated when asked for; steps without a snapshot
/// pay nothing for it.
#pragma once

#include <vector>

#include "nanoweft/domain/domain.hpp"
#include "nanoweft/force/force_field.hpp"
#include "nanoweft/state/state_file.hpp"

namespace nanoweft {

/// Right after an evaluation of the forces. The same bits on any number of ranks and threads.
std::vector<SegmentField> segmentFields(const State& state, const Domain& domain,
                                        const ForceField& forces);

}  // namespace nanoweft
