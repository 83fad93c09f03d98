"""Where fibres touch."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from ..problems import Unusable
from .findings import Findings
from .sample import Sample
from .surfaces import between, tree_of

Array = NDArray[Any]
GAP = {"nano": 6.4, "si": 6.4e-10}  # between the surfaces of tubes that stick, at most
CHUNK = 1_000_000


def contacts(sample: Sample) -> Findings:
    """A contact is a place where surfaces of two fibres are less than the gap apart: one crossing,
    or one stretch along which they run side by side. A fibre is what breaks have left of it; what
    was one fibre does not touch itself, or each break would count."""
    found = Findings(trends=("contacts_per_fibre",))
    gap = sample.settings.gap
    gap = GAP["si" if sample.state.units == "si" else "nano"] if gap is None else gap
    if gap > 5 * (sample.segment.max() + sample.thickness.max()):
        raise Unusable(f"{sample.name}: a gap of {gap:g} is more than five segments")
    touching, least = pairs(sample, gap)
    fibres, chain = len(sample.start), sample.chain[sample.pieces.row]
    first = count_places(sample, touching)
    per_fibre = np.bincount(chain[first].ravel(), minlength=fibres)
    two = chain[touching]
    partners = len(np.unique(two[:, 0] * fibres + two[:, 1]))
    length = sample.pieces.length.sum()
    found.add("contacts", len(first), "1",
              f"places where two fibres are within {gap:g} {sample.unit}")
    found.add("contacts_per_fibre", per_fibre.mean(), "1",
              "each contact counts for both of its fibres")
    found.add("partners_per_fibre", 2 * partners / fibres, "1", "other fibres that a fibre touches")
    found.add("contact_distance", length / len(first) / 2 if len(first) else np.nan, sample.unit,
              "length of fibre from one contact to the next")
    found.add("least_gap", least, sample.unit,
              "between surfaces of two fibres, of those in contact;"
              " below zero they overlap")
    found.histogram("contacts", per_fibre, sample.settings.bins, "contacts of a fibre")
    return found


def pairs(sample: Sample, gap: float) -> tuple[Array, float]:
    """Pieces [M,2] of different fibres whose surfaces are within the gap, the lower row first, and
    the least gap among them."""
    pieces, found, least = sample.pieces, [np.zeros((0, 2), np.int64)], np.nan
    radius, fibre = sample.thickness[sample.kind[pieces.row]], sample.fibre[pieces.row]
    middle = pieces.middle
    for all_pairs in candidates(sample, gap):
        for begin in range(0, len(all_pairs), CHUNK):
            two = all_pairs[begin:begin + CHUNK]
            two = two[fibre[two[:, 0]] != fibre[two[:, 1]]]
            a, b = two.T
            apart = sample.nearest(middle[b] - middle[a])
            reach = radius[a] + radius[b]
            close = np.flatnonzero(np.linalg.norm(apart, axis=1) < reach + gap
                                   + 0.5 * (pieces.length[a] + pieces.length[b]))
            a, b, apart, reach = a[close], b[close], apart[close], reach[close]
            distance = between((np.zeros_like(apart), pieces.vector[a]),
                               (apart, pieces.vector[b])) - reach
            touch = distance < gap
            found.append(np.sort(np.stack([a[touch], b[touch]], axis=1), axis=1))
            least = np.fmin(least, distance[touch].min(initial=np.inf))
    return np.concatenate(found), least if np.isfinite(least) else np.nan


def candidates(sample: Sample, gap: float) -> Iterator[Array]:
    """Pairs of pieces, of two kinds at a time, whose middles are near enough to touch: thin fibres
    are not looked for at the distance of thick ones."""
    pieces = sample.pieces
    of = sample.kind[pieces.row]
    groups = []
    for kind in np.unique(of):
        rows = np.flatnonzero(of == kind)
        tree = tree_of(pieces.middle[rows], sample.state.lower, sample.box)
        groups.append((rows, tree, float(sample.thickness[kind]), pieces.length[rows].max()))
    for (rows, tree, radius, longest), (others, other, wide, long) in \
            itertools.combinations_with_replacement(groups, 2):
        reach = radius + wide + gap + 0.5 * (longest + long)
        if tree is other:
            yield rows[tree.query_pairs(reach, output_type="ndarray")]
        else:
            near = tree.sparse_distance_matrix(other, reach, output_type="ndarray")
            yield np.stack([rows[near["i"]], others[near["j"]]], axis=1)


def count_places(sample: Sample, touching: Array) -> Array:
    """One pair of pieces [places,2] for each contact: neighbours along both fibres are one."""
    count = len(sample.pieces)
    code = np.unique(touching[:, 0] * count + touching[:, 1])
    a, b = np.divmod(code, count)
    after, before = sample.pieces.next, np.full(count, -1)
    before[after[after >= 0]] = np.flatnonzero(after >= 0)
    here, there = [], []
    for next_a, next_b in ((after[a], b), (a, after[b]), (after[a], after[b]),
                           (after[a], before[b])):
        wanted = np.where((next_a >= 0) & (next_b >= 0), next_a * count + next_b, -1)
        place = np.minimum(np.searchsorted(code, wanted), max(len(code) - 1, 0))
        joined = np.flatnonzero(code[place] == wanted) if len(code) else place
        here.append(joined)
        there.append(place[joined])
    i, j = np.concatenate(here), np.concatenate(there)
    graph = coo_matrix((np.ones(len(i), bool), (i, j)), shape=(len(code), len(code)))
    label = connected_components(graph, directed=False)[1] if len(code) else code
    first = np.unique(label, return_index=True)[1]
    return np.stack([a[first], b[first]], axis=1)
