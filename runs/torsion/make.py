#!/usr/bin/python3
"""Seven tubes side by side, six around one, as a state file: python3 make.py FILE"""
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from nanoweft import states  # noqa: E402
from nanoweft.generators import hexagon, straight  # noqa: E402

# Positions of the tubes' axes, about the x axis, at the distance at which two tubes rest.
places = np.asarray(hexagon(17.07, 1))
fibres = [(straight((0, y, z), 61), np.tile([1.0, 0, 0, 0], (61, 1))) for y, z in places]
states.write(sys.argv[1], states.of_fibres(fibres, (-100, -100, -100), (1000, 100, 100),
                                           (0, 0, 0), False))
