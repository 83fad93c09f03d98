#!/usr/bin/python3
"""A rod a hundred times as thick as a nanotube, two nanotubes straight across it, and between them
one of a kind without a pair law, as a state file: python3 make.py FILE"""
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from nanoweft import generators, rotations, states  # noqa: E402

RADIUS, SEGMENTS = 678.0, 161
GAP = generators.CROSSING - generators.LENGTH
top = RADIUS + generators.LENGTH / 2 + GAP
rod = (generators.straight((0, -2 * RADIUS, 0), 3, 1, 2 * RADIUS),
       rotations.rotation_about((0, 0, 1), np.full(3, np.pi / 2)))
q = rotations.no_rotation(SEGMENTS)
half = -0.5 * (SEGMENTS - 1) * generators.LENGTH
tubes = [(generators.straight((half, y, top), SEGMENTS), q) for y in (-200, 0, 200)]
state = states.of_fibres([rod, *tubes], [-1300, -2100, -800], [1300, 2100, 800])
states.write(sys.argv[1], states.of_kinds(state, ("rod", "cnt", "free"), (0, 1, 2, 1)))
