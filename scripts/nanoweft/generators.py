"""Fibres laid in space: straight, packed, wound, bent, woven."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import rotations, states
from .beams import Spring

Array = NDArray[Any]
File = str | os.PathLike[str]

LENGTH = 13.56          # of a segment of a (10,10) tube, A: twice its radius
TOUCHING = 17.1         # between the axes of two tubes that touch, A
CROSSING = 17.343571    # between two tubes at a crossing, A


def straight(start: ArrayLike, count: int, axis: int = 0, spacing: float = LENGTH) -> Array:
    """Centres of the segments of a straight fibre."""
    x = np.tile(np.array(start, float), (count, 1))
    x[:, axis] += np.arange(count) * spacing
    return x


def gathered() -> list[Array]:
    """A fabric that has gathered at one side: three layers of touching tubes, then loose ones."""
    tubes = [straight((TOUCHING * (k + 0.5 * (layer % 2)), 0, 0.87 * TOUCHING * layer), 100, 1)
             for k in range(20) for layer in range(3)]
    return tubes + [straight((20 * TOUCHING + 5 * LENGTH * (k + 1), 0, 0), 100, 1)
                    for k in range(40)]


def ball() -> list[Array]:
    """Layers of touching turns on a cylinder: a fibre a layer,
    since the radius jumps from one to the next."""
    points = []
    for layer in range(8):
        radius = 150 + TOUCHING * layer
        turn = LENGTH / math.hypot(radius, TOUCHING / (2 * math.pi))
        angle = np.arange(0, 2 * math.pi * 12, turn)
        height = TOUCHING / (2 * math.pi) * angle
        height = height if layer % 2 == 0 else height[-1] - height
        points.append(np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height]))
    return points


def corners() -> list[Array]:
    """Two bundles in opposite corners of a box."""
    return [straight((x, y + TOUCHING * (a + 0.5 * (b % 2)), y + 0.87 * TOUCHING * b), 32)
            for x, y in ((-800, -900), (400, 600)) for a in range(10) for b in range(10)]


def hexagon(spacing: float, rings: int) -> Array:
    """Places in a plane of tubes in hexagonal packing, `rings` around one."""
    return np.array([(spacing * (i + 0.5 * j), spacing * np.sqrt(0.75) * j)
                     for i in range(-rings, rings + 1) for j in range(-rings, rings + 1)
                     if abs(i + j) <= rings])


def innermost(spacing: float, count: int) -> Array:
    """Places in a plane of so many tubes in hexagonal packing, as close to one as they fit."""
    places = hexagon(spacing, math.ceil(math.sqrt(count / 3)))
    far = np.linalg.norm(places, axis=1).round(6)
    return places[np.argsort(far, kind="stable")][:count]


@dataclass
class Endless:
    """Endless tubes along x: segments of length T, and how far each is off its place, A."""
    T: float = LENGTH
    segments: int = 16
    noise: float = 0.0
    seed: int = 1


def endless_tubes(file: File, places: ArrayLike, offsets: ArrayLike, tubes: Endless) -> File:
    """Writes tubes through the given places in the y-z plane,
    each shifted along itself by its offset."""
    places, random = np.asarray(places, float), np.random.default_rng(tubes.seed)
    x = np.zeros((len(places), tubes.segments, 3))
    x[:, :, 0] = np.arange(tubes.segments) * tubes.T + np.asarray(offsets)[:, None]
    x[:, :, 1:] = places[:, None, :]
    x += tubes.noise * random.standard_normal(x.shape)
    low, high = places.min(axis=0) - 150, places.max(axis=0) + 150
    q = rotations.no_rotation(tubes.segments)
    states.write(file, states.of_fibres([(fibre, q) for fibre in x], [0, *low],
                                        [tubes.segments * tubes.T, *high], (1, 0, 0), closed=True))
    return file


def bundle(file: File, T: float = LENGTH, rings: int = 4, spacing: float = 17.07) -> File:
    """Writes hexagonally packed tubes, each shifted along itself and a little sideways."""
    random = np.random.default_rng(1)
    places = hexagon(spacing, rings)
    places = places + 0.05 * random.standard_normal((len(places), 2))
    tubes = Endless(T, round(16 * LENGTH / T), 0.02)
    return endless_tubes(file, places, LENGTH * random.random(len(places)), tubes)


def free_mode(file: File, T: float, length: float, amplitude: float) -> File:
    """Writes a free fibre bent, without stretch, as in its first bending mode."""
    n = round(length / T)
    k = 4.730040744862704 / length
    s = (np.arange(n) + 0.5) * T
    ratio = (np.cosh(k * length) - np.cos(k * length)) / (np.sinh(k * length) - np.sin(k * length))
    slope = k * (np.sinh(k * s) - np.sin(k * s) - ratio * (np.cosh(k * s) + np.cos(k * s)))
    angle = np.arctan(amplitude * slope)
    # A bond lies halfway between the directions of its ends: no shear.
    bond = 0.5 * (angle[1:] + angle[:-1])
    position = np.zeros((n, 3))
    position[1:, 0] = np.cumsum(T * np.cos(bond))
    position[1:, 1] = np.cumsum(T * np.sin(bond))
    orientation = np.stack([np.cos(angle / 2), 0 * s, 0 * s, np.sin(angle / 2)], axis=1)
    states.write(file, states.of_fibres([(position, orientation)], [-300, -300, -300],
                                        [length + 300, 300, 300]))
    return file


def coil(spring: Spring, segments: int) -> states.Fibre:
    """The spring at rest, from one whole turn to the next: starts at the origin, x and upwards."""
    T = spring.wire / (segments - 1)
    bond = np.array([spring.twist, 0, spring.curvature]) * T
    angle = float(np.linalg.norm(bond))
    whole, half = (rotations.rotation_about(bond, [part * angle])[0] for part in (1.0, 0.5))
    q = [rotations.rotation_about((0, -1, 0), [math.atan2(spring.slope, spring.radius)])[0]]
    while len(q) < segments:
        q.append(rotations.multiply(q[-1], whole))
    chords = rotations.matrices(rotations.multiply(np.array(q[:-1]), half))[:, :, 0]
    return np.concatenate([np.zeros((1, 3)), np.cumsum(T * chords, axis=0)]), np.array(q)


def bisect(low: float, high: float, f: Callable[[float], Any]) -> float:
    """Root of a function that is negative at `low` and positive at `high`."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if f(middle) < 0 else (low, middle)
    return 0.5 * (low + high)


