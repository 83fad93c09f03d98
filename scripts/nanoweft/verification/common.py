"""Rows of the table, and runs of the program in folders of their own."""

from __future__ import annotations

import dataclasses
import glob
import math
import os
import pathlib
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import runs, states
from ..problems import RunFailed
from ..rotations import matrices, rotation_about

Array = NDArray[Any]
RESULTS = pathlib.Path(os.environ.get("NANOWEFT_RESULTS",
                                      runs.ROOT / "results/verification")).absolute()
CURVES: dict[str, Any] = {}  # what the plot shows, by name


@dataclasses.dataclass
class Row:
    """One comparison: of what, expected and measured,
    and the bound on the error with its reason."""
    family: str
    name: str
    expected: float
    measured: float
    error: float
    bound: float
    reason: str

    @property
    def holds(self) -> bool:
        return bool(self.error <= self.bound)


def relative(family: str, name: str, expected: float, measured: float, bound: float,
             reason: str) -> Row:
    return Row(family, name, expected, measured, abs(measured / expected - 1), bound, reason)


def richardson(f: Sequence[float]) -> tuple[float, float]:
    """Limit of three values, each at twice the number of segments, and its uncertainty.

    With errors a/N^2 + b/N^4 the extrapolated pairs differ by 15 times the error of the last.
    Half of that factor is left as a margin for the terms beyond."""
    first, last = (4 * f[1] - f[0]) / 3, (4 * f[2] - f[1]) / 3
    return last, abs(last - first) / 7.5


def order(errors: Sequence[float]) -> float:
    return math.log2(abs(errors[-2] / errors[-1]))


def in_plane(angle: ArrayLike) -> Array:
    """Orientations of segments in the xz plane whose axes make these angles with x."""
    return rotation_about((0, 1, 0), -np.asarray(angle))


def angles_in_plane(state: states.State) -> Array:
    e1 = matrices(state["orientation"])[:, :, 0]
    return np.asarray(np.unwrap(np.arctan2(e1[:, 2], e1[:, 0])))


def write_state(file: states.Path, fibres: Sequence[states.Fibre], groups: ArrayLike | None = None,
                period: float | None = None, closed: bool = False) -> None:
    """fibres: positions and orientations; period: length of a box periodic along x."""
    x = np.concatenate([np.asarray(position) for position, _ in fibres])
    lower, upper = x.min(0) - 100, x.max(0) + 100
    if period:
        lower[0], upper[0] = 0, period
    state = states.of_fibres(fibres, lower, upper, (bool(period), 0, 0), closed)
    if groups is not None:
        state.rows["group"] = np.asarray(groups, np.int32)
    states.write(file, state)


def simulate(name: str, options: str) -> pathlib.Path:
    """Runs the program in results/verification/NAME; {dir} in the options is that folder."""
    folder = RESULTS / name
    folder.mkdir(parents=True, exist_ok=True)
    words = [word.format(dir=os.path.relpath(folder, runs.ROOT)) for word in options.split()]
    done = runs.run(words)
    (folder / "log.txt").write_text(" ".join(map(str, done.args)) + "\n" + done.stdout
                                    + done.stderr)
    if done.returncode:
        last = (done.stderr.strip() or done.stdout.strip()).splitlines()[-1:]
        raise RunFailed(f"{name}: status {done.returncode}: {' '.join(last)} "
                        f"(see {folder}/log.txt)")
    return folder


def new_folder(name: str) -> pathlib.Path:
    folder = RESULTS / name
    folder.mkdir(parents=True, exist_ok=True)
    for old in glob.glob(str(folder / "*")):
        os.remove(old)
    return folder


class Rest(NamedTuple):
    """When a state counts as settled: change of the elastic energy, and at most so many steps."""
    tolerance: float = 1e-10
    steps: int = 2000000


def settle(name: str, fibres: Sequence[states.Fibre], groups: ArrayLike | None, options: str,
           interval: float, rest: Rest = Rest()) -> states.State:
    """Damps a state to rest: until the elastic energy no longer changes in `interval` steps."""
    folder = new_folder(name)
    write_state(folder / "in.h5", fibres, groups)
    simulate(name, "-scene file -scene_file {dir}/in.h5 -damping_local 0.6 "
             f"-relax_tolerance {rest.tolerance} -relax_interval {int(interval)} "
             f"-ts_max_steps {rest.steps} "
             "-state_output {dir}/out.h5 " + options)
    return states.read(folder / "out.h5")
