"""Which tubes run side by side as bundles."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..generators import LENGTH
from ..problems import Unusable
from ..states import State, find_tubes
from .sample import Lacking

Array = NDArray[Any]

PARALLEL = 0.9   # |cosine| above which two segments run side by side
SLICE = 2.5      # half the thickness of a cross-section in the longest segments: two to either side
SIDES = {"left": (0, -1), "right": (0, 1), "bottom": (1, -1), "top": (1, 1)}
# Sizes of bundles that are counted together.
CLASSES: list[tuple[int, int | None]] = [(1, 1), (2, 2), (3, 4), (5, 9), (10, 20), (21, 40),
                                         (41, None)]
CHUNK = 20_000


def named(low: int, high: int | None) -> str:
    """A class of sizes as people write it."""
    return f"{low}" if low == high else f"over {low - 1}" if high is None else f"{low}-{high}"


def usual_distance(state: State, given: Sequence[float] = ()) -> float:
    """Distance between axes up to which fibres run side by side: 20 A for (10,10) tubes, which
    fibres count as where nothing tells their radius, and as large a gap for others of one radius,
    one `given` or the run's. Lacking says why there is no telling."""
    radii = set(state.kinds.thickness(given, LENGTH / 2).tolist())
    reasons = ([f"in {state.units} units"] * (state.units != "nano")
               + ["of fibres of different radii"] * (len(radii) > 1))
    if reasons:
        raise Lacking(" and ".join(reasons))
    return float(2 * radii.pop() + 20 - LENGTH)


