"""Random packings of frictionless straight rods: contacts of a rod and density when they jam."""

from __future__ import annotations

import itertools
import math
import pathlib
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import rotations, runs, states
from ..problems import RunFailed
from ..units import GPA

FOLDER = runs.ROOT / "runs" / "rods"
RADIUS = 6.78           # A
SEGMENTS = 5            # of a rod
MODULUS = 3.0           # E* of the contacts, GPa
UNIT = 4 / 3 * MODULUS * GPA * math.sqrt(RADIUS) * (2 * RADIUS)**1.5  # Hertz: overlap 2 RADIUS
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Rods:
    aspect: float = 5.0     # length over diameter
    share: float = 0.66     # of the volume when they are pressed, more than where they jam
    count: int = 150
    seed: int = 1

    @property
    def loose(self) -> float:
        """Share of the volume at the start."""
        return 1 / self.aspect

    @property
    def T(self) -> float:
        """Length of a segment, A."""
        return 2 * RADIUS * self.aspect / SEGMENTS

    @property
    def volume(self) -> float:
        """Of a rod, a cylinder, A^3."""
        return math.pi * RADIUS**2 * SEGMENTS * self.T

    @property
    def options(self) -> list[str]:
        """Rods of all lengths bend as little for the same force, as the length cubed asks."""
        stiff = (self.aspect / 10)**3
        return ["-fibre_segment_length", f"{self.T}", "-fibre_young", f"{1000 * stiff}",
                "-fibre_shear", f"{400 * stiff}"]


def start(file: states.Path, rods: Rods) -> None:
    """Writes rods at random places in random directions, one after the other where it overlaps
    none of those before."""
    random = np.random.default_rng(rods.seed)
    side = (rods.count * rods.volume / rods.loose)**(1 / 3)
    along = (np.arange(SEGMENTS) - 0.5 * (SEGMENTS - 1)) * rods.T
    middle, way = np.zeros((0, 3)), np.zeros((0, 3))
    while len(middle) < rods.count:
        here, new = side * random.random(3), random.standard_normal(3)
        new /= np.linalg.norm(new)
        apart = middle - here
        apart -= side * np.round(apart / side)
        if not any((forces(apart + side * np.array(image), way, new + 0 * way, rods.T) > 0).any()
                   for image in itertools.product((-1, 0, 1), repeat=3)):
            middle, way = np.vstack([middle, here]), np.vstack([way, new])
    fibres = [here + along[:, None] * new for here, new in zip(middle, way)]
    states.write(file, states.of_fibres([(x, rotations.along(x)) for x in fibres], [0] * 3,
                                        [side] * 3, (1, 1, 1)))


def press(folder: pathlib.Path, rods: Rods) -> None:
    """Presses start.h5 to the share of the volume, as start.h5."""
    strain = (rods.loose / rods.share)**(1 / 3) - 1
    words = [word for axis in "xyz" for word in (f"-deform_{axis}_until", f"{strain}")]
    run("press", [*rods.options, *words, "-scene_file", f"{folder}/start.h5",
                  "-state_output", f"{folder}/pressed.h5"])
    (folder / "pressed.h5").replace(folder / "start.h5")


def run(stage: str, words: list[str]) -> runs.Printed:
    done = runs.run(["-options_file", str(FOLDER / f"{stage}.opts"), *words])
    if done.returncode:
        raise RunFailed(done.stderr.strip() or done.stdout.strip())
    return runs.Printed(done.stdout)


class Packing(NamedTuple):
    share: float            # of the volume
    contacts: float         # of a rod that is not loose
    loose: float            # share of the rods with fewer than four
    force: float            # mean of a contact, over that of an overlap by the diameter
    order: float            # largest eigenvalue of the orientation tensor's deviation from 1/3

    @property
    def overlap(self) -> float:
        """Of crossed rods with the mean force, over the diameter."""
        return self.force**(2 / 3)


def weight(beyond: Array) -> Array:
    """Of a contact whose place is so far beyond the middle of a rod's last segment, in T."""
    x = np.clip(2 * beyond - 1, 0, 1)
    return np.asarray(1 - x**3 * (10 - 15 * x + 6 * x**2))


def forces(apart: Array, way: Array, other: Array, T: float) -> Array:
    """Contact forces of pairs of rods, over that of an overlap by the diameter: middles apart
    [n,3], directions [n,3] of both, length of a segment.
    The law is that of crossing fibres; rods along each other count with the sine 0.2."""
    c, d, e = (np.einsum("ij,ij->i", p, q) for p, q in ((way, other), (way, apart), (other, apart)))
    square = np.maximum(1 - c * c, 0.04)
    s, t = (c * e - d) / square, (e - c * d) / square
    far = np.linalg.norm(apart + s[:, None] * way - t[:, None] * other, axis=1)
    overlap = np.maximum(1 - far / (2 * RADIUS), 0)
    ends = [weight(np.abs(place) / T - 0.5 * (SEGMENTS - 1)) for place in (s, t)]
    return np.asarray(ends[0] * ends[1] * overlap**1.5 / square**0.25)


