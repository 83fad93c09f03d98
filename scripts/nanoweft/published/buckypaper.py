"""A piece of buckypaper, random tubes in a plane, pressed to several porosities."""

from __future__ import annotations

import math
import pathlib
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import generators, rotations, states, tables
from ..generators import LENGTH

TUBES, SEGMENTS, SIDE, HEIGHT = 120, 27, 400.0, 410.0   # lengths of the box in A
# A tube takes the space up to half of the gap between graphite's layers.
SOLID = TUBES * SEGMENTS * LENGTH * math.pi * (6.78 + 1.675)**2
Array = NDArray[np.float64]


def start(file: states.Path, seed: int = 1) -> None:
    """Writes straight tubes at random places of a periodic box, in random directions of its plane;
    they overlap."""
    random = np.random.default_rng(seed)
    fibres = []
    for _ in range(TUBES):
        x = generators.straight((0, 0, 0), SEGMENTS)
        turn = rotations.rotation_about((0, 0, 1), [random.uniform(0, np.pi)])
        x = (x - x.mean(axis=0)) @ rotations.matrices(turn)[0].T
        fibres.append((x + random.random(3) * (SIDE, SIDE, HEIGHT),
                       np.tile(turn, (SEGMENTS, 1))))
    states.write(file, states.of_fibres(fibres, [0] * 3, [SIDE, SIDE, HEIGHT], (1, 1, 1)))


def porosity(height: Array) -> Array:
    return np.asarray(1 - SOLID / (SIDE**2 * height))


class Leg(NamedTuple):
    porosity: float
    stress: float       # halfway back, GPa
    modulus: float      # in the second half of the way back, GPa
    lateral: float      # change of the stress in the plane, whose strain is held, over that across


def legs(table: pathlib.Path) -> list[Leg]:
    """What each unloading in a table of the box says."""
    box = tables.read(table)
    strain, stress = box["strain_z"], -box["zz_GPa"]
    plane = -0.5 * (box["xx_GPa"] + box["yy_GPa"])
    up = np.concatenate([[False], np.diff(strain) > 1e-9, [False]])
    begins, ends = np.flatnonzero(~up[:-1] & up[1:]), np.flatnonzero(up[:-1] & ~up[1:])
    found = []
    for begin, end in zip(begins, ends):
        # In the first half of the way back what the speed had added goes.
        half = 0.5 * (strain[begin] + strain[end - 1])
        rest = begin + int(np.searchsorted(strain[begin:end], half))
        height = HEIGHT * (1 + strain[rest:end])
        across, beside = (np.polyfit(np.log(height), part[rest:end], 1)[0]
                          for part in (stress, plane))
        found.append(Leg(float(porosity(height[0])), float(stress[rest]), float(-across),
                         float(beside / across)))
    return found


def mean(lots: Sequence[Sequence[Leg]]) -> tuple[Array, Array]:
    """Mean of lots pressed alike, and its standard error, which one lot does not tell: a row for
    each leg that all have."""
    legs = min(map(len, lots))
    every = np.array([lot[:legs] for lot in lots]).reshape(len(lots), legs, len(Leg._fields))
    error = (every.std(axis=0, ddof=1) / math.sqrt(len(lots)) if len(lots) > 1
             else np.full(every.shape[1:], math.nan))
    return every.mean(axis=0), error


def shown(value: float, error: float, digits: int) -> str:
    """A mean with its error, if that is known and less."""
    if error >= abs(value):
        return "not told from 0"
    return f"{value:.{digits}f}" + ("" if math.isnan(error) else f" +- {error:.{digits}f}")


def power(porosity: Array, modulus: Array, error: Array) -> tuple[float, float]:
    """Exponent of the solid share between two moduli, and its error."""
    width = math.log((1 - porosity[1]) / (1 - porosity[0]))
    return (math.log(modulus[1] / modulus[0]) / width,
            math.hypot(*(error / modulus)) / width)
