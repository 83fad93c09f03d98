#!/usr/bin/python3
"""Exponents of a table that measure.py prints, and their plot: plot.py TABLE -o FILE

Films of each length alternate between two lots; each lot has a height of its own, both the power.
Lines have the mean height."""
from __future__ import annotations

import argparse
import pathlib
import sys

import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from nanoweft.pictures import curve  # noqa: E402

Array = NDArray[np.float64]


def power(links: Array, found: Array) -> tuple[float, float, float]:
    """Exponent, its standard error, and the mean logarithm of the heights of both lots."""
    lot = np.arange(len(links)) % 2
    terms = np.column_stack([np.log(links), lot == 0, lot == 1]).astype(float)
    fit, rest, *_ = np.linalg.lstsq(terms, np.log(found), rcond=None)
    spread = np.linalg.inv(terms.T @ terms) * rest[0] / (len(found) - 3)
    return float(fit[0]), float(np.sqrt(spread[0, 0])), float(fit[1:].mean())


parser = argparse.ArgumentParser(description=__doc__,
                                 formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("table")
parser.add_argument("-o", "--output", required=True)
options = parser.parse_args()
segments, every, modulus, strength, _ = np.loadtxt(options.table).T
curves = []
for name, column in ("modulus", 1e3 * modulus), ("strength", 1e3 * strength):
    for length in np.unique(segments):
        links, found = every[segments == length], column[segments == length]
        slope, error, height = power(links, found)
        print(f"{length:.0f} segments: {name} ~ links^{slope:.1f} +- {error:.1f}")
        x = np.array([links.min(), links.max()])
        curves.append(curve.Curve(f"{name}, {length:.0f} segments",
                                  (x, np.exp(height) * x**slope), (links, found),
                                  f"power {slope:.1f}"))
curve.draw(options.output, ("links a tube", "MPa"), curves, xscale="log", yscale="log",
           ylim=(0.5, 3e5), xticks=[3, 4, 5, 6, 8, 11],
           xticklabels=["3", "4", "5", "6", "8", "11"])
