#!/usr/bin/python3
"""Ladders of two (10,10) tubes, one above the other along y, with rungs at every segment, every
4th, 10th, 20th, at the tip, and without; bit 0 of the group is on their roots, bit 1 on their tips,
bit 2 on the upper tip of the first, bit 3 on its lower tube: python3 make.py FILE"""
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from nanoweft import generators, rotations, states  # noqa: E402

SEGMENTS, APART, EVERY = 41, 3 * generators.LENGTH, (1, 4, 10, 20, 40, 41)
q = rotations.no_rotation(SEGMENTS)
tubes = [(generators.straight((0, APART * upper, 120 * k), SEGMENTS), q)
         for k in range(len(EVERY)) for upper in (0, 1)]
state = states.of_fibres(tubes, [-100, -100, -100], [700, 400, 120 * len(EVERY)])
group = np.zeros((len(tubes), SEGMENTS), np.int32)
group[:, 0], group[:, -1] = 1, 2
group[1, -1] |= 4
group[0] |= 8
state.rows["group"] = group.ravel()
states.write(sys.argv[1], state)
states.link(sys.argv[1], [[[2 * k, rung], [2 * k + 1, rung]]
                          for k, every in enumerate(EVERY)
                          for rung in range(every, SEGMENTS, every)])
