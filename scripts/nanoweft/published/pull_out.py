"""The force that pulls one tube out of a bundle, beside the energy of the contact that is lost."""

from __future__ import annotations

import pathlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .. import generators, rotations, runs, states, tables
from ..problems import RunFailed
from ..verification.tubes import best, energy

OPTIONS = runs.ROOT / "runs" / "pull_out" / "run.opts"
SEGMENTS, POINTS = 40, 5
NANONEWTON = 1.602176634    # in an eV/A
NEIGHBOURS = {2: 1, 3: 2, 7: 6}
Array = NDArray[np.float64]


def places(tubes: int) -> Array:
    """Of the tubes' axes in units of their spacing; the first is the one to be pulled out."""
    return generators.innermost(1.0, tubes)


def per_length(where: Array, spacing: float) -> float:
    """Energy of endless tubes per length, eV/A."""
    first, second = np.triu_indices(len(where), 1)
    far = spacing * np.linalg.norm(where[first] - where[second], axis=1)
    return float(sum(energy(d, 0, POINTS, "smooth") for d in far))


def closed_form(tubes: int) -> tuple[float, float]:
    """Spacing at rest, A, and the energy per length that parts the first from the others, eV/A,
    when these keep their places."""
    spacing, whole = best(lambda d: per_length(places(tubes), d))
    return spacing, per_length(places(tubes)[1:], spacing) - whole


def start(file: states.Path, tubes: int) -> None:
    """Writes a bundle; bit 0 of the group is on the far end of the first tube, bit 1 on the near
    ends of the others."""
    x = [generators.straight((0, y, z), SEGMENTS)
         for y, z in closed_form(tubes)[0] * places(tubes)]
    q = rotations.no_rotation(SEGMENTS)
    state = states.of_fibres([(fibre, q) for fibre in x], [-100, -200, -200],
                             [SEGMENTS * generators.LENGTH + 500, 200, 200])
    state.rows["group"] = np.zeros(len(state), np.int32)
    state.rows["group"][SEGMENTS - 1] = 1
    state.rows["group"][SEGMENTS::SEGMENTS] = 2
    states.write(file, state)


def pulled(folder: pathlib.Path, tubes: int, more: Sequence[str] = ()) -> tuple[Array, Array]:
    """Way of the pulled end, A, and its force, eV/A, with `more` options."""
    start(folder / f"bundle_{tubes}.h5", tubes)
    done = runs.run(["-options_file", str(OPTIONS), "-scene_file", f"{folder}/bundle_{tubes}.h5",
                     "-group_monitor", f"ascii:{folder}/groups_{tubes}.csv",
                     "-state_output", f"{folder}/pulled_{tubes}.h5", *more])
    if done.returncode:
        raise RunFailed(f"{tubes} tubes: {done.stderr.strip() or done.stdout.strip()}")
    return force(folder / f"groups_{tubes}.csv")


def force(table: pathlib.Path) -> tuple[Array, Array]:
    """Way of the pulled end, A, and its force, eV/A, from the table of a run."""
    groups = tables.read(table)
    return groups["end_displacement_x"], groups["end_force_x"]


def mean(way: Array, force: Array, window: tuple[float, float] = (30, 130)) -> float:
    """Of the force, over this part of the way."""
    inside = (way >= window[0]) & (way <= window[1])
    return float(force[inside].mean())
