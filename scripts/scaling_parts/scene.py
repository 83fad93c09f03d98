"""Fibres in space: from a state file, or a plain weave like the program's own (src/scene/weave.cpp)."""

from dataclasses import dataclass

import h5py
import numpy as np

LENGTH = 13.56          # segment T, A
GAP = 17.343571         # between two tubes at a crossing, A
POINTS, CUTOFF = 3, 4 * LENGTH


def list_range(skin):
    return CUTOFF + LENGTH * (POINTS - 1) / POINTS + skin


@dataclass
class Scene:
    position: np.ndarray   # [N, 3], inside the box where periodic
    fibre: np.ndarray      # number of the fibre, 0, 1, 2, ...
    index: np.ndarray      # place along it
    closed: np.ndarray     # per fibre
    lower: np.ndarray
    upper: np.ndarray
    periodic: np.ndarray

    def __post_init__(self):
        side = self.upper - self.lower
        wrapped = self.lower + (self.position - self.lower) % side
        self.position = np.where(self.periodic, wrapped, self.position)
        self.lower = np.where(self.periodic, self.lower, self.position.min(0))
        self.upper = np.where(self.periodic, self.upper, self.position.max(0))

    def __len__(self):
        return len(self.fibre)

    def nearest(self, d):
        side = np.where(self.periodic, self.upper - self.lower, np.inf)
        return d - np.where(self.periodic, self.upper - self.lower, 0) * np.rint(d / side)

    def bonds(self):
        """Both ends of every bond."""
        i = np.flatnonzero(self.fibre[1:] == self.fibre[:-1])
        j = i + 1
        first = np.flatnonzero(self.index == 0)
        last = np.append(first[1:], len(self)) - 1
        ring = self.closed[self.fibre[first]]
        return np.append(i, first[ring]), np.append(j, last[ring])


def read(file):
    with h5py.File(file) as f:
        g = f["state"]
        ids = g["fibre"][:]
        names, fibre = np.unique(ids, return_inverse=True)
        closed = np.isin(names, g["fibre_closed"][:]) if "fibre_closed" in g else np.zeros(len(names), bool)
        return Scene(g["position"][:], fibre, g["index"][:], closed, g.attrs["lower"][:],
                     g.attrs["upper"][:], g.attrs["periodic"][:].astype(bool))


def _bisect(low, high, f):
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if f(middle) < 0 else (low, middle)
    return 0.5 * (low + high)


class _Wave:
    """z = A cos(pi (s/p - 1/2)), walked along in chords of one segment."""

    def __init__(self, pitch):
        self.pitch = pitch

    def height(self, s):
        return 0.5 * GAP * np.cos(np.pi * (s / self.pitch - 0.5))

    def walk(self, start, count):
        s = [start]
        while len(s) < count:
            here, z = s[-1], self.height(s[-1])
            s.append(_bisect(here, here + LENGTH,
                             lambda t: (t - here)**2 + (self.height(t) - z)**2 - LENGTH**2))
        return np.array(s)


def weave(fibres, segments, periodic=False):
    """`fibres` each way, as -weave_fibres n,n -weave_segments m lays them: the pitch is such that
    unstretched fibres just cover the piece."""
    longest = LENGTH * segments / fibres
    pitch = _bisect(0.2 * longest, longest,
                    lambda p: fibres * p - _Wave(p).walk(0.0, segments + 1)[-1])
    wave, span = _Wave(pitch), fibres * pitch
    if periodic:
        places = wave.walk(0.0, segments)
    else:
        first = _bisect(-pitch, pitch, lambda a: wave.walk(a, segments)[[0, -1]].sum() - span)
        places = wave.walk(first, segments)
    number, place = np.repeat(np.arange(fibres), segments), np.tile(places, fibres)
    sign = np.where(number % 2 == 0, 1.0, -1.0)
    side, z = (number + 0.5) * pitch, sign * wave.height(place)
    position = np.concatenate([np.stack([place, side, z], 1), np.stack([side, place, -z], 1)])
    margin = 4 * LENGTH
    corner = np.array([0.0 if periodic else -margin] * 2 + [-0.5 * GAP - margin])
    return Scene(position, np.concatenate([number, number + fibres]),
                 np.tile(np.tile(np.arange(segments), fibres), 2), np.full(2 * fibres, periodic),
                 corner, np.array([span, span, 0]) - corner, np.array([periodic, periodic, False]))
