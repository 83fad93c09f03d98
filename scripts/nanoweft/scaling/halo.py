"""What a partition costs each rank: work, ghosts, messages, cut bonds and pairs."""

from dataclasses import dataclass

import numpy as np


@dataclass
class Loads:
    """One entry a rank."""
    owned: np.ndarray
    work: np.ndarray
    ghosts: np.ndarray
    sent: np.ndarray      # poses to send: a segment counts once for each rank that has
                          # it as a ghost
    messages: np.ndarray  # ranks to receive from
    inner: np.ndarray     # pairs of two own segments
    outer: np.ndarray     # pairs with a ghost; each of both owners computes half of them
    cut_bonds: int

    @property
    def ranks(self):
        return len(self.owned)

    @property
    def segments(self):
        return self.owned.sum()

    @property
    def imbalance(self):
        return self.work.max() / self.work.mean()

    @property
    def cut_pairs(self):
        return self.outer.sum() // 2

    @property
    def pairs(self):
        return self.inner.sum() + self.cut_pairs


def loads(scene, pairs, owner, ranks, work):
    def per_rank(x, weights=None):
        return np.bincount(x, weights=weights, minlength=ranks)

    p, q = owner[pairs.i], owner[pairs.j]
    cut = p != q
    a, b, i, j = p[cut], q[cut], pairs.i[cut], pairs.j[cut]
    bond_i, bond_j = scene.bonds()
    torn = owner[bond_i] != owner[bond_j]
    # A bond partner is a ghost however far it is.
    i, j = (np.concatenate(x) for x in ((i, bond_i[torn]), (j, bond_j[torn])))
    n = np.int64(len(scene))
    key = np.unique(np.concatenate([owner[i] * n + j, owner[j] * n + i]))
    holder, sender = key // n, owner[key % n]
    acts = pairs.acts[cut]
    return Loads(per_rank(owner), per_rank(owner, work), per_rank(holder), per_rank(sender),
                 per_rank(np.unique(holder * np.int64(ranks) + sender) // ranks),
                 per_rank(p[~cut & pairs.acts]), per_rank(a[acts]) + per_rank(b[acts]),
                 int(torn.sum()))
