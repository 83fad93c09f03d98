"""All pairs of segments within the list range, by cells of that edge."""

from dataclasses import dataclass

import numpy as np

EXCLUDE = 20  # places apart along one fibre


@dataclass
class Pairs:
    i: np.ndarray
    j: np.ndarray
    acts: np.ndarray   # whether the two interact: else they only make ghosts of each other
    degree: np.ndarray  # interacting neighbours of each segment


def find(scene, reach):
    side = scene.upper - scene.lower
    shape = np.maximum((side / reach).astype(int), 1)
    if np.any(scene.periodic & (side < 2 * reach)):
        raise SystemExit("scaling: the periodic box is thinner than two list ranges")
    cell3 = np.clip(((scene.position - scene.lower) / side.clip(1e-30) * shape).astype(int), 0,
                    shape - 1)
    found = []
    for i, j in meetings(cell3, shape, scene.periodic):
        d = scene.nearest(scene.position[i] - scene.position[j])
        keep = np.einsum("ij,ij->i", d, d) < reach * reach
        found.append((i[keep], j[keep]))
    i, j = (np.concatenate(x) for x in zip(*found))
    # With two cells in a periodic direction +1 and -1 lead to the same cell.
    if np.any(scene.periodic & (shape < 3)):
        key = np.unique(np.minimum(i, j).astype(np.int64) * len(scene) + np.maximum(i, j))
        i, j = (key // len(scene)).astype(np.int32), (key % len(scene)).astype(np.int32)
    acts = _interact(scene, i, j)
    degree = np.bincount(i[acts], minlength=len(scene)) + np.bincount(j[acts], minlength=len(scene))
    return Pairs(i, j, acts, degree)


def meetings(cell3, shape, periodic):
    """Pairs of points in the same or in neighbouring cells, each once, in portions."""
    cell = (cell3[:, 2] * shape[1] + cell3[:, 1]) * shape[0] + cell3[:, 0]
    order = np.argsort(cell, kind="stable").astype(np.int32)
    start = np.concatenate([[0], np.cumsum(np.bincount(cell, minlength=shape.prod()))])
    for shift in _half_stencil(shape):
        other = cell3 + shift
        a = np.flatnonzero(np.all(periodic | ((other >= 0) & (other < shape)), 1))
        other = other[a] % shape
        target = (other[:, 2] * shape[1] + other[:, 1]) * shape[0] + other[:, 0]
        count = start[target + 1] - start[target]
        for part in np.array_split(np.arange(len(a)), 1 + count.sum() // 4_000_000):
            n = count[part]
            i = np.repeat(a[part], n).astype(np.int32)
            offset = np.arange(n.sum()) - np.repeat(np.cumsum(n) - n, n)
            j = order[np.repeat(start[target[part]], n) + offset]
            once = i < j if not np.any(shift) else slice(None)
            yield i[once], j[once]


def _half_stencil(shape):
    """Half of the 27 shifts: each pair of cells once."""
    near = [range(-1, 2) if n > 1 else range(1) for n in shape]
    for z in near[2]:
        for y in near[1]:
            for x in near[0]:
                if (z, y, x) >= (0, 0, 0):
                    yield np.array([x, y, z])


def _interact(scene, i, j):
    same = scene.fibre[i] == scene.fibre[j]
    apart = np.abs(scene.index[i] - scene.index[j])
    length = np.bincount(scene.fibre)[scene.fibre[i]]
    apart = np.where(scene.closed[scene.fibre[i]], np.minimum(apart, length - apart), apart)
    return ~same | (apart >= EXCLUDE)
