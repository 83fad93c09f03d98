#!/usr/bin/python3
"""A limp fibre over a mandrel by half a turn; bit 0 of the group is on the end that is loaded,
bit 1 on the end that is held: python3 make.py FILE"""
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from nanoweft import rotations, states  # noqa: E402
from nanoweft.generators import LENGTH as T  # noqa: E402

RADIUS, FREE = 150 + T / 2 - 0.02, 14 * T
s = np.arange(0.5 * T, 2 * FREE + np.pi * RADIUS, T) - FREE
angle = np.clip(s / RADIUS, 0, np.pi)
beyond = s - angle * RADIUS
x = np.stack([RADIUS * np.sin(angle) + beyond * np.cos(angle),
              RADIUS * np.cos(angle) - beyond * np.sin(angle), 0 * s], axis=1)
state = states.of_fibres([(x, rotations.rotation_about((0, 0, 1), -angle))], [-600, -300, -300],
                         [300, 300, 300])
state.rows["group"] = np.zeros(len(s), np.int32)
state.rows["group"][[0, -1]] = 1, 2
states.write(sys.argv[1], state)
