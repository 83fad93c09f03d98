#!/usr/bin/python3
"""Five equal springs side by side; bit 0 of the group is on the lower end of each, bits 1 to 5 are
on the upper ends: python3 make.py FILE"""
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from nanoweft import beams, generators, states  # noqa: E402

SEGMENTS, APART = 241, 260
position, orientation = generators.coil(beams.Spring(), SEGMENTS)
springs = [(position + [APART * k, 0, 0], orientation) for k in range(5)]
state = states.of_fibres(springs, [-200, -200, -100], [5 * APART, 400, 2500])
group = np.zeros((5, SEGMENTS), np.int32)
group[:, 0], group[:, -1] = 1, 2 << np.arange(5)
state.rows["group"] = group.ravel()
states.write(sys.argv[1], state)
