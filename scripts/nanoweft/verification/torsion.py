"""A straight fibre twisted by a couple at its end: M = B4 sin(a) for a twist of a in each bond."""
import math

import numpy as np

from ..beams import TUBE
from ..rotations import matrices
from .common import Rest, in_plane, relative, settle
from .bending import ends, straight


def twist():
    rows = []
    for n, moment, what in ((20, 1e-3 * TUBE.GJp / (20 * TUBE.T), "small couple: M L/(G Jp)"),
                            (20, 0.1 * TUBE.B4, "M = 0.1 B4"), (4, 0.5 * TUBE.B4, "M = 0.5 B4"),
                            (2, 0.9 * TUBE.B4, "M = 0.9 B4")):
        state = settle(f"twist_{n}_{moment:.3g}", [(straight(n), in_plane(np.zeros(n + 1)))],
                       ends(n),
                       "-pair none -bc root,tip -root_group 0 -root_fix 1,1,1 -root_fix_rotation "
                       f"-tip_group 1 -tip_torque {moment!r},0,0 -tip_ramp 20000", 2000,
                       Rest(1e-13))
        frames = matrices(state["orientation"])
        angle = np.unwrap(np.arctan2(frames[:, 2, 1], frames[:, 1, 1]))[-1]
        if what.startswith("small"):
            expected = moment * n * TUBE.T / TUBE.GJp
            rows.append(relative("torsion", f"{what}, rad, {n} bonds", expected, angle,
                                 expected**2 / n**2 / 6 + 1e-8,
                                 "third order of the sine, and settling"))
        else:
            rows.append(relative("torsion", f"{what}, rad, {n} bonds: sine law",
                                 n * math.asin(moment / TUBE.B4), angle, 1e-8,
                                 "settling: the energy no longer changes by 1e-13"))
    return rows


CHECKS = {"torsion": twist}
