"""Where bonds broke in a tension test: how far from the grips and the free edges."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..problems import Unusable
from ..states import LEFT_GRIP, RIGHT_GRIP, State

Array = NDArray[Any]


class Sheet:
    """The piece before the pull: its bonds' places, its grips and its free edges. Rows are in the
    order of fibre and index; a row stands for the bond to the next segment."""

    def __init__(self, name: str, state: State, edges: tuple[float, float] | None = None) -> None:
        order = state.in_order()
        self.fibre, self.index = state["fibre"][order], state["index"][order]
        place = state.whole[order]
        group = state["group"][order]
        held = [(group & bit) != 0 for bit in (LEFT_GRIP, RIGHT_GRIP)]
        if not (held[0].any() and held[1].any()):
            raise Unusable(f"{name}: no segments held by two grips (bits 28 and 29 of group)")
        self.axis, self.left, self.right = faces(state, *(place[one] for one in held))
        gripped = held[0] | held[1]
        between = place[~gripped]
        if self.right <= self.left or not len(between):
            raise Unusable(f"{name}: nothing lies between the grips")
        # The wider of the two other directions is the width: of the box where it goes round.
        spread = np.ptp(between, axis=0)
        spread = np.where(state.periodic, np.minimum(spread, state.box), spread)
        spread[self.axis] = -1
        self.across = int(np.argmax(spread))
        self.endless = bool(state.periodic[self.across])
        if edges and self.endless:
            raise Unusable(f"{name}: --edges, but the box is periodic along {'xyz'[self.across]},"
                           " so there are no free edges")
        self.low: float
        self.high: float
        self.low, self.high = edges or (
            (state.lower[self.across], state.upper[self.across]) if self.endless else
            (between[:, self.across].min(), between[:, self.across].max()))
        self.bond = np.flatnonzero((np.diff(self.fibre) == 0) & (np.diff(self.index) == 1))
        self.middle = np.array(place)
        self.middle[self.bond] = (place[self.bond] + place[self.bond + 1]) / 2
        # A bond of which both ends are held is not pulled; one that a grip's face passes is.
        self.pulled = ~gripped
        self.pulled[self.bond] |= ~gripped[self.bond + 1]
        by = [np.isin(self.fibre, self.fibre[side]) for side in held]
        self.gripped = np.select([by[0] & by[1], *by], ["both", "left", "right"], "neither")

    def broken(self, name: str, state: State) -> Array:
        order = state.in_order()
        if not (np.array_equal(state["fibre"][order], self.fibre)
                and np.array_equal(state["index"][order], self.index)):
            raise Unusable(f"{name}: other fibres than in the first snapshot")
        return np.asarray(state["bond_broken"][order] != 0)

    def from_left(self, rows: Array) -> Array:
        return np.asarray((self.middle[rows, self.axis] - self.left) / (self.right - self.left))

    def from_grip(self, rows: Array) -> Array:
        return inward(self.from_left(rows))

    def from_edge(self, rows: Array) -> Array:
        return inward((self.middle[rows, self.across] - self.low)
                      / max(self.high - self.low, 1e-300))


def faces(state: State, left: Array, right: Array) -> tuple[int, float, float]:
    """The direction of the pull and the inner faces of both grips along it: those that the program
    counts the strain by, else the innermost of the segments that they hold."""
    run = state.run
    if {"tension", "tension_axis", "tension_ends", "tension_grip", "tension_strain"} <= set(run):
        moved = 0.5 * run["tension_strain"][-1] * run["tension"][1]
        lower, upper = run["tension_ends"] + (run["tension_grip"][0] - moved) * np.array([1, -1])
        return int(run["tension_axis"][0]), float(lower), float(upper)
    axis = int(np.argmax(right.mean(axis=0) - left.mean(axis=0)))
    return axis, float(left[:, axis].max()), float(right[:, axis].min())


def inward(fraction: Array) -> Array:
    """Distance from the nearer of the ends 0 and 1; outside them it is zero."""
    return np.asarray(np.clip(np.minimum(fraction, 1 - fraction), 0, 0.5))
