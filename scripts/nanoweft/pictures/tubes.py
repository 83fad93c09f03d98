"""Which tube is seen at each pixel, how deep, and how its surface is turned."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


def camera(azimuth: float, elevation: float) -> Array:
    """Rows: right, up, and towards the viewer."""
    a, e = np.radians([azimuth, elevation])
    right = np.array([-np.sin(a), np.cos(a), 0])
    towards = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    return np.array([right, np.cross(towards, right), towards])


def tangents(position: Array, first: Array, second: Array) -> tuple[Array, Array]:
    """The directions of the fibres at both ends of the tubes; zero where a fibre ends, so that the
    round cap there keeps its shape."""
    along = position[second] - position[first]
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300)
    node = np.zeros_like(position)
    bonds = np.zeros(len(position), int)
    # A row is the first of at most one tube and the second of at most one.
    for row in (first, second):
        node[row] += along
        bonds[row] += 1
    node /= np.maximum(np.linalg.norm(node, axis=1, keepdims=True), 1e-300)
    node[bonds < 2] = 0
    return node[first].astype(np.float32), node[second].astype(np.float32)


class Canvas(NamedTuple):
    """In samples."""
    width: int
    height: int


def rasterise(a: Array, b: Array, tangent: tuple[Array, Array], radius: Array,
              canvas: Canvas) -> tuple[Array, Array, Array]:
    """Depth, tube (-1: none) and normal (x, y) seen at each pixel; a, b: ends of the tubes' axes in
    pixels. Tubes are intersected with the line of sight exactly, so they stay round at any size;
    the normals follow the curve through the segments, so that no facets show."""
    width, height = canvas
    size = np.array(canvas)
    wide = radius[:, None]
    inside = (np.maximum(a, b)[:, :2] > -wide) & (np.minimum(a, b)[:, :2] < size + wide)
    order = np.flatnonzero(inside.all(axis=1))
    # Far to near: most pixels then end up right at the first write.
    order = order[np.argsort((a + b)[order, 2])]
    a, b = a[order].astype(np.float32), b[order].astype(np.float32)
    before, after = tangent[0][order], tangent[1][order]
    radius, wide = radius[order].astype(np.float32), wide[order]
    depth = np.full(width * height, -np.inf, np.float32)
    owner = np.full(width * height, -1, np.int32)
    normal = np.zeros((2, width * height), np.float32)

    # Each tube looks at the pixels of its bounding rectangle, `count` of them.
    low = np.clip(np.floor(np.minimum(a, b)[:, :2] - wide), 0, size - 1).astype(np.int32)
    high = np.clip(np.floor(np.maximum(a, b)[:, :2] + wide), 0, size - 1).astype(np.int32)
    columns = high[:, 0] - low[:, 0] + 1
    count = columns.astype(np.int64) * (high[:, 1] - low[:, 1] + 1)
    until = np.cumsum(count)
    along = b - a
    flat = np.maximum(np.hypot(along[:, 0], along[:, 1]), np.float32(1e-6))
    # A tube seen end on, or a lone segment, may take any direction in the picture.
    ux, uy = np.where(flat > 1e-6, along[:, 0] / flat, 1), along[:, 1] / flat
    slope = along[:, 2]
    sine = slope / np.hypot(flat, slope)

    begin = 0
    while begin < len(a):
        end = max(np.searchsorted(until, until[begin] + 2_000_000), begin + 1)
        batch, begin = slice(begin, end), end
        k = np.repeat(np.arange(batch.start, end, dtype=np.int32), count[batch])
        starts = until[batch] - count[batch]
        local = np.arange(len(k)) - np.repeat(starts - starts[0], count[batch])
        y, x = np.divmod(local.astype(np.int32), columns[k])
        x += low[k, 0]
        y += low[k, 1]
        dx = x.astype(np.float32) + np.float32(0.5) - a[k, 0]
        dy = y.astype(np.float32) + np.float32(0.5) - a[k, 1]
        q = dx * ux[k] + dy * uy[k]
        h = dy * ux[k] - dx * uy[k]
        w2 = radius[k] ** 2 - h * h
        near = np.flatnonzero((w2 > 0) & (q > -radius[k]) & (q < flat[k] + radius[k]))
        k, q, h, w2 = k[near], q[near], h[near], w2[near]
        pixel = y[near] * width + x[near]
        # The point of the axis, as a fraction t of it, whose sphere is hit first.
        t = np.clip((q + np.sqrt(w2) * sine[k]) / flat[k], 0, 1)
        q -= t * flat[k]
        rise = w2 - q * q
        z = a[k, 2] + t * slope[k] + np.sqrt(np.maximum(rise, 0))
        todo = np.flatnonzero(rise > 0)
        # Where several tubes write to one pixel the last wins, so repeat while a nearer one lost.
        while True:
            todo = todo[z[todo] > depth[pixel[todo]]]
            if not len(todo):
                break
            p, j = pixel[todo], k[todo]
            depth[p] = z[todo]
            owner[p] = order[j]
            n = np.stack([q[todo] * ux[j] - h[todo] * uy[j], q[todo] * uy[j] + h[todo] * ux[j],
                          np.sqrt(rise[todo])])
            tau = (before[j] + t[todo, None] * (after[j] - before[j])).T
            n -= (n * tau).sum(axis=0) * tau
            normal[:, p] = n[:2] / np.sqrt((n * n).sum(axis=0))
    shape = (height, width)
    return depth.reshape(shape), owner.reshape(shape), normal.reshape(2, *shape)
