"""Laws of surfaces: fibres crossed at a right angle and parallel ones, equal and unequal, with the
points that the program chooses.

Crossed fibres against the closed form they are made from: force 2 pi R e(g) or F(g), R = sqrt(a b);
parallel ones against the integral of w along both."""
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from .common import Array, Row, new_folder, relative
from .kinds import Tube, evaluate, integral, row_of

FAMILY = "surfaces"
THICK, THIN = Tube(60.0, 30.0), Tube(20.0, 20.0)
PAIRS = {"60, 60 A": (THICK, THICK), "60, 20 A": (THICK, THIN)}
CHOSEN = "points that the program chooses"


class Law(NamedTuple):
    """Force of a crossing that pulls, at gaps before the switch, over R; where it is compared."""
    options: str
    pull: Callable[[Array, float], Array]   # of gap and R
    strongest: float                        # gap where it is largest
    gap: float
    gap_switch: float
    gap_cutoff: float


def hamaker(g: Array, _: float) -> Array:
    return 2 * math.pi * 0.5 / (12 * math.pi * g**2) * (1 - (3 / g)**6 / 4)


def hydrogen(g: Array, _: float) -> Array:
    return -2 * math.pi * 0.02 * (5 * (2.9 / g)**12 - 6 * (2.9 / g)**10)


VOLUME, ANGLE = 20000.0, 0.5


def capillary(g: Array, R: float) -> Array:
    return 4 * math.pi * 0.0045 * math.cos(ANGLE) * (1 - g / np.sqrt(g**2 + VOLUME / (math.pi * R)))


RUPTURE = (1 + ANGLE / 2) * VOLUME**(1 / 3)
LAWS = {
    "hamaker": Law("-hamaker_constant 0.5 -hamaker_gap 3 -pair_gap_cutoff 60", hamaker,
                   3.0, 4.0, 42.0, 60.0),
    "hydrogen": Law("-hydrogen_energy 0.02 -hydrogen_gap 2.9", hydrogen,
                    2.9, 3.3, 0.7 * 3.75 * 2.9, 3.75 * 2.9),
    "capillary": Law(f"-capillary_tension 0.0045 -capillary_angle {ANGLE} "
                     f"-capillary_volume {VOLUME}", capillary, 0.0, 5.0, 0.7 * RUPTURE, RUPTURE)}


def step(x: Array) -> Array:
    x = np.clip(x, 0, 1)
    return 1 - x**3 * (10 - 15 * x + 6 * x**2)


def pulled(law: Law, R: float, g: Array) -> Array:
    """The force that pulls two crossed fibres together, with its switch."""
    width = law.gap_cutoff - law.gap_switch
    s, g = step((g - law.gap_switch) / width), np.asarray(g, float)
    if law.pull is not capillary:
        return R * law.pull(g, R) * s
    # Here the switch multiplies the energy, of which the force is the slope.
    b, x = VOLUME / (math.pi * R), np.clip((g - law.gap_switch) / width, 0, 1)
    energy = -4 * math.pi * 0.0045 * math.cos(ANGLE) * R * (np.sqrt(g**2 + b) - g)
    return R * law.pull(g, R) * s + energy * -30 * (x * (1 - x))**2 / width


def crossed(folder: str, name: str, pair: str, options: str = "") -> tuple[float, float]:
    """Force between two fibres that cross, which pulls, and its energy."""
    law, (a, b) = LAWS[name], PAIRS[pair]
    touch = a.radius + b.radius
    d = touch + law.gap
    reach = math.sqrt((touch + law.gap_cutoff)**2 - d**2)
    fibres = row_of(a, (0, 0, 0), reach + 2 * a.T), row_of(b, (0, 0, d), reach + 2 * b.T, 1, 0.2)
    state, found = evaluate(new_folder(folder), (a, b), fibres,
                            f"-pair {name} {law.options} {options}")
    return -state["force"][state["fibre"] == 1, 2].sum(), found


def crossing(name: str, pair: str) -> list[Row]:
    law, (a, b) = LAWS[name], PAIRS[pair]
    R = math.sqrt(a.radius * b.radius)
    energy = -integral(lambda g: pulled(law, R, g), law.gap, law.gap_cutoff)
    force, found = crossed(f"surfaces_crossing_{name}_{b.radius:g}", name, pair)
    most, expected = float(pulled(law, R, law.strongest)), float(pulled(law, R, law.gap))
    what = f"{name}, {pair}, crossing, gap {law.gap:g} A"
    return [Row(FAMILY, f"{what}, force, eV/A (error over the strongest pull)", expected, force,
                abs(force - expected) / most, 0.03, CHOSEN),
            relative(FAMILY, f"{what}, energy, eV", energy, found, 0.01, CHOSEN)]


def parallel(name: str, pair: str) -> Row:
    law, (a, b) = LAWS[name], PAIRS[pair]
    R, touch = math.sqrt(a.radius * b.radius), a.radius + b.radius
    gap = law.strongest or law.gap
    d = touch + gap
    reach = math.sqrt((touch + law.gap_cutoff)**2 - d**2)

    def along(z: Array) -> Array:
        r = np.hypot(d, z)
        return -pulled(law, R, r - touch) / (2 * math.pi * r)

    short = row_of(a, (0, 0, 0), 100)
    length = len(short[0]) * a.T
    fibres = short, row_of(b, (0, d, 0), length / 2 + reach + 2 * b.T)
    energy = evaluate(new_folder(f"surfaces_parallel_{name}_{b.radius:g}"), (a, b), fibres,
                      f"-pair {name} {law.options}")[1]
    return relative(FAMILY, f"{name}, {pair}, parallel, gap {gap:g} A, eV/A: integral over both",
                    2 * integral(along, 0, reach), energy / length, 0.01, CHOSEN)


def surfaces() -> list[Row]:
    return [row for name in LAWS for pair in PAIRS
            for row in (*crossing(name, pair), parallel(name, pair))]


CHECKS = {"surfaces": surfaces}
