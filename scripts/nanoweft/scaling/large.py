"""A sheet of 1.024e8 segments: 16 x 16 copies of the paper's piece,
joined through periodic boundaries.

With 4096 ranks every copy is shared among 16 of them, so the partition of one periodic copy, which
has no edge, tells of every rank of the large sheet. (A copy shared among fewer would meet itself
through the boundary, and miss the ghosts there.) Fewer ranks have rectangles, whose ghosts, cut
bonds and cut pairs grow with the perimeter: so many times those along a straight line through one
copy, and for METIS, whose parts are not rectangles, as many times more as its 16 parts of a copy
have than 16 squares.
"""

import numpy as np

from . import halo

COPIES = 16


class Tiling:
    def __init__(self, scene, pairs, work, partition, rectilinear):
        """`partition(ranks)`: owners of the segments of one periodic copy."""
        self.scene, self.pairs, self.work, self.partition = scene, pairs, work, partition
        # Two halves of a periodic copy meet in two lines as long as a copy.
        halves = self._share(2, (scene.position[:, 0] > scene.upper[0] / 2).astype(int))
        self.line = halves.ghosts.mean() / 2, halves.outer.mean() / 2, halves.cut_bonds / 2
        # A square sixteenth has four quarters of such a line around it; other shapes have more.
        self.roughness = max(1.0, self._share(16).ghosts.mean() / self.line[0])
        self.excess = self._share(4 if rectilinear else 16).imbalance - 1
        self.rectilinear = rectilinear

    @property
    def segments(self):
        return COPIES**2 * len(self.scene)

    @property
    def pair_count(self):
        return COPIES**2 * int(self.pairs.acts.sum())

    def loads(self, ranks):
        """Loads of a sample of the ranks: those of one copy, or two."""
        if ranks >= 16 * COPIES**2:
            return self._share(ranks // COPIES**2)
        return self._block(ranks)

    def _imbalance(self, ranks):
        """Rectilinear parts are uneven by part of a cell, the less the longer they are;
        METIS by its tolerance."""
        quarters = 4 * COPIES**2
        return 1 + self.excess * (np.sqrt(ranks / quarters) if self.rectilinear else 1)

    def _share(self, ranks, owner=None):
        owner = self.partition(ranks) if owner is None else owner
        return halo.loads(self.scene, self.pairs, owner, ranks, self.work)

    def _block(self, ranks):
        columns = 2**((int(np.log2(ranks)) + 1) // 2)
        rows = ranks // columns
        # The rank with most neighbours: two in each direction if there are so many.
        across, along = min(columns - 1, 2), min(rows - 1, 2)
        lines = self.roughness * COPIES * (across / rows + along / columns)
        ghosts, outer, bonds = (lines * x for x in self.line)
        pairs = self.pair_count / ranks
        row = np.array([self.segments / ranks, COPIES**2 * self.work.sum() / ranks, ghosts, ghosts,
                        (across + 1) * (along + 1) - 1, pairs - outer / 2, outer])
        # One rank with as much more work than the mean as the partition leaves,
        # one with as much less.
        imbalance = self._imbalance(ranks)
        more = np.array([imbalance, imbalance, 1, 1, 1, imbalance, 1])
        return halo.Loads(*np.array([row * more, row * (2 - more)]).T, cut_bonds=bonds)
