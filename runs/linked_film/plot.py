#!/usr/bin/python3
"""Exponents of a table that measure.py prints, and their plot: plot.py TABLE -o FILE

Films of a table alternate between two lots; each lot has a height of its own, both the power."""
from __future__ import annotations

import argparse
import pathlib
import sys

import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from nanoweft.pictures import curve  # noqa: E402

Array = NDArray[np.float64]


def power(links: Array, found: Array, lot: NDArray[np.int64]) -> tuple[float, float, Array]:
    """Exponent, its standard error, and the logarithms of the heights of both lots."""
    terms = np.column_stack([np.log(links), lot == 0, lot == 1]).astype(float)
    fit, rest, *_ = np.linalg.lstsq(terms, np.log(found), rcond=None)
    spread = np.linalg.inv(terms.T @ terms) * rest[0] / (len(found) - 3)
    return float(fit[0]), float(np.sqrt(spread[0, 0])), fit[1:]


parser = argparse.ArgumentParser(description=__doc__,
                                 formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("table")
parser.add_argument("-o", "--output", required=True)
options = parser.parse_args()
_, links, modulus, strength, _ = np.loadtxt(options.table).T
lot = np.arange(len(links)) % 2
curves = []
for name, found in ("modulus", 1e3 * modulus), ("strength", 1e3 * strength):
    slope, error, heights = power(links, found, lot)
    print(f"{name} ~ links^{slope:.1f} +- {error:.1f}")
    for number, height in enumerate(heights):
        x = np.array([3.0, 6.3])
        curves.append(curve.Curve(f"{name}, lot {number + 1}", (x, np.exp(height) * x**slope),
                                  (links[lot == number], found[lot == number]),
                                  f"power {slope:.1f}"))
curve.draw(options.output, ("links a tube", "MPa"), curves, xscale="log", yscale="log",
           ylim=(1, 3e4), xticks=[3, 4, 5, 6], xticklabels=["3", "4", "5", "6"])