class Wave:
    """z = A cos(pi (s/p - 1/2)), walked along in chords of one segment, of length T."""

    def __init__(self, pitch: float, amplitude: float = 0.5 * CROSSING, T: float = LENGTH) -> None:
        self.pitch, self.amplitude, self.T = pitch, amplitude, T

    def height(self, s: Any) -> Any:
        return self.amplitude * np.cos(np.pi * (s / self.pitch - 0.5))

    def walk(self, start: float, count: int) -> Array:
        s = [start]
        while len(s) < count:
            here, z = s[-1], self.height(s[-1])
            s.append(bisect(here, here + self.T,
                            lambda t: (t - here)**2 + (self.height(t) - z)**2 - self.T**2))
        return np.array(s)


def weave(fibres: int, segments: int, periodic: bool = False) -> states.State:
    """`fibres` each way, as -weave_fibres n,n -weave_segments m lays them (src/scene/weave.cpp),
    without orientations: the pitch is such that unstretched fibres just cover the piece."""
    longest = LENGTH * segments / fibres
    pitch = bisect(0.2 * longest, longest,
                   lambda p: fibres * p - Wave(p).walk(0.0, segments + 1)[-1])
    wave, span = Wave(pitch), fibres * pitch
    first = 0.0 if periodic else bisect(-pitch, pitch,
                                        lambda a: wave.walk(a, segments)[[0, -1]].sum() - span)
    places = wave.walk(first, segments)
    number, place = np.repeat(np.arange(fibres), segments), np.tile(places, fibres)
    sign = np.where(number % 2 == 0, 1.0, -1.0)
    side, z = (number + 0.5) * pitch, sign * wave.height(place)
    position = np.concatenate([np.stack([place, side, z], 1), np.stack([side, place, -z], 1)])
    margin = 4 * LENGTH
    corner = np.array([0.0 if periodic else -margin] * 2 + [-0.5 * CROSSING - margin])
    rows = {"position": position, "fibre": np.concatenate([number, number + fibres]),
            "index": np.tile(np.tile(np.arange(segments), fibres), 2)}
    return states.State(rows, corner, np.array([span, span, 0]) - corner,
                        np.array([periodic, periodic, False]),
                        closed=np.arange(2 * fibres if periodic else 0))


