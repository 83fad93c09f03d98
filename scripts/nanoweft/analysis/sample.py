"""The fibres of a snapshot as chains of straight pieces, through periodic boundaries."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kinds import NUMBERS
from ..problems import Unusable
from ..rotations import matrices
from ..states import State, find_bonds
from .findings import Settings

Array = NDArray[Any]


class Lacking(Unusable):
    """The file does not have what an analysis needs."""


@dataclass
class Pieces:
    """Straight pieces of the fibres' axes, a row each: bonds, and half a segment beyond each end
    of a chain. Rows follow the fibres."""
    begin: Array  # [P,3]
    vector: Array  # [P,3], from begin to end
    row: Array  # [P]: of the segment that the piece starts from or ends at
    next: Array  # [P]: the piece that goes on from here, or -1
    share: Array  # [P]: of the mass of a segment that it stands for: a bond one, an end a half

    def __len__(self) -> int:
        return len(self.row)

    @functools.cached_property
    def length(self) -> Array:
        return np.asarray(np.linalg.norm(self.vector, axis=1))

    @property
    def middle(self) -> Array:
        return np.asarray(self.begin + 0.5 * self.vector)

    @property
    def direction(self) -> Array:
        return np.asarray(self.vector / np.maximum(self.length, 1e-300)[:, None])


class Sample:
    """Segments in rows along the fibres. A chain is what whole bonds hold together: a fibre, a ring
    or what breaks have left of it."""

    def __init__(self, name: str, state: State, settings: Settings) -> None:
        self.name, self.state, self.settings = name, state, settings
        self.fields: dict[str, Array] = {}  # of /field, in the state's order
        self.box = np.where(state.periodic, state.box, np.inf)
        if not (state.box > 0).all():
            raise Unusable(f"{name}: upper is not above lower")
        if state.tilt.any():
            raise Unusable(f"{name}: its box is tilted by shear, which is not analysed")
        number = np.unique(state["fibre"], return_inverse=True)[1]
        order = state.in_order()
        order, whole, ring = self.along_chains(order, number[order])
        self.order, self.fibre, self.kind = order, number[order], state["kind"][order]
        self.position = state["position"][order]
        # Row of the next segment, -1 where a chain ends.
        self.start = np.flatnonzero(np.append(True, ~whole[:-1] | (np.diff(self.fibre) != 0)))
        self.size = np.diff(np.append(self.start, len(order)))
        self.chain = np.repeat(np.arange(len(self.start)), self.size)
        self.closed = ring[self.start] & whole[self.start + self.size - 1]
        self.next = np.where(whole, np.arange(1, len(order) + 1), -1)
        self.next[(self.start + self.size - 1)[self.closed]] = self.start[self.closed]
        self.next[(self.start + self.size - 1)[~self.closed]] = -1
        self.bonded = np.flatnonzero(self.next >= 0)
        self.vector = np.zeros_like(self.position)
        self.vector[self.bonded] = self.nearest(self.position[self.next[self.bonded]]
                                                - self.position[self.bonded])

    def along_chains(self, order: Array, number: Array) -> tuple[Array, Array, Array]:
        """Rows of the state along the chains, whether a whole bond leads to the next row, and
        whether the row is of a whole ring. A broken ring starts behind its last break."""
        count = len(order)
        place = np.empty(count, int)
        place[order] = np.arange(count)
        first, second = find_bonds(self.state)
        broken = self.state["bond_broken"][first] != 0
        whole = np.zeros(count, bool)
        whole[place[first[~broken]]] = True
        begin = np.flatnonzero(np.append(True, np.diff(number) != 0))
        size = np.diff(np.append(begin, count))
        ring = np.isin(self.state["fibre"][order[begin]], self.state.closed)
        shift = np.zeros(len(begin), int)
        gap = np.flatnonzero(~whole & ring[number])
        np.maximum.at(shift, number[gap], gap - begin[number[gap]] + 1)
        turned = begin[number] + (np.arange(count) - begin[number] + shift[number]) % size[number]
        # A ring without breaks closes to its first row; another one ends with a break.
        cut = ring & (shift > 0)
        return order[turned], whole[turned], (ring & ~cut)[number]

    def nearest(self, vector: Array) -> Array:
        """The nearest image of a vector through the periodic boundaries."""
        for k in np.flatnonzero(np.isfinite(self.box)):
            vector[:, k] -= self.box[k] * np.round(vector[:, k] / self.box[k])
        return vector

    @property
    def unit(self) -> str:
        """Of length, as tables have it."""
        return "m" if self.state.units == "si" else "A"

    @property
    def unit_shown(self) -> str:
        return "m" if self.state.units == "si" else "Å"

    @functools.cached_property
    def numbers(self) -> Array:
        """Of each kind, as the run that wrote the snapshot had them [kinds, 8]: radius, T, mass,
        moment of inertia, B1 to B4."""
        if "fibre" not in self.state.run:
            raise Lacking(f"{self.name}: without masses and stiffnesses of its fibres; what a run"
                          " wrote has them (-snapshot_file, -state_output)")
        return np.reshape(self.state.run["fibre"], (-1, NUMBERS))

    @functools.cached_property
    def thickness(self) -> Array:
        """Radius of each kind [kinds]."""
        radii = self.state.kinds.thickness(self.settings.radius)
        if not np.isfinite(radii).all():
            raise Lacking(f"{self.name}: without radii of its fibres; give --radius")
        return radii

    @functools.cached_property
    def segment(self) -> Array:
        """Length of a segment of each kind [kinds]: one given, the run's, or the median bond."""
        count = len(self.state.kinds)
        if self.settings.length:
            return np.full(count, self.settings.length)
        if "fibre" in self.state.run:
            return np.asarray(self.numbers[:, 1])
        bond = np.linalg.norm(self.vector[self.bonded], axis=1)
        of = self.kind[self.bonded]
        found = [np.median(bond[of == k]) if (of == k).any() else 0.0 for k in range(count)]
        if not all(found[k] for k in np.unique(self.kind)):
            raise Lacking(f"{self.name}: no bonds to take a segment's length from; give --length")
        return np.array(found)

    @functools.cached_property
    def pieces(self) -> Pieces:
        count = len(self.order)
        last = np.flatnonzero(self.next < 0)
        start = self.start[~self.closed]
        before = np.full(count, -1)
        before[self.next[self.bonded]] = self.bonded
        half = 0.5 * self.segment[self.kind][:, None]
        bond = self.vector / np.maximum(np.linalg.norm(self.vector, axis=1), 1e-300)[:, None]
        # The end of a chain goes on as its last bond; a lone segment lies as its axis.
        ahead, back = bond[before[last]], bond[start]
        for towards, rows in ((ahead, last), (back, start)):
            lone = (before[rows] < 0) & (self.next[rows] < 0)
            towards[lone] = self.axis(rows[lone])
        begin = np.concatenate([self.position[start] - half[start] * back,
                                self.position[self.bonded], self.position[last]])
        vector = np.concatenate([half[start] * back, self.vector[self.bonded], half[last] * ahead])
        row = np.concatenate([start, self.bonded, last])
        key = np.concatenate([3 * start, 3 * self.bonded + 1, 3 * last + 2])
        order = np.argsort(key)
        place = np.full(3 * count, -1)
        place[key[order]] = np.arange(len(key))
        # After the first half and after a bond comes what starts at the next segment.
        onward = np.concatenate([start, self.next[self.bonded], np.full(len(last), -1)])
        follows = np.maximum(place[3 * onward + 1], place[3 * onward + 2])
        return Pieces(begin[order], vector[order], row[order],
                      np.where(onward < 0, -1, follows)[order],
                      np.where(key % 3 == 1, 1.0, 0.5)[order])

    def axis(self, rows: Array) -> Array:
        """Axes of segments as their orientations have them."""
        if not len(rows):
            return np.zeros((0, 3))
        if "orientation" not in self.state:
            raise Lacking(f"{self.name}: a lone segment without orientation")
        axes = matrices(self.state["orientation"][self.order[rows]])[:, :, 0]
        if not np.isfinite(axes).all():
            raise Unusable(f"{self.name}: some orientation is not finite")
        return np.asarray(axes)

    @functools.cached_property
    def region(self) -> tuple[Array, Array]:
        """Lower and upper corner of what porosity and pores are taken over: the box in periodic
        directions, in others as far as the fibres reach, or the limits given."""
        lower, upper = np.array(self.state.lower), np.array(self.state.upper)
        for k in range(3):
            if k in self.settings.region:
                lower[k], upper[k] = self.settings.region[k]
            elif not self.state.periodic[k]:
                pieces, wide = self.pieces, self.wide(k)
                ends = pieces.begin[:, k], pieces.begin[:, k] + pieces.vector[:, k]
                lower[k] = (np.minimum(*ends) - wide).min()
                upper[k] = (np.maximum(*ends) + wide).max()
            if self.state.periodic[k] and upper[k] - lower[k] > self.box[k] * (1 + 1e-12):
                raise Unusable(f"{self.name}: the region is wider than the box in {'xyz'[k]}")
            if not upper[k] > lower[k]:
                raise Unusable(f"{self.name}: the region has no extent in {'xyz'[k]}")
        return lower, upper

    def wide(self, axis: int) -> Array:
        """How far each piece's section reaches to either side along an axis [P]."""
        pieces = self.pieces
        return np.asarray(self.thickness[self.kind[pieces.row]]
                          * np.sqrt(np.maximum(1 - pieces.direction[:, axis]**2, 0)))

    def wraps(self, axis: int) -> bool:
        """Whether the region goes round the periodic box along this axis."""
        lower, upper = self.region
        return bool(upper[axis] - lower[axis] >= self.box[axis] * (1 - 1e-12))
