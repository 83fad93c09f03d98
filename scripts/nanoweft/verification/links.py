"""Links and kinks: a ladder as a shear-lag beam, a tube that folds at its critical moment."""
import math

import numpy as np

from .. import states
from ..beams import TUBE, Ladder
from .bending import ends, straight
from .common import Row, new_folder, relative, simulate, write_state

T = TUBE.T
LINKS, KINKS = "links", "kinks"


def deflection(name, rung, force, segments, apart):
    """Of two fibres with a rung at every segment but the clamped first."""
    folder = new_folder(name)
    x, q = straight(segments - 1), np.tile([1.0, 0, 0, 0], (segments, 1))
    write_state(folder / "in.h5", [(x, q), (x + [0, apart, 0], q)], np.tile(ends(segments - 1), 2))
    states.link(folder / "in.h5", [[[0, k], [1, k]] for k in range(1, segments)])
    simulate(name, "-scene file -scene_file {dir}/in.h5 -pair none -relax_method fire "
             f"-relax_force {1e-5 * force!r} -ts_max_steps 2000000 -bc root,tip -root_group 0 "
             "-root_fix 1,1,1 -root_fix_rotation -tip_group 1 "
             f"-tip_force 0,{0.5 * force!r},0 -state_output {{dir}}/out.h5 "
             f"-link_stiffness 100,{rung!r},{-0.2 * rung!r},{0.1 * rung!r}")
    return states.read(folder / "out.h5")["position"][-1, 1] - apart


def ladder():
    rows, segments, apart = [], 41, 3 * T
    length = (segments - 1) * T
    force = 1e-6 * 6 * TUBE.EJ / length**2
    for rung in (20.0, 500.0, 2e4):
        # The rung at the tip stands for half as much length as the others.
        rows.append(relative(
            LINKS, f"ladder of two fibres, rungs with B2 = {rung:g} eV: deflection, A",
            Ladder(length, apart, rung, force).shear_lag(1 / T),
            deflection(f"link_ladder_{rung:g}", rung, force, segments, apart), 0.5 / (segments - 1),
            "half a rung in 40 at the tip"))
    return rows


def fold():
    """A tube of 12 segments under a couple at its end, below and above what it can carry."""
    rows, segments, curvature = [], 12, 1 / 275
    angle = 2 * math.sin(0.5 * curvature * T)
    stiffness = TUBE.EJ / T
    critical = stiffness * 1.05 * angle
    for share, name in ((0.9, "below"), (1.05, "above")):
        folder = new_folder(f"kink_{name}")
        x, q = straight(segments - 1), np.tile([1.0, 0, 0, 0], (segments, 1))
        write_state(folder / "in.h5", [(x, q)], ends(segments - 1))
        couple = share * critical
        simulate(folder.name, "-scene file -scene_file {dir}/in.h5 -pair none -damping_local 0.7 "
                 f"-ts_max_steps 20000 -fibre_kink_curvature {curvature!r} -bc root,tip "
                 "-root_group 0 -root_fix 1,1,1 -root_fix_rotation -tip_group 1 "
                 f"-tip_torque 0,0,{couple!r} -state_output {{dir}}/out.h5")
        first, last = states.read(folder / "out.h5")["orientation"][[0, -1]]
        turned = 2 * math.acos(min(1.0, abs(float(first @ last))))
        if name == "below":
            rows.append(relative(KINKS, "tube under 0.9 of its critical moment: angle, rad",
                                 (segments - 1) * math.asin(couple / stiffness), turned, 1e-3,
                                 "damped for 0.4 ns"))
        else:
            rows.append(Row(KINKS, "tube under 1.05 of its critical moment: angle beyond 1.5 rad",
                            1.5, turned, max(0.0, 1.5 - turned), 1e-12, "it folds"))
    return rows


CHECKS = {"links_ladder": ladder, "kinks_fold": fold}