class Fabric:
    """Places and axes of the segments, and for each which ones are next to it: along its fibre, and
    side by side with it on others."""

    def __init__(self, state: State, distance: float, length: float | None = None) -> None:
        self.position, first, second, _ = find_tubes(state)
        if state.tilt.any():
            raise Unusable("its box is tilted by shear, across which neighbours are not looked for")
        bonded = first != second
        first, second = first[bonded], second[bonded]
        self.fibre = np.unique(state["fibre"], return_inverse=True)[1]
        self.index = state["index"]
        self.box = np.where(state.periodic, state.box, np.inf)
        along = self.across(self.position[second] - self.position[first])
        if not len(along) and not length:
            raise Unusable("no bonds to take a segment's length from; give --length")
        # Of each segment: the median bond of its kind, since kinds may have segments of their own.
        self.lengths = np.full(len(self.position), length or 0.0)
        if not length:
            bond, kind = np.linalg.norm(along, axis=1), state["kind"]
            for k in np.unique(kind[first]):
                self.lengths[kind == k] = np.median(bond[kind[first] == k])
        self.length = float(self.lengths.max())  # the longest
        if distance > 5 * self.length:
            raise Unusable(f"a distance of {distance:g} is more than five segments")
        self.axis = np.zeros_like(self.position)
        for row in (first, second):
            np.add.at(self.axis, row, along)
        self.axis /= np.maximum(np.linalg.norm(self.axis, axis=1, keepdims=True), 1e-300)
        a, b = self.touching(distance)
        # Fibres count, not how many of their segments are in reach.
        fibres = self.fibre.max() + 1
        self.neighbours = np.bincount(np.unique(a * fibres + self.fibre[b]) // fibres,
                                      minlength=len(self.fibre))
        a, b = np.concatenate([a, first, second]), np.concatenate([b, second, first])
        order = np.argsort(a, kind="stable")
        self.next = b[order]
        self.until = np.cumsum(np.bincount(a, minlength=len(self.fibre)))
        self.count = np.diff(self.until, prepend=0)

    def across(self, vector: Array) -> Array:
        """The nearest image of a vector through the periodic boundaries."""
        for k in np.flatnonzero(np.isfinite(self.box)):
            vector[:, k] -= self.box[k] * np.round(vector[:, k] / self.box[k])
        return vector

    def touching(self, distance: float) -> tuple[Array, Array]:
        """Pairs of segments side by side, both ways round."""
        found = []
        for a, b in self.near(np.hypot(distance, 0.75 * self.length)):
            differ = self.fibre[a] != self.fibre[b]
            a, b = a[differ], b[differ]
            cosine = np.einsum("ij,ij->i", self.axis[a], self.axis[b])
            parallel = np.abs(cosine) > PARALLEL
            a, b, cosine = a[parallel], b[parallel], cosine[parallel]
            apart = self.across(self.position[b] - self.position[a])
            axis = self.axis[a] + np.sign(cosine)[:, None] * self.axis[b]
            axis /= np.linalg.norm(axis, axis=1, keepdims=True)
            shift = np.einsum("ij,ij->i", apart, axis)
            aside = np.einsum("ij,ij->i", apart, apart) - shift**2
            # They overlap by a quarter of the shorter one: those of one length lie 0.75 T apart.
            one, other = self.lengths[a], self.lengths[b]
            reach = 0.5 * np.maximum(one, other) + 0.25 * np.minimum(one, other)
            side = (np.abs(shift) <= reach) & (aside < distance**2)
            found.append((a[side], b[side]))
        a, b = (np.concatenate(rows) for rows in zip(*found))
        a, b = np.divmod(np.unique(a * len(self.fibre) + b), len(self.fibre))
        return np.concatenate([a, b]), np.concatenate([b, a])

    def near(self, reach: float) -> Iterator[tuple[Array, Array]]:
        """Candidates (a < b) for pairs closer than `reach`, by cells at least that wide."""
        low = self.position.min(axis=0)
        wrap = np.isfinite(self.box)
        extent = np.where(wrap, self.box, np.ptp(self.position, axis=0) + reach)
        cells = np.maximum(np.floor(extent / reach), 1).astype(np.int64)
        cell = np.floor((self.position - low) / extent * cells).astype(np.int64)
        cell = np.where(wrap, cell % cells, cell)
        key = self.number(cell, cells)
        order = np.argsort(key, kind="stable")
        key, cell = key[order], cell[order]
        for step in np.ndindex(3, 3, 3):
            other = cell + np.array(step) - 1
            other = np.where(wrap, other % cells, other)
            inside = np.flatnonzero(((other >= 0) & (other < cells)).all(axis=1))
            wanted = self.number(other[inside], cells)
            begin, end = np.searchsorted(key, wanted), np.searchsorted(key, wanted, "right")
            a = np.repeat(order[inside], end - begin)
            b = order[ranges(begin, end - begin)]
            yield a[a < b], b[a < b]

    @staticmethod
    def number(cell: Array, cells: Array) -> Array:
        return np.asarray((cell[:, 0] * cells[1] + cell[:, 1]) * cells[2] + cell[:, 2])

    def sizes(self, seeds: Array) -> Array:
        """The number of fibres in the bundle that passes each of the given segments."""
        return np.concatenate([self.sizes_of(seeds[k:k + CHUNK])
                               for k in range(0, len(seeds), CHUNK)])

    def sizes_of(self, seeds: Array) -> Array:
        """Search from all seeds at once; a member is coded as seed * rows + row."""
        rows = len(self.fibre)
        front = members = np.arange(len(seeds)) * rows + seeds
        while len(front):
            seed, row = np.divmod(front, rows)
            onward = self.next[ranges(self.until[row] - self.count[row], self.count[row])]
            seed = np.repeat(seed, self.count[row])
            code = np.unique(seed * rows + onward)
            seed, row = np.divmod(code, rows)
            start = seeds[seed]
            apart = self.across(self.position[row] - self.position[start])
            inside = np.abs(np.einsum("ij,ij->i", apart, self.axis[start])) <= SLICE * self.length
            code = code[inside]
            place = np.minimum(np.searchsorted(members, code), len(members) - 1)
            front = code[members[place] != code]
            members = np.sort(np.concatenate([members, front]), kind="stable")
        seed, row = np.divmod(members, rows)
        width = self.fibre.max() + 1
        return np.bincount(np.unique(seed * width + self.fibre[row]) // width, minlength=len(seeds))


def ranges(begin: Array, count: Array) -> Array:
    """begin[0], begin[0] + 1, ... count[0] of them, then those of begin[1], ..."""
    until = np.cumsum(count)
    return np.asarray(np.arange(until[-1] if len(until) else 0)
                      + np.repeat(begin - until + count, count))


def edge_bundles(fabric: Fabric, seeds: Array, sizes: Array, strip: float,
                 every: int) -> dict[str, Array]:
    """For each free side the largest bundle that runs along it, within the outermost strip, at
    evenly spaced places of the middle four fifths of the side."""
    place, axis = fabric.position[seeds], np.abs(fabric.axis[seeds])
    # Tubes that came off alone are no part of the piece.
    piece = place[sizes > 1] if (sizes > 1).any() else place
    low, high = piece.min(axis=0), piece.max(axis=0)
    extent = high - low
    result = {}
    for side, (normal, sign) in SIDES.items():
        if np.isfinite(fabric.box[normal]):  # periodic: there is no edge
            continue
        run = 1 - normal
        inward = place[:, normal] - low[normal] if sign < 0 else high[normal] - place[:, normal]
        along = place[:, run] - low[run]
        chosen = ((inward >= 0) & (inward <= strip * extent[normal])
                  & (axis[:, run] > axis[:, normal])
                  & (along > 0.1 * extent[run]) & (along < 0.9 * extent[run]))
        station = (along[chosen] / (every * fabric.length)).astype(int)
        largest = np.zeros(station.max(initial=-1) + 1, int)
        np.maximum.at(largest, station, sizes[chosen])
        result[side] = largest[largest > 0]
    return result
