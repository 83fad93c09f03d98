"""METIS on pieces of fibres (src/domain/metis.cpp): the same graph in the same order,
so the same parts."""

import ctypes

import numpy as np

from . import pairs, partition

BOND_WEIGHT = 8.0
SEED, UFACTOR = 8, 16  # places in METIS' options


def pieces_of(scene, length):
    """The piece of every segment: `length` consecutive ones of a fibre,
    the last of a fibre shorter."""
    return np.cumsum(scene.index % length == 0) - 1


def divide(scene, reach, ranks, work, length):
    """The rank of every segment."""
    piece = pieces_of(scene, length)
    count = int(piece[-1]) + 1
    if count <= ranks:
        return piece
    a, b, weight = _closeness(scene, reach, piece, count)
    i, j = (piece[x] for x in scene.bonds())
    apart = i != j
    ends = np.concatenate([a, i[apart]]), np.concatenate([b, j[apart]])
    key, place = np.unique(np.minimum(*ends) * count + np.maximum(*ends), return_inverse=True)
    weight = np.bincount(place, np.concatenate([weight, np.full(apart.sum(), BOND_WEIGHT)]))
    weight = np.floor(np.clip(weight, 1, 1e5) + 0.5)
    rows, columns = (np.concatenate(x) for x in ((key // count, key % count),
                                                 (key % count, key // count)))
    order = np.lexsort([columns, rows])
    start = np.concatenate([[0], np.cumsum(np.bincount(rows, minlength=count))])
    # METIS sums the weights in 32 bits.
    load = np.floor(np.maximum(1, 1e9 * np.bincount(piece, work) / work.sum()) + 0.5)
    return _part_graph(start, columns[order], load, np.tile(weight, 2)[order], ranks)[piece]


def _closeness(scene, reach, piece, count):
    """Pieces in the same or in neighbouring cells,
    and how many segments of one would see the other."""
    side = np.maximum(scene.upper - scene.lower, reach)
    shape = partition.grid_shape(side, reach)
    cell3 = np.clip((scene.position - scene.lower) * shape / side, 0, shape - 1).astype(int)
    cell = (cell3[:, 2] * shape[1] + cell3[:, 1]) * shape[0] + cell3[:, 0]
    key, segments = np.unique(cell * count + piece, return_counts=True)
    cell, holder = key // count, key % count
    cell3 = np.stack([cell % shape[0], cell // shape[0] % shape[1], cell // shape[0] // shape[1]],
                     1)
    i, j = (np.concatenate(x) for x in zip(*pairs.meetings(cell3, shape, scene.periodic)))
    apart = holder[i] != holder[j]
    i, j = i[apart], j[apart]
    return holder[i], holder[j], np.minimum(segments[i], segments[j]).astype(float)


def _part_graph(start, neighbours, load, weight, parts):
    if parts == 1:
        return np.zeros(len(load), int)
    library = ctypes.CDLL("libmetis.so.5")
    idx = ctypes.c_int32  # as Debian builds it; real_t is 32 bit too

    def array(x):
        x = np.ascontiguousarray(x, np.int32)
        return x, x.ctypes.data_as(ctypes.POINTER(idx))

    kept = [array(x) for x in (start, neighbours, load, weight, np.zeros(len(load)))]
    options = (idx * 40)()
    library.METIS_SetDefaultOptions(options)
    options[SEED], options[UFACTOR] = 1, 30
    n, one, k, cut_weight = idx(len(load)), idx(1), idx(parts), idx()
    status = library.METIS_PartGraphKway(
        ctypes.byref(n), ctypes.byref(one), kept[0][1], kept[1][1], kept[2][1], None, kept[3][1],
        ctypes.byref(k), None, None, options, ctypes.byref(cut_weight), kept[4][1])
    if status != 1:
        raise SystemExit(f"scaling: METIS failed with status {status}")
    return kept[4][0].astype(int)