class Kind(NamedTuple):
    """What a kind of fibres is called; radius and length of its segments, A."""
    name: str
    radius: float
    T: float


CNT, GLASS = Kind("cnt", 6.78, LENGTH), Kind("glass", 68.0, 136.0)
GAP = TOUCHING - LENGTH  # between the surfaces of two tubes that touch, A


@dataclass(frozen=True)
class Plies:
    """Plies of parallel thick fibres along x, each woven through by thin ones along y."""
    count: int = 2
    warp: int = 4           # thick fibres of a ply
    weft: int = 24          # thin fibres of a ply
    segments: int = 12      # of a thick fibre
    strand: int = 0         # thin fibres of a strand along x; one in each gap between thick fibres
    gap: float = GAP        # at least, between the surfaces of two fibres, A
    seed: int = 1           # of the places of the thin fibres


def composite(plies: Plies = Plies(), thick: Kind = GLASS, thin: Kind = CNT) -> states.State:
    """Thin fibres that go over and under thick ones, their neighbours the other way round, and
    strands of thin ones along the thick ones; kinds `thin` (0) and `thick` (1). No two are closer
    than the gap."""
    bow = thick.radius + thin.radius + plies.gap
    # At this pitch the crest of the wave is as round as the fibre that it goes over.
    pitch = math.pi * bow
    wave, width = Wave(pitch, bow, thin.T), plies.warp * pitch
    across = wave.walk(0.0, math.ceil(1.5 * width / thin.T))
    across = across[across <= width]
    length = plies.segments * thick.T
    closest, apart = 2 * thin.radius + plies.gap, length / plies.weft
    if apart < closest:
        raise ValueError(f"{plies.weft} thin fibres do not fit beside each other into {length:g} A")
    random = np.random.default_rng(plies.seed)
    shift = 0.5 * (apart - closest) * (random.random((plies.count, plies.weft)) - 0.5)
    fibres, rise = [], 2 * (bow + thin.radius) + plies.gap
    for ply in range(plies.count):
        height = ply * rise
        for j in range(plies.weft):
            x = (j + 0.5) * apart + shift[ply, j] - 0.5 * thick.T
            z = height + (-1)**j * wave.height(across)
            fibres.append(np.column_stack([np.full(len(across), x), across, z]))
        fibres += [straight((0, (k + 0.5) * pitch, height), plies.segments, 0, thick.T)
                   for k in range(plies.warp)]
    # The wefts leave channels under, between and over the plies, halfway between thick fibres.
    channels = [(k * pitch, (ply - 0.5) * rise)
                for ply in range(plies.count + 1) for k in range(1, plies.warp)]
    start = 0.5 * (thin.T - thick.T)
    strands = [straight((start, *place), int(length / thin.T), 0, thin.T)
               for middle in channels for place in middle + innermost(closest, plies.strand)]
    kind = np.tile(np.repeat([0, 1], [plies.weft, plies.warp]), plies.count)
    return in_box(fibres + strands, np.append(kind, np.zeros(len(strands), int)), (thin, thick))


def in_box(fibres: Sequence[Array], kind: ArrayLike, kinds: Sequence[Kind]) -> states.State:
    """A state of two or more kinds, with room around it."""
    places, room = np.concatenate(fibres), 2 * max(one.T for one in kinds)
    state = states.of_fibres([(x, rotations.along(x)) for x in fibres],
                             places.min(axis=0) - room, places.max(axis=0) + room)
    return states.of_kinds(state, [one.name for one in kinds], kind)


