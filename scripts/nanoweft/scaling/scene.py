"""What a partition needs of fibres in space."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import generators, states
from ..generators import LENGTH
from ..problems import Unusable
from ..states import State

Array = NDArray[Any]
POINTS, CUTOFF = 3, 4 * LENGTH


def list_range(skin: float) -> float:
    return CUTOFF + LENGTH * (POINTS - 1) / POINTS + skin


@dataclass
class Scene:
    position: Array   # [N, 3], inside the box where periodic
    fibre: Array      # number of the fibre, 0, 1, 2, ...
    index: Array      # place along it
    closed: Array     # per fibre
    lower: Array
    upper: Array
    periodic: Array

    def __post_init__(self) -> None:
        side = self.upper - self.lower
        wrapped = self.lower + (self.position - self.lower) % side
        self.position = np.where(self.periodic, wrapped, self.position)
        self.lower = np.where(self.periodic, self.lower, self.position.min(0))
        self.upper = np.where(self.periodic, self.upper, self.position.max(0))

    def __len__(self) -> int:
        return len(self.fibre)

    def nearest(self, d: Array) -> Array:
        side = np.where(self.periodic, self.upper - self.lower, np.inf)
        return np.asarray(d - np.where(self.periodic, self.upper - self.lower, 0)
                          * np.rint(d / side))

    def bonds(self) -> tuple[Array, Array]:
        """Both ends of every bond."""
        i = np.flatnonzero(self.fibre[1:] == self.fibre[:-1])
        j = i + 1
        first = np.flatnonzero(self.index == 0)
        last = np.append(first[1:], len(self)) - 1
        ring = self.closed[self.fibre[first]]
        return np.append(i, first[ring]), np.append(j, last[ring])


def of_state(state: State) -> Scene:
    names, fibre = np.unique(state["fibre"], return_inverse=True)
    return Scene(state["position"], fibre, state["index"], np.isin(names, state.closed),
                 state.lower, state.upper,
                 state.periodic)


def read(file: str) -> Scene:
    """A state of (10,10) tubes, whose range of forces the model takes; Unusable else."""
    state = states.read(file, ("position", "fibre", "index"))
    if state.units != "nano" or any(abs(r - LENGTH / 2) > 0.01 for r in state.kinds.radii):
        raise Unusable(f"{file}: of other fibres than (10,10) tubes, whose range of forces the"
                       " model takes")
    if state.tilt.any():
        raise Unusable(f"{file}: its box is tilted by shear, which the model does not know")
    return of_state(state)


def weave(fibres: int, segments: int, periodic: bool = False) -> Scene:
    return of_state(generators.weave(fibres, segments, periodic))
