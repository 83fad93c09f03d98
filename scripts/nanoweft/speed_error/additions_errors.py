"""Errors of terms against the step, the stiffness or the number of points."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..verification import box, contacts, holders, surfaces, temperature


class Term(NamedTuple):
    """Whose error, of what and against what, at which settings; `cost`: name of its case."""
    name: str
    measure: str
    cost: str
    unit: str
    settings: tuple[float, ...]
    error: Callable[[float], float]


def spun(dt: float) -> float:
    """Three tubes that are twisted: work of both ends against the energy gained."""
    _, groups, energy = holders.spun(f"speed_spun_{dt:g}", holders.ROPE, dt)
    work = groups["tip_work"][-1] + groups["root_work"][-1]
    return float(work / (energy["total"][-1] - energy["total"][0]) - 1)


def warm(dt: float) -> float:
    """Stretching of the bonds of 100 fibres of 10 segments at 300 K, against kT/2 a bond."""
    table = temperature.warm(f"speed_warm_{dt:g}", round(dt), 100, 10)
    return float(temperature.stretching(table, 100, 10) - 1)


def crossing(law: str) -> Callable[[float], float]:
    """Force of two fibres of 60 A that cross, over the strongest pull."""
    def error(points: float) -> float:
        form = surfaces.LAWS[law]
        force, _ = surfaces.crossed(f"speed_{law}_{points:g}", law, "60, 60 A",
                                    f"-pair_points {points:g}")
        most, exact = (float(surfaces.pulled(form, 60.0, np.array(gap)))
                       for gap in (form.strongest, form.gap))
        return (force - exact) / most
    return error


WORK = "work of {}, against the energy that is gained"
STEPS, POINTS = (40, 20, 10), (2, 4, 8, 16)
TERMS = (
    Term("box, stretched", WORK.format("a lattice of springs, stretched by 40 %"),
         "a box that is stretched", "fs", STEPS, lambda dt: box.missed("stretched", dt)),
    Term("box, sheared", WORK.format("a lattice of springs, sheared by 40 %"),
         "a box that is sheared", "fs", STEPS, lambda dt: box.missed("sheared", dt)),
    Term("holders that spin", WORK.format("both ends of three twisted tubes"),
         "holders that spin", "fs", (24, 12, 6), spun),
    Term("temperature", "energy of a bond's stretching, against kT/2 (four standard errors: 0.02)",
         "temperature", "fs", (35, 20, 10), warm),
    Term("friction, step", "acceleration of a bar drawn over two rods, against Coulomb's law",
         "contact with friction in place of vdw", "fs", (20, 10, 5),
         lambda dt: contacts.drawn(f"speed_friction_{dt:g}", dt) - 1),
    Term("friction, stiffness", "the same, at 10 fs",
         "contact with friction in place of vdw", "GPa", (5, 20, 80),
         lambda modulus: contacts.drawn(f"speed_friction_stiff_{modulus:g}", 10,
                                        f"-contact_modulus {modulus:g}") - 1),
    *(Term(law, "force of a crossing, against the closed form, over the strongest pull",
           next_to, "points", POINTS, crossing(law))
      for law, next_to in (("hamaker", "hamaker in place of vdw"),
                           ("hydrogen", "hydrogen in place of vdw"),
                           ("capillary", "capillary and contact in place of vdw"))),
)