def mixed_bench(thin: int = 50_000, thick: int = 200) -> states.State:
    """As many segments of two kinds, CNT (0) and GLASS (1), all along x and at rest: fibres of 20
    thick segments, each in a coat of thin fibres that touch it and each other."""
    length = 20 * GLASS.T
    warp, weft = cut(thick, 20), cut(thin, int(length / CNT.T))
    coat = rings(-(-len(weft) // len(warp)))
    spacing = 2 * float(np.linalg.norm(coat[-1])) + TOUCHING
    cores = innermost(spacing, len(warp))
    fibres = []
    for j, count in enumerate(weft):
        # Each is shifted along itself by another part of a segment.
        start = CNT.T * (j * 0.618034 % 1), *(cores[j % len(cores)] + coat[j // len(cores)])
        fibres.append(straight(start, count, 0, CNT.T))
    fibres += [straight((0.5 * GLASS.T, *core), count, 0, GLASS.T)
               for core, count in zip(cores, warp)]
    return in_box(fibres, np.repeat([0, 1], [len(weft), len(warp)]), (CNT, GLASS))


def cut(segments: int, longest: int) -> list[int]:
    """Numbers of segments of fibres that have as many in all."""
    return [min(longest, segments - begin) for begin in range(0, segments, longest)]


def rings(count: int) -> Array:
    """Places in a plane of thin fibres around a thick one: in rings, at their resting distance."""
    places: list[Array] = []
    radius = GLASS.radius + CNT.radius + GAP
    while sum(map(len, places)) < count:
        there = int(math.pi / math.asin(0.5 * TOUCHING / radius))
        angle = 2 * math.pi / there * np.arange(there)
        places.append(radius * np.column_stack([np.cos(angle), np.sin(angle)]))
        radius += TOUCHING
    return np.concatenate(places)[:count]


@dataclass(frozen=True)
class Network:
    """Straight fibres in a periodic plane, at random on the lines of a triangular lattice whose
    spacing is a segment: where two of them cross, two segments are at one place."""
    fibres: int = 100
    segments: int = 20
    across: int = 60        # segments that fit along x; along y about as many
    seed: int = 1

    @property
    def rows(self) -> int:
        """Of the lattice; even, so that it closes."""
        return 2 * round(self.across / math.sqrt(3))

    def lay(self) -> Array:
        """Places of the segments on the lattice [fibres,segments,2], where (1, 0) leads along x and
        (0, 1) 60 degrees up from it. Fibres on one line stay apart."""
        random = np.random.default_rng(self.seed)
        ways = np.array([(1, 0), (0, 1), (-1, 1)])
        taken: set[tuple[int, int]] = set()  # node and direction
        fibres: list[Array] = []
        for _ in range(1000 * self.fibres):
            way = int(random.integers(3))
            start = random.integers((self.across, self.rows))
            along = start + np.arange(-1, self.segments + 1)[:, None] * ways[way]
            nodes = [(node, way) for node in self.nodes(along).tolist()]
            if taken.isdisjoint(nodes):
                taken.update(nodes[1:-1])
                fibres.append(along[1:-1])
            if len(fibres) == self.fibres:
                return np.array(fibres)
        raise ValueError(f"{self.fibres} fibres do not fit beside each other")

    def nodes(self, places: Array) -> Array:
        """Numbers of the lattice's nodes, the same for all images of one."""
        up, b = np.divmod(places[..., 1], self.rows)
        return np.asarray(b * self.across + (places[..., 0] + up * (self.rows // 2)) % self.across)


def crossings(network: Network, places: Array) -> Array:
    """Fibre and index of the two segments [L,2,2] at each crossing; where three fibres meet, of two
    crossings, which hold them together."""
    node = network.nodes(places).ravel()
    order = np.argsort(node, kind="stable")
    same = np.flatnonzero(np.diff(node[order]) == 0)
    ends = np.stack([order[same], order[same + 1]], axis=1)
    return np.stack(np.divmod(ends, network.segments), axis=2)


def network(file: File, how: Network, share: float = 1.0, shear: float = 0.0) -> int:
    """Writes a random network of which this share of the crossings is tied, stretched by `shear`
    along x and shortened as much along y; the number of its links."""
    places = how.lay()
    links = crossings(how, places)
    chosen = np.random.default_rng(how.seed + 1).permutation(len(links))[:round(share * len(links))]
    flat = LENGTH * places @ np.array([(1, 0), (0.5, math.sqrt(0.75))])
    stretch = np.array([1 + shear, 1 / (1 + shear)])
    fibres = [np.column_stack([x * stretch, np.zeros(len(x))]) for x in flat]
    box = LENGTH * np.array([how.across, how.rows * math.sqrt(0.75)]) * stretch
    states.write(file, states.of_fibres([(x, rotations.along(x)) for x in fibres], [0, 0, -200],
                                        [*box, 200], (1, 1, 0)))
    if len(chosen):
        # Springs of no length hold two segments at one place and leave them free to turn.
        states.link(file, links[np.sort(chosen)], 1e-9)
    return len(chosen)


@dataclass(frozen=True)
class Yarn:
    """Two plies of three strands, each a row of staple fibres end to end, whose ends are staggered
    from strand to strand. The plies are twisted one way and plied the other way with half as many
    turns. Lengths in units of the fibres' radius, segments two long."""
    turns: float = 8.0      # of a ply about its axis
    staple: int = 60        # segments of a fibre
    length: int = 120       # segments of a strand
    overlap: float = 0.01   # of neighbours at the start

    def axes(self, spacing: float, apart: float, points: Array) -> Array:
        """Axes of the strands [6,points,3], three of the first ply and three of the second.
        `spacing`: between strands of a ply, `apart`: between the plies' axes."""
        ply, strand = np.repeat([0, 1], 3)[:, None], np.tile(np.arange(3), 2)[:, None]
        around = -math.pi * self.turns / (2 * self.length)
        x, a, r = points, 0.5 * apart, spacing / math.sqrt(3)
        cosine = 1 / math.hypot(1, a * around)
        # About the ply's axis, whose own helix turns the frame of normal and binormal.
        turned = (math.pi * self.turns / self.length - around * cosine**2) * x / cosine
        angle, phase = around * x + math.pi * ply, turned + 2 * math.pi / 3 * strand
        y, z = np.cos(angle), np.sin(angle)
        inwards, across = r * np.cos(phase), r * np.sin(phase)
        radial = a - inwards
        return np.stack([x - across * a * around * cosine, y * radial - z * across * cosine,
                         z * radial + y * across * cosine], axis=2)

    def strands(self) -> Array:
        """Places of the segments of the strands [6,length,3], packed until neighbours overlap."""
        piece = np.linspace(-20, 20, 201)
        dense = np.linspace(-1.05 * self.length, 1.05 * self.length, 10 * self.length)
        least = 2 - self.overlap
        spacing, apart = 2.0, 4.0
        for _ in range(3):  # each turns the helices that the other one sees
            spacing = bisect(1, 4, lambda d: nearest(self.axes(d, apart, piece), False) - least)
            apart = bisect(2, 10, lambda d: nearest(self.axes(spacing, d, piece), True) - least)
        places = []
        for axis in self.axes(spacing, apart, dense):
            s = np.append(0, np.cumsum(np.linalg.norm(np.diff(axis, axis=0), axis=1)))
            at = np.full(self.length - 1, 2.0)
            for _ in range(6):
                where = np.append(0, np.cumsum(at))
                where += 0.5 * (s[-1] - where[-1])
                x = np.stack([np.interp(where, s, c) for c in axis.T], axis=1)
                at *= 2 / np.linalg.norm(np.diff(x, axis=0), axis=1)
            places.append(x)
        return np.array(places)


def nearest(axes: Array, between: bool, band: int = 15) -> float:
    """The least distance between points of two strands of the same ply, or of two plies, so many
    places or fewer apart along them."""
    pairs = [(k, j) for k in range(6) for j in range(k) if (k // 3 != j // 3) == between]
    first, second = axes[np.transpose(pairs)]
    count = axes.shape[1]
    squares = [np.square(first[:, max(0, -b):count - max(0, b)]
                         - second[:, max(0, b):count - max(0, -b)]).sum(axis=2).min()
               for b in range(-band, band + 1)]
    return math.sqrt(min(squares))


def unsheared(x: Array) -> Array:
    """Orientations of segments on a curve so that the axes of two neighbours have the direction of
    the chord between them as their mean, except at the ends of the curve."""
    chords = np.diff(x, axis=0)
    own = chords.copy()
    for _ in range(4):
        wide = np.concatenate([own[:1], own, own[-1:]])
        own += chords - 0.25 * (wide[:-2] + 2 * own + wide[2:])
    return rotations.along(np.concatenate([x[:1], x[0] + np.cumsum(own, axis=0)]))


def yarn(file: File, how: Yarn, radius: float = 3e-7) -> int:
    """Writes the yarn along x, in m, at rest in its shape; the number of its fibres."""
    fibres = []
    for strand, x in enumerate(radius * how.strands()):
        # An end's direction is that of the strand, which goes on beyond it.
        q, first = unsheared(x), round((0.5 + strand * 2 % 6 + strand // 3) * how.staple / 6)
        gaps = [3, *range(3 + first, how.length - 6, how.staple), how.length - 4]
        fibres += [(x[a + 1:b], q[a + 1:b]) for a, b in zip(gaps, gaps[1:]) if b - a > 2]
    every = np.concatenate([x for x, _ in fibres])
    room = 30 * radius
    state = states.of_fibres(fibres, every.min(axis=0) - room, every.max(axis=0) + room)
    state.units = "si"
    states.write(file, states.at_rest(state))
    return len(fibres)
