#!/usr/bin/python3
"""Plot of the tables that measure.py prints: python3 plot.py TABLE... -o FILE"""
from __future__ import annotations

import argparse
import pathlib
import sys

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from measure import HINGED  # noqa: E402
from nanoweft.pictures.style import BLUE, GREEN, INK, ORANGE  # noqa: E402

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("tables", nargs="+")
parser.add_argument("-o", "--output", required=True)
options = parser.parse_args()
figure, axes = plt.subplots(figsize=(7, 4.6), layout="constrained")
for name, colour in zip(options.tables, (BLUE, ORANGE, GREEN)):
    _, links, modulus, left, error = np.loadtxt(name, ndmin=2).T
    axes.errorbar(links - HINGED, modulus, modulus * error / left, fmt="o", color=colour, capsize=3,
                  label=pathlib.Path(name).stem)
x = np.array([0.9, 6])
axes.plot(x, 1.15e-3 * x**3, "--", color=INK, label="slope 3")
axes.set(xscale="log", yscale="log", xlabel=f"links per fibre - {HINGED}",
         ylabel="shear modulus, ES/L")
ticks = [0.5, 1, 2, 4, 6]
axes.set_xticks(ticks, map(str, ticks))
axes.set_xticks([], minor=True)
axes.legend()
figure.savefig(options.output, dpi=110)
