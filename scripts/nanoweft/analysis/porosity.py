"""How much of the space fibres fill, and where."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..units import AMU
from .findings import Curve, Findings
from .sample import Sample

Array = NDArray[Any]

# One unit of density of a state in g/cm^3: eV fs^2/A^5, kg/m^3.
DENSITY = {"nano": 1.66053906660 / AMU, "si": 1e-3}


def porosity(sample: Sample) -> Findings:
    """A fibre's volume is that of cylinders of its kind's radius; where two overlap both count."""
    found = Findings(trends=("porosity",))
    unit = sample.unit
    lower, upper = sample.region
    of = sample.kind[sample.pieces.row]
    volume = sample.pieces.length * np.pi * sample.thickness[of]**2
    inside = body_inside(sample, (0, 1, 2))
    filled, space = float(inside @ volume), math.prod(upper - lower)
    for k, letter in enumerate("xyz"):
        found.add(f"extent_{letter}", upper[k] - lower[k], unit, "of the region looked at")
    found.add("fibre_volume", filled, f"{unit}^3", "of the fibres in the region")
    found.add("volume_fraction", filled / space, "1", "fibre volume over that of the region")
    found.add("porosity", 1 - filled / space, "1", "1 - volume fraction")
    weights = [("fraction", volume, "volume fraction")]
    if "fibre" in sample.state.run:
        scale = DENSITY["si" if sample.state.units == "si" else "nano"]
        mass = scale * sample.pieces.share * sample.numbers[:, 2][of]
        found.add("density", float(inside @ mass) / space, "g/cm^3",
                  "mass over volume of the region")
        weights.append(("density", mass, "density, g/cm³"))
    axis = sample.settings.axis
    edges = np.linspace(lower[axis], upper[axis], sample.settings.bins + 1)
    slab = space / sample.settings.bins
    for name, weight, label in weights:
        look = "table" if name == "density" and len(sample.state.kinds) == 1 else "steps"
        found.curves.append(Curve(f"{name}_profile", 0.5 * (edges[1:] + edges[:-1]),
                                  profile(sample, weight, edges) / slab,
                                  (f"{'xyz'[axis]}, {sample.unit_shown}", label), look))
    return found


def body_inside(sample: Sample, axes: tuple[int, ...]) -> Array:
    """Share of each piece's body within the region's limits along these axes [P]. Exact for one
    axis; for several the piece counts by quarters of its length, each by the product of its
    shares."""
    pieces, (lower, upper) = sample.pieces, sample.region
    quarters = np.ones((4, len(pieces)))
    for k in axes:
        if k not in sample.settings.region or sample.wraps(k):
            continue
        wide, half = sample.wide(k), np.abs(pieces.vector[:, k]) / 8
        for quarter in range(4):
            place = pieces.middle[:, k] + (quarter - 1.5) / 4 * pieces.vector[:, k]
            images = [0.0]
            if sample.state.periodic[k]:
                box = sample.box[k]
                place = lower[k] + (place - lower[k]) % box
                images = [-box, 0.0, box]
            quarters[quarter] *= sum(share_below(upper[k] - place - image, half, wide)
                                     - share_below(lower[k] - place - image, half, wide)
                                     for image in images)
    return np.asarray(quarters.mean(axis=0))


def profile(sample: Sample, weight: Array, edges: Array) -> Array:
    """How much of the pieces' weights [P] lies between neighbouring edges along the axis through
    thickness. Exact for cylinders with flat ends."""
    axis, pieces = sample.settings.axis, sample.pieces
    weight = weight * body_inside(sample, tuple(k for k in range(3) if k != axis))
    wide = sample.wide(axis)
    half = 0.5 * np.abs(pieces.vector[:, axis])
    middle, images = pieces.middle[:, axis], [0.0]
    if sample.state.periodic[axis]:
        box = sample.box[axis]
        middle = edges[0] + (middle - edges[0]) % box
        images = [-box, 0.0, box]
    below = [sum(float(weight @ share_below(edge - middle - image, half, wide)) for image in images)
             for edge in edges]
    return np.diff(below)


def share_below(height: Array, half: Array, wide: Array) -> Array:
    """Share of each cylinder below a plane at this height above its middle. Its axis reaches `half`
    to either side along the normal, its section `wide`: the half disc's distribution, averaged over
    the axis."""
    wide = np.maximum(wide, 1e-9 * (half + wide) + 1e-300)
    steep = half > 1e-6 * wide
    span = np.where(steep, half, 1)
    sloped = disc_area((height + span) / wide) - disc_area((height - span) / wide)
    sloped *= wide / (2 * span)
    t = np.clip(height / wide, -1, 1)
    level = 0.5 + (t * np.sqrt(1 - t * t) + np.arcsin(t)) / np.pi
    return np.asarray(np.where(steep, sloped, level))


def disc_area(t: Array) -> Array:
    """Integral from -1 to t of the share of the unit disc below t."""
    s = np.clip(t, -1, 1)
    root = np.sqrt(1 - s * s)
    return np.asarray(0.5 * s + (s * np.arcsin(s) + root - root**3 / 3) / np.pi
                      + np.maximum(t - 1, 0))
