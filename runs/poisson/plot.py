#!/usr/bin/python3
"""Plot of Poisson's ratio from tables of measure.py: plot.py SHARE_TABLE WAVE_TABLE FILE"""
from __future__ import annotations

import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from nanoweft.pictures import curve  # noqa: E402

share, wave = (np.loadtxt(name) for name in sys.argv[1:3])
ends = np.array([0.0, 1.0])
curve.draw(sys.argv[3], ("share of thick tubes, or swing of a tube's direction in rad",
                         "Poisson's ratio"),
           [curve.Curve("buckypaper, first and last", (ends, [0.06, -0.20]), ([], []), "published"),
            curve.Curve("straight tubes, over the share", ([], []), (share[:, 0], share[:, -2])),
            curve.Curve("wavy tubes, over the swing", ([], []), (wave[:, 1], wave[:, -2]))],
           ylim=(-0.25, 0.45))
