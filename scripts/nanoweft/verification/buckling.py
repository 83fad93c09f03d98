"""Euler buckling: the load at which the lowest frequency vanishes, and the path beyond."""
import math

import numpy as np

from ..beams import TUBE
from . import elastica, linear
from .bending import EXTRAPOLATED, loaded, order_row
from .common import CURVES, Row, relative, richardson
from .vibration import bending_frequency, setup

T, EJ = TUBE.T, TUBE.EJ
SHARES = (0.96, 0.98, 0.99)


def euler(support, factor):
    rows, ratios = [], []
    for n in (10, 20, 40):
        held, groups, options = setup(support, n + 1)
        if support == "clamped-free":
            options = options.replace("-bc root", "-bc root,right") + " -right_group 1"
        P = factor * math.pi**2 * EJ / (n * T) ** 2
        expected = linear.critical_load(n + 1, held)
        squares = []
        for share in SHARES:
            load = share * P
            omega, chain = bending_frequency(f"euler_{support}_{n}_{share}", n + 1, held, 0, groups,
                                             options + f" -right_force {-load!r},0,0", load)
            squares.append((omega**2, chain**2))
        # omega^2 is nearly a straight line in P: a parabola's zero.
        zeros = [zero_of_parabola(np.array(SHARES) * P, np.array(column))
                 for column in zip(*squares)]
        ratios.append(zeros[0] / P)
        curvature = abs(zeros[1] / expected - 1)
    rows.append(relative("Euler load", f"{support}, eV/A, chain of 40 bonds", expected, zeros[0],
                         2 * curvature + 1e-8,
                         "extrapolation of squared frequencies to zero, and their round-off"))
    limit, doubt = richardson(ratios)
    rows.append(Row("Euler load", f"{support}, over Euler's, limit T = 0", 1.0, limit,
                    abs(limit - 1), doubt + 2 * curvature, "uncertainty of both extrapolations"))
    rows.append(order_row("Euler load", f"{support}: order in T", [abs(r - 1) for r in ratios]))
    CURVES.setdefault("convergence", {})[f"Euler {support}"] = [
        (n, abs(r - 1)) for n, r in zip((10, 20, 40), ratios)]
    return rows


def zero_of_parabola(x, y):
    """Where the parabola through three points vanishes, seen from the last of them."""
    slope = (y[2] - y[1]) / (x[2] - x[1])
    bend = (slope - (y[1] - y[0]) / (x[1] - x[0])) / (x[2] - x[0])
    z = x[2] - y[2] / slope
    for _ in range(50):
        value = y[2] + slope * (z - x[2]) + bend * (z - x[2]) * (z - x[1])
        z -= value / (slope + bend * (2 * z - x[1] - x[2]))
    return z


def beyond():
    rows = []
    for ratio in (1.1, 1.5, 2.5):
        alpha, x, y = elastica.buckled(ratio)
        exact = elastica.solve(-ratio * math.pi**2 / 4, 0, alpha)
        if abs(exact[2][-1] - y) > 1e-9:
            raise ArithmeticError("buckled elastica: integration and elliptic integrals differ")
        settled = [loaded(f"buckled_{ratio}", n, -ratio * math.pi**2 / 4, 0, exact)
                   for n in (10, 20, 40)]
        left = settled[-1][1]
        for k, (what, value) in enumerate((("x/L", x), ("y/L", y))):
            limit, doubt = richardson([found[k + 1] for found, _ in settled])
            rows.append(Row("buckled", f"{ratio} x Euler's load, clamped-free: {what}", value,
                            limit, abs(limit - value), doubt + 2 * left, EXTRAPOLATED))
        CURVES.setdefault("path", []).append((ratio, limit))
    return rows


CHECKS = {"euler_pinned": lambda: euler("pinned", 1.0),
          "euler_clamped": lambda: euler("clamped-free", 0.25), "buckled": beyond}
