"""Rectilinear cuts of the cell grid (src/domain/cell_grid.cpp)."""

import numpy as np


def arrange_ranks(ranks, side, periodic, shape):
    """Ranks per direction: the factors with the least cut area."""
    best, least = (ranks, 1, 1), np.inf
    for px in range(1, ranks + 1):
        if ranks % px:
            continue
        for py in range(1, ranks // px + 1):
            if (ranks // px) % py:
                continue
            p = (px, py, ranks // px // py)
            cost = 0.0
            for d in range(3):
                area = side[(d + 1) % 3] * side[(d + 2) % 3]
                cost += area * (p[d] if p[d] > 1 and periodic[d] else p[d] - 1)
                if p[d] > shape[d]:
                    cost += 1e3 * area * p[d]
            if cost < least:
                least, best = cost, p
    return best


def cut(histogram, parts):
    """First cell of every part but the first: runs of about equal sums, none empty of cells."""
    cells, total, ends, done, cell = len(histogram), histogram.sum(), [], 0.0, 0
    for p in range(1, parts):
        first, last = (ends[-1] if ends else 0) + 1, cells - (parts - p)
        while cell < last and (cell < first or done + 0.5 * histogram[cell] < total * p / parts):
            done += histogram[cell]
            cell += 1
        ends.append(cell)
    return np.array(ends, int)


def grid_shape(side, reach):
    return np.clip(np.floor(side / reach), 1, 4096).astype(int)


def dmda(scene, reach, ranks, work):
    """Rectilinear cuts of a grid of cells of one list range, by quantiles of the work."""
    side = np.maximum(scene.upper - scene.lower, reach)
    shape = grid_shape(side, reach)
    parts = arrange_ranks(ranks, side, scene.periodic, shape)
    shape = np.maximum(shape, parts)
    owner, stride = np.zeros(len(scene), int), 1
    for d in range(3):
        cell = np.clip((scene.position[:, d] - scene.lower[d]) * shape[d] / side[d], 0,
                       shape[d] - 1).astype(int)
        ends = cut(np.bincount(cell, weights=work, minlength=shape[d]), parts[d])
        owner += stride * np.searchsorted(ends, cell, side="right")
        stride *= parts[d]
    return owner
