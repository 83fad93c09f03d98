"""Pictures of states that share camera, section, range of colours and thickness."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from matplotlib.colors import to_rgb
from numpy.typing import NDArray

from .. import states
from ..kinds import NUMBERS
from ..problems import Unusable
from ..states import State, StateFile, Tubes
from . import colours, light
from .page import Layout, Look
from .tubes import camera, tangents

Array = NDArray[Any]

WANTED = ("position", "fibre", "index", "image", "group", "bond_broken", "kind", "rest_extension")
THINNEST = 1.15  # radius in pixels, below which over and under could not be told apart
DARK, LIGHT = "#15171B", "#E8E8E8"


@functools.lru_cache(maxsize=4)
def load(name: str, color: str) -> tuple[State, Tubes]:
    state = states.read(name, WANTED, None if color in colours.NAMED else color)
    return state, states.find_tubes(state)


def rest_lengths(state: State, tubes: Tubes, given: float | None) -> Array:
    """Of a bond of each kind without strain [kinds]: the one given, the run's, or the median."""
    count = len(state.kinds)
    if given:
        return np.full(count, given)
    if "fibre" in state.run:
        return np.reshape(state.run["fibre"], (-1, NUMBERS))[:, 1].astype(float)
    position, first, second, _ = tubes
    length, bond = np.linalg.norm(position[second] - position[first], axis=1), first != second
    usual = np.median(length[bond]) if bond.any() else 1.0
    of = [length[bond & (state["kind"][first] == k)] for k in range(count)]
    return np.array([np.median(one) if len(one) else usual for one in of])


def usual_colour(file: str) -> str:
    """By what to colour where nothing is asked for."""
    with StateFile(file) as state:
        return "kind" if len(state.kinds) > 1 else "fibre"


class Extra(NamedTuple):
    """Straight tubes of one colour besides the fibres, in samples."""
    a: Array
    b: Array
    radius: Array
    colour: str


# Ends, tangents at both, radii and linear colours, as the scene to be lit has them.
Pipes = tuple[Array, Array, tuple[Array, Array], Array, Array]


def with_extras(pipes: Pipes, extras: list[Extra]) -> Pipes:
    a, b, (before, after), wide, albedo = pipes
    for extra in extras:
        flat = np.zeros((len(extra.a), 3), np.float32)
        tint = light.linear(np.tile(to_rgb(extra.colour), (len(extra.a), 1)))
        a, b = np.concatenate([a, extra.a]), np.concatenate([b, extra.b])
        before, after = np.concatenate([before, flat]), np.concatenate([after, flat])
        wide, albedo = np.append(wide, extra.radius), np.concatenate([albedo, tint])
    return a, b, (before, after), wide, albedo


@dataclass
class View:
    """What the pictures of a stage should show."""
    color: str = "fibre"
    limits: colours.Limits | None = None  # of the colours
    breaks: bool = False                  # mark the ends of broken bonds
    direction: tuple[float, float] = (-90, 90)
    zoom: float = 1
    center: tuple[float, ...] | None = None
    radius: tuple[float, ...] = ()        # of the tubes: one for all or one for each kind
    length: float | None = None           # of a bond without strain
    dark: bool = False
    solids: tuple[tuple[float, ...], ...] = ()  # x, y, z, radius of a ball; both ends of a rod


