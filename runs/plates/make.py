#!/usr/bin/python3
"""A mat of straight fibres at random places and directions in a periodic plane, each laid flat on
those below it: python3 make.py FILE"""
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from nanoweft import rotations, states  # noqa: E402
from nanoweft.generators import LENGTH as T, straight  # noqa: E402

FIBRES, SEGMENTS, SIDE = 80, 30, 36 * T
random = np.random.default_rng(1)
places = np.zeros((0, 3))
fibres = []
for _ in range(FIBRES):
    x = straight((0, 0, 0), SEGMENTS)
    x -= x.mean(axis=0)
    turn = rotations.rotation_about((0, 0, 1), [random.uniform(0, np.pi)])
    x = x @ rotations.matrices(turn)[0].T + SIDE * np.append(random.random(2), 0)
    apart = places[:, None, :2] - x[:, :2]
    apart -= SIDE * np.round(apart / SIDE)
    below = places[(np.linalg.norm(apart, axis=2) < 1.25 * T).any(axis=1), 2]
    x[:, 2] = below.max(initial=-T / 2) + T
    places = np.concatenate([places, x])
    fibres.append((x, np.tile(turn, (SEGMENTS, 1))))
top = places[:, 2].max() + T / 2
states.write(sys.argv[1], states.of_fibres(fibres, [0, 0, -50], [SIDE, SIDE, top + 50], (1, 1, 0)))
print(f"the mat is {top:.1f} A high")
