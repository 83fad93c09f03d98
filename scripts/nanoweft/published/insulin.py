"""A fibril of insulin, bent across a gap and pulled until it breaks."""

from __future__ import annotations

import math
import pathlib

import numpy as np
from numpy.typing import NDArray

from .. import generators, rotations, runs, states, tables
from ..problems import RunFailed
from ..units import GPA

FOLDER = runs.ROOT / "runs" / "insulin"
RADIUS, YOUNG, STRENGTH, SCATTER = 40.0, 3.3, 0.6, 0.1    # of the preset: A, GPa, GPa, its share
T = 2 * RADIUS
SPAN, FIBRILS, GAGE = 40, 60, 40    # segments across the gap; fibrils, and bonds of each, pulled
AREA, SECOND = math.pi * RADIUS**2, math.pi / 4 * RADIUS**4
NANONEWTON = 1.602176634            # in an eV/A
Array = NDArray[np.float64]


def stiffness() -> float:
    """Of a beam clamped at both ends and loaded in its middle, force over deflection, eV/A^2."""
    return 192 * YOUNG * GPA * SECOND / (SPAN * T)**3


def beam(file: states.Path) -> None:
    """Writes a fibril; bit 0 of the group is on its ends, bit 1 on its middle."""
    x = generators.straight((0, 0, 0), SPAN + 1, spacing=T)
    state = states.of_fibres([(x, rotations.no_rotation(SPAN + 1))], [-500] * 3,
                             [SPAN * T + 500, 500, 500])
    state.rows["group"] = np.zeros(len(state), np.int32)
    state.rows["group"][[0, SPAN, SPAN // 2]] = 1, 1, 2
    states.write(file, state)


def deflection(folder: pathlib.Path, load: float) -> float:
    """Of the middle of the beam.h5 in a folder, A, under a load, eV/A."""
    done = runs.run(["-options_file", str(FOLDER / "bend.opts"), "-scene_file",
                     f"{folder}/beam.h5", "-middle_force", f"0,0,{load}",
                     "-state_output", f"{folder}/other.h5"])
    if done.returncode or "converged" not in done.stdout:
        raise RunFailed(f"load {load}: {done.stderr.strip() or done.stdout.strip()}")
    return float(states.read(folder / "other.h5")["position"][SPAN // 2, 2])


def fibrils(file: states.Path) -> None:
    """Writes fibrils side by side that do not touch; a grip takes the segment at each end."""
    side = math.ceil(math.sqrt(FIBRILS))
    x = [generators.straight((0, 4 * T * (k % side), 4 * T * (k // side)), GAGE + 1, spacing=T)
         for k in range(FIBRILS)]
    q = rotations.no_rotation(GAGE + 1)
    state = states.of_fibres([(fibre, q) for fibre in x], [-1000] * 3,
                             [1.5 * GAGE * T, 4 * T * side + 1000, 4 * T * side + 1000])
    states.write(file, state)


def broken(file: pathlib.Path) -> tuple[Array, Array]:
    """Strain, and the fibrils that are whole, from the table of the tension test."""
    table = tables.read(file)
    # The recoil of a broken fibril breaks another of its bonds now and then.
    return table["strain"], np.maximum(FIBRILS - table["broken_bonds"], 0)


def mean_strength(strain: Array, whole: Array) -> float:
    """Mean stress at which a fibril breaks, GPa: the area under the share that is whole."""
    return float(YOUNG * np.trapz(whole / FIBRILS, strain))


def survival(stress: Array) -> Array:
    """Share of the fibrils that bear a stress, over STRENGTH, when each of GAGE bonds has a
    critical strain of its own."""
    below = [0.5 * math.erfc((1 - x) / SCATTER / math.sqrt(2)) for x in stress]
    return np.asarray((1 - np.array(below))**GAGE)


def weakest_link() -> float:
    """Mean strength of such fibrils, GPa."""
    x = np.linspace(0, 2, 4001)
    return STRENGTH * float(np.trapz(survival(x), x))
