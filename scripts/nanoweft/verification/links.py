"""Links and kinks: a ladder as a shear-lag beam, a tube that folds at its critical moment."""
import math

import numpy as np

from .. import states
from ..beams import TUBE, Ladder
from .bending import ends, straight
from .common import Row, new_folder, relative, simulate, write_state

T = TUBE.T
LINKS, KINKS = "links", "kinks"


def deflection(name, shape, segments, every=1):
    """At the tip of a ladder of so many segments with a rung at every so many of them."""
    folder, length = new_folder(name), shape.length / (segments - 1)
    x, q = straight(segments - 1) / T * length, np.tile([1.0, 0, 0, 0], (segments, 1))
    write_state(folder / "in.h5", [(x, q), (x + [0, shape.apart, 0], q)],
                np.tile(ends(segments - 1), 2))
    states.link(folder / "in.h5", [[[0, k], [1, k]] for k in range(every, segments, every)])
    simulate(name, "-scene file -scene_file {dir}/in.h5 -pair none -relax_method fire "
             f"-fibre_segment_length {length!r} -relax_force {1e-5 * shape.force!r} "
             "-ts_max_steps 2000000 -bc root,tip -root_group 0 -root_fix 1,1,1 -root_fix_rotation "
             f"-tip_group 1 -tip_force 0,{0.5 * shape.force!r},0 -state_output {{dir}}/out.h5 "
             f"-link_stiffness 100,{shape.rung!r},{-0.2 * shape.rung!r},{0.1 * shape.rung!r}")
    return states.read(folder / "out.h5")["position"][-1, 1] - shape.apart


def ladder():
    rows, segments, apart = [], 41, 3 * T
    length = (segments - 1) * T
    force = 1e-6 * 6 * TUBE.EJ / length**2
    for rung in (20.0, 500.0, 2e4):
        shape = Ladder(length, apart, rung, force)
        # The rung at the tip stands for half as much length as the others.
        rows.append(relative(
            LINKS, f"ladder of two fibres, rungs with B2 = {rung:g} eV: deflection, A",
            shape.shear_lag(1 / T), deflection(f"link_ladder_{rung:g}", shape, segments),
            0.5 / (segments - 1), "half a rung in 40 at the tip"))
    return rows


def turned(name, couple, segments, options, length=T):
    """Angle between the clamped first and the last segment under a couple at the end."""
    folder = new_folder(name)
    x, q = straight(segments - 1) / T * length, np.tile([1.0, 0, 0, 0], (segments, 1))
    write_state(folder / "in.h5", [(x, q)], ends(segments - 1))
    simulate(name, "-scene file -scene_file {dir}/in.h5 -pair none -bc root,tip -root_group 0 "
             f"-root_fix 1,1,1 -root_fix_rotation -tip_group 1 -tip_torque 0,0,{couple!r} "
             f"-fibre_segment_length {length!r} -state_output {{dir}}/out.h5 {options}")
    first, last = states.read(folder / "out.h5")["orientation"][[0, -1]]
    return 2 * math.acos(min(1.0, abs(float(first @ last))))


def fold():
    """A tube of 12 segments under a couple at its end, below and above what it can carry."""
    segments, curvature = 12, 1 / 275
    stiffness = TUBE.EJ / T
    critical = stiffness * 1.05 * 2 * math.sin(0.5 * curvature * T)
    damped = f"-damping_local 0.7 -ts_max_steps 20000 -fibre_kink_curvature {curvature!r}"
    below = turned("kink_below", 0.9 * critical, segments, damped)
    above = turned("kink_above", 1.05 * critical, segments, damped)
    return [relative(KINKS, "tube under 0.9 of its critical moment: angle, rad",
                     (segments - 1) * math.asin(0.9 * critical / stiffness), below, 1e-3,
                     "damped for 0.4 ns"),
            Row(KINKS, "tube under 1.05 of its critical moment: angle beyond 1.5 rad", 1.5, above,
                float(np.maximum(0.0, 1.5 - above)), 1e-12, "it folds")]


CHECKS = {"links_ladder": ladder, "kinks_fold": fold}