def backbone(pairs: Array, count: int) -> tuple[Array, NDArray[np.int64]]:
    """Forces and rods [2,contacts] of the contacts that bear load, of rows of first rod, second
    rod, force. What is below a thousandth of the mean is left of contacts that have parted while
    the rods came to rest. A rod with fewer than four contacts is loose: free to slide along
    itself, it needs as many."""
    pairs = pairs[:, pairs[2] > 1e-3 * pairs[2].mean()] if pairs.size else pairs
    while True:
        rods = pairs[:2].astype(int)
        loose = np.bincount(rods.ravel(), minlength=count) < 4
        bears = ~loose[rods].any(axis=0)
        if bears.all():
            return pairs[2], rods
        pairs = pairs[:, bears]


def packing(state: states.State, rods: Rods) -> Packing:
    """What a state of rods is like."""
    x = state.whole[state.in_order()].reshape(-1, SEGMENTS, 3)
    middle, way = x.mean(axis=1), x[:, -1] - x[:, 0]
    way /= np.linalg.norm(way, axis=1)[:, None]
    count, (i, j) = len(x), np.triu_indices(len(x), 1)
    apart = middle[i] - middle[j]
    apart -= np.round(apart / state.box) * state.box
    pairs: list[Array] = []
    for image in itertools.product((-1, 0, 1), repeat=3):
        shifted = apart + np.array(image) * state.box
        close = np.flatnonzero(np.linalg.norm(shifted, axis=1) < (SEGMENTS + 2) * rods.T)
        force = forces(shifted[close], way[i[close]], way[j[close]], rods.T)
        pairs.append(np.stack([i[close], j[close], force])[:, force > 0])
    first, second, force = np.concatenate(pairs, axis=1)
    force, contacts = backbone(np.concatenate(pairs, axis=1), count)
    touched = np.bincount(contacts.ravel(), minlength=count)
    some = touched > 0
    order = np.linalg.eigvalsh(way.T @ way / count - np.eye(3) / 3)[-1]
    return Packing(count * rods.volume / float(np.prod(state.box)),
                   float(touched[some].mean()) if some.any() else 0.0, 1 - float(some.mean()),
                   float(force.mean()) if len(force) else 0.0, float(order))


class Step(NamedTuple):
    energy: float           # of the contacts, eV a rod
    left: float             # largest force that nothing balances, over the mean of a contact
    packing: Packing


def rest(folder: pathlib.Path, rods: Rods) -> Step:
    """Brings start.h5 in the folder to rest, as rest.h5."""
    printed = run("rest", [*rods.options, "-scene_file", f"{folder}/start.h5",
                           "-state_output", f"{folder}/rest.h5"])
    found = packing(states.read(folder / "rest.h5"), rods)
    left = printed.number(r"largest force that nothing balances: ([-+.\de]+)")
    share = left / (UNIT * found.force) if found.force else math.nan
    return Step(printed.energy("pair") / rods.count, share, found)


def loosen(folder: pathlib.Path, rods: Rods, share: float) -> None:
    """Writes start.h5: the rods of rest.h5 as they are, their middles apart so that they have
    this share of the volume."""
    state = states.read(folder / "rest.h5")
    order = state.in_order()
    x, q = (rows[order].reshape(rods.count, SEGMENTS, -1)
            for rows in (state.whole, state["orientation"]))
    factor = (rods.count * rods.volume / float(np.prod(state.box)) / share)**(1 / 3)
    x = x + (factor - 1) * x.mean(axis=1, keepdims=True)
    states.write(folder / "start.h5", states.of_fibres(list(zip(x, q)), factor * state.lower,
                                                       factor * state.upper, (1, 1, 1)))


def jam(folder: pathlib.Path, rods: Rods, steps: int = 3) -> tuple[list[Step], float]:
    """Rods are pressed and come to rest, and are then loosened step by step towards the density
    where they jam; the packings, and that density's share of the volume by extrapolation, which is
    not a number where the last two packings do not tell it."""
    start(folder / "start.h5", rods)
    press(folder, rods)
    done = [rest(folder, rods)]
    share, jammed = rods.share, 0.96 * rods.share
    for _ in range(steps):
        share = jammed + 0.4 * (share - jammed)
        loosen(folder, rods, share)
        done.append(rest(folder, rods))
        # Of Hertz contacts: energy ~ (share - jammed)^2.5.
        (a, x), (b, y) = ((step.energy**0.4, step.packing.share) for step in done[-2:])
        if a <= b or done[-1].packing.force == 0:
            return done, math.nan
        jammed = y - b * (x - y) / (a - b)
    return done, jammed
