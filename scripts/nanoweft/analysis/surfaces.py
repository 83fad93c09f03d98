"""Distances between fibres' axes, and from points to them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from .sample import Sample

Array = NDArray[Any]
Kind = tuple[float, Array, Array, Array, cKDTree]


def tree_of(points: Array, lower: Array, box: Array) -> cKDTree:
    """Points by place; `box` is infinite in directions that are not periodic. Of points to be
    looked up take those of `wrapped`."""
    return cKDTree(wrapped(points, lower, box), boxsize=np.where(np.isfinite(box), box, 0))


def wrapped(points: Array, lower: Array, box: Array) -> Array:
    """From the lower corner on, within the box."""
    points = points - lower
    for k in np.flatnonzero(np.isfinite(box)):
        points[:, k] %= box[k]
        points[points[:, k] >= box[k], k] = 0  # a tiny number below zero
    return points


def between(a: tuple[Array, Array], b: tuple[Array, Array]) -> Array:
    """Distance of straight pieces from each other, given by middles and vectors [M,3] each.
    Ericson, Real-Time Collision Detection, 5.1.9."""
    (p, u), (q, v) = a, b
    start = p - 0.5 * u - (q - 0.5 * v)
    uu, vv, uv = (np.einsum("ij,ij->i", *two) for two in ((u, u), (v, v), (u, v)))
    us, vs = np.einsum("ij,ij->i", u, start), np.einsum("ij,ij->i", v, start)
    across = uu * vv - uv**2
    skew = across > 1e-12 * uu * vv
    s = np.where(skew, np.clip((uv * vs - us * vv) / np.where(skew, across, 1), 0, 1), 0.5)
    t = (uv * s + vs) / np.maximum(vv, 1e-300)
    t = np.clip(t, 0, 1)
    s = np.clip((uv * t - us) / np.maximum(uu, 1e-300), 0, 1)
    # Once more, since parallel pieces have begun from any point.
    t = np.clip((uv * s + vs) / np.maximum(vv, 1e-300), 0, 1)
    s = np.clip((uv * t - us) / np.maximum(uu, 1e-300), 0, 1)
    return np.asarray(np.linalg.norm(start + s[:, None] * u - t[:, None] * v, axis=1))


def reaching(sample: Sample, axis: int) -> Array:
    """Which pieces' bodies reach into the region's limits along an axis [P]."""
    pieces, (lower, upper) = sample.pieces, sample.region
    if axis not in sample.settings.region or sample.wraps(axis):
        return np.ones(len(pieces), bool)
    reach = 0.5 * np.abs(pieces.vector[:, axis]) + sample.wide(axis)
    apart = pieces.middle[:, axis] - 0.5 * (lower + upper)[axis]
    if sample.state.periodic[axis]:
        apart -= sample.box[axis] * np.round(apart / sample.box[axis])
    return np.asarray(np.abs(apart) < 0.5 * (upper - lower)[axis] + reach)


class Surfaces:
    """Surfaces of the fibres along some axes: all three, or two of a projection."""

    def __init__(self, sample: Sample, axes: tuple[int, ...]) -> None:
        pieces, self.axes = sample.pieces, list(axes)
        self.lower, self.box = sample.region[0][self.axes], sample.box[self.axes]
        there = np.ones(len(pieces), bool)
        for k in set(range(3)) - set(axes):
            there &= reaching(sample, k)
        self.kinds: list[Kind] = []  # radius, middles, vectors; owners of samples, samples
        of = sample.kind[pieces.row]
        for kind in np.unique(of[there]):
            radius = float(sample.thickness[kind])
            mine = np.ix_(there & (of == kind), self.axes)
            middle, vector = pieces.middle[mine], pieces.vector[mine]
            # Samples of the axes, about half a radius from each other.
            length = np.linalg.norm(vector, axis=1)
            step = max(0.5 * radius, length.sum() / 2e6)
            count = np.maximum(np.ceil(length / step - 1e-6), 1).astype(int)
            owner = np.repeat(np.arange(len(count)), count)
            number = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
            part = (number + 0.5) / count[owner] - 0.5
            points = middle[owner] + part[:, None] * vector[owner]
            tree = tree_of(points, self.lower, self.box)
            self.kinds.append((radius, middle, vector, owner, tree))

    def away(self, points: Array, near: int) -> Array:
        """How far points [M,d] are from the next surface; below zero inside of a fibre. Looks at
        the pieces of so many samples near each."""
        of_kinds = [self.away_from(kind, points, near) for kind in self.kinds]
        return np.asarray(np.min(of_kinds, axis=0) if of_kinds else np.full(len(points), np.inf))

    def away_from(self, kind: Kind, points: Array, near: int) -> Array:
        radius, middle, vector, owner, tree = kind
        near = min(near, tree.n)
        found = tree.query(wrapped(points, self.lower, self.box), near)[1].reshape(len(points),
                                                                                   near)
        nearest = np.full(len(points), np.inf)
        for k in range(near):
            piece = owner[found[:, k]]
            apart = points - middle[piece]
            for j in np.flatnonzero(np.isfinite(self.box)):
                apart[:, j] -= self.box[j] * np.round(apart[:, j] / self.box[j])
            along = vector[piece]
            t = np.einsum("ij,ij->i", apart,
                          along) / np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
            apart -= np.clip(t, -0.5, 0.5)[:, None] * along
            nearest = np.minimum(nearest, np.einsum("ij,ij->i", apart, apart))
        return np.asarray(np.sqrt(nearest) - radius)