class Stage:
    """What all pictures made together share: camera, section, range of colours."""

    def __init__(self, options: View, files: list[str]) -> None:
        self.how, self.zoom, self.marked = options.color, options.zoom, options.breaks
        self.eye = camera(*options.direction)
        self.paper = DARK if options.dark else "white"
        self.palette = colours.BLACK if options.dark else colours.WHITE
        self.ink = LIGHT if options.dark else DARK
        state, tubes = load(files[0], self.how)
        self.units = state.units
        self.length = options.length
        self.lengths = rest_lengths(state, tubes, options.length)
        self.given = options.radius
        self.solids = [(np.array(row[:3]), np.array(row[-4:-1]), row[-1]) for row in options.solids]
        self.unseen: list[str] = []  # files of which a panel shows nothing, and where they are
        self.usual = 6.78 if self.units == "nano" else 0.5 * float(self.lengths.min())
        self.masks = np.array([], int)  # of the groups of all files
        self.survey(files, options.limits)
        self.middle = (self.low + self.high) / 2
        if options.center:
            self.middle = self.eye @ (*options.center, self.height)[:3]
        across = np.maximum((self.high - self.low)[:2], 2 * self.thin)
        self.aspect = np.clip(across[0] / across[1], 0.4, 2.5)

    def values(self, state: State, tubes: Tubes) -> Array | None:
        """What tells the colours of the tubes, if numbers do."""
        rest = np.ones(len(tubes.first))
        if self.how == "stretch":
            # Without a run's numbers the median of the first file holds for all.
            lengths = (rest_lengths(state, tubes, self.length) if "fibre" in state.run
                       else self.lengths)
            if len(lengths) != len(state.kinds):
                raise Unusable("the files are of other kinds; give --length")
            rest = lengths[state["kind"][tubes.first]]
            if "rest_extension" in state:
                rest = rest + state["rest_extension"][tubes.first]
        return colours.values_of(self.how, state, tubes, rest)

    def radius(self, state: State) -> Array:
        try:
            return state.radius(self.given, self.usual)
        except Unusable as problem:
            raise Unusable(f"--radius: {problem}") from None

    def survey(self, files: list[str], limits: colours.Limits | None) -> None:
        """Corners of everything, seen by the camera, radii, and the range of the colours."""
        low, high, heights, ranges, radii = [], [], [], [], []
        for name in files:
            state, tubes = load(name, self.how)
            if state.units != self.units:
                raise Unusable(f"{name}: in other units than {files[0]}")
            seen, radius = tubes[0] @ self.eye.T, self.radius(state)
            radii += [radius.min(), radius.max()]
            low.append((seen - radius[:, None]).min(axis=0))
            high.append((seen + radius[:, None]).max(axis=0))
            heights.append(np.percentile(tubes[0][:, 2], [0, 50, 100]))
            if self.how == "kind" and state.kinds.names != load(files[0], self.how)[0].kinds.names:
                raise Unusable(f"{name}: of other kinds than {files[0]}")
            values = self.values(state, tubes)
            if self.how == "group":
                self.masks = np.union1d(self.masks, state["group"])
            if values is not None and not limits:
                ranges.append(colours.natural_range(self.how, values))
        self.low, self.high = np.min(low, axis=0), np.max(high, axis=0)
        self.thin, self.thick = min(radii), max(radii)
        # The paper lies below nearly everything, but not so deep that shadows no longer tell.
        bottom, usual, top = np.array(heights).T
        self.height = (bottom.min() + top.max()) / 2
        self.floor = max(bottom.min(), usual.min() - 5 * self.thick) - self.thick
        self.limits = limits or ((min(low for low, _ in ranges), max(high for _, high in ranges))
                                 if ranges else None)

    def colours_of(self, name: str) -> colours.Colours:
        state, tubes = load(name, self.how)
        values = self.values(state, tubes)
        scale = None if values is None or not self.limits else (values, self.limits)
        result = colours.colour(self.how, state, tubes, self.palette, scale, self.masks)
        if self.marked:
            result = result._replace(legend=result.legend + (("broken bonds", colours.BREAK),))
        if len(state.links):
            result = result._replace(legend=result.legend + (("links", colours.LINK),))
        return result

    def pixel(self, layout: Layout) -> float:
        room = 0.96 * np.array([layout.width, layout.height])
        return float(np.max((self.high - self.low)[:2] / room) / self.zoom)

    def draw(self, name: str, tint: colours.Colours, layout: Layout) -> Array:
        """The panel of one file."""
        state, (position, first, second, torn) = load(name, self.how)
        pixel = self.pixel(layout)
        # Thin tubes need more samples, or a weave dissolves into stripes.
        sampling = int(np.clip(np.ceil(2.2 * pixel / self.thin), 2, 4))
        fine = sampling / pixel
        # Tubes that would be thinner than a pixel are thickened; for the eye of the camera alone
        # all are moved apart as much as the thinnest need it, so that what lies above stays above.
        radius = np.maximum(self.radius(state) * fine, THINNEST * sampling)
        thin, thick = (max(one * fine, THINNEST * sampling) for one in (self.thin, self.thick))
        lift = (thin - self.thin * fine) / self.thin * self.eye[2, 2]
        shift = np.array([layout.width, layout.height, 0]) * sampling / 2 - self.middle * fine
        seen = position @ self.eye.T * fine + shift
        seen[:, 2] += lift * (position[:, 2] - self.floor)
        # A torn end is a round cap that ends short,
        # so that the gap is seen from the first moment on.
        along = (seen[second] - seen[first]) * 0.45
        a = seen[first] + along * torn[0, first, None]
        b = seen[second] - along * torn[1, second, None]
        tangent = tangents(seen, first, second)
        extras = []
        if self.marked:
            # What crosses above must not hide the marks.
            rows = np.concatenate([first[torn[0, first]], second[torn[1, second]]])
            ends = np.concatenate([a[torn[0, first]], b[torn[1, second]]]) + [0, 0, 4 * thick]
            wide = np.maximum(1.3 * radius[rows], 2.6 * sampling)
            extras.append(Extra(ends, ends, wide, colours.BREAK))
        if len(state.links):
            rows, way = states.half_links(state)
            along = way @ self.eye.T * fine
            along[:, 2] += lift * way[:, 2]
            # Links lie upon the fibres that they tie, or those would hide most of them.
            ends = seen[rows] + np.multiply.outer(radius[rows], [0, 0, 1])
            wide = np.maximum(0.4 * radius[rows], 1.3 * sampling)
            extras.append(Extra(ends, ends + along, wide, colours.LINK))
        for *ends, wide in self.solids:
            a_end, b_end = ((end @ self.eye.T * fine + shift
                             + [0, 0, lift * (end[2] - self.floor)])[None] for end in ends)
            extras.append(Extra(a_end, b_end, np.array([wide * fine]), colours.SOLID))
        tubes = with_extras((a, b, tangent, radius[first], light.linear(tint.tubes)), extras)
        a, b, _, radius, _ = tubes
        wide, size = radius[:, None], np.array([layout.width, layout.height]) * sampling
        if not ((np.maximum(a, b)[:, :2] > -wide) & (np.minimum(a, b)[:, :2] < size + wide)
                ).all(axis=1).any():
            low, high = (",".join(f"{x:.4g}" for x in corner)
                         for corner in (position.min(axis=0), position.max(axis=0)))
            self.unseen.append(f"{name}: nothing of it is in view; it reaches from {low} to {high}")
        level, tilt = self.ground(fine, shift, seen)
        scene = light.Scene(*tubes, light.linear(to_rgb(self.paper)),
                            (thin, thick), level, tilt)
        return light.draw(scene, layout.width, layout.height, sampling)

    def look(self, layout: Layout) -> Look:
        return Look(self.pixel(layout), self.units, self.ink, self.paper)

    def ground(self, fine: float, shift: Array, seen: Array) -> tuple[float, float]:
        """Depth of the paper: at y = 0, and what it grows by with y.
        From the side there is none."""
        sine, cosine = self.eye[2, 2], self.eye[1, 2]
        if sine < 0.3:
            return seen[:, 2].min() - 1e4, 0.0
        return (self.floor * fine + cosine * shift[1]) / sine + shift[2], -cosine / sine
