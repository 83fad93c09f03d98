"""How fibres bend and wind: crimp, curvature, torsion, and spectra along the fibre."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .findings import Curve, Findings
from .sample import Lacking, Sample

Array = NDArray[Any]
STRAIGHT = 1e-6  # radians between two bonds below which a place has no plane of bending
FLAT = 0.01      # of the rms turn of all places, below which one has none either


def crimp(sample: Sample) -> Findings:
    """Of chains between their first and last segments. A ring round a periodic box ends at its
    own image; one that closes in itself has no crimp."""
    found = Findings(trends=("crimp_mean",))
    bonds = np.linalg.norm(sample.vector, axis=1)
    contour = np.add.reduceat(bonds, sample.start)
    ends = np.linalg.norm(np.add.reduceat(sample.vector, sample.start), axis=1)
    open_ended = ends > 1e-9 * contour
    values = contour[open_ended] / ends[open_ended] - 1
    if not len(values):
        raise Lacking(f"{sample.name}: no fibre of two segments with two ends, so no crimp")
    weight = contour[open_ended]
    found.add("crimp_mean", weight @ values / weight.sum(), "1",
              "contour length over end-to-end distance - 1, by length")
    found.add("crimp_median", np.median(values), "1", "of the fibres")
    found.add("crimp_max", values.max(), "1", "of the fibres")
    found.histogram("crimp", 100 * values, sample.settings.bins, "crimp, %")
    return found


class Bends(NamedTuple):
    """Of segments between two bonds (rows of the sample): curvature as a vector, and at each such
    bond torsion; weight: product of the sines of the two turns that tell the torsion."""
    nodes: Array  # [N]
    curvature: Array  # [N,3], towards the inside of the bend
    bonds: Array  # [B]: rows whose bond to the next lies between two nodes
    torsion: Array  # [B], right-handed above 0
    weight: Array  # [B]


def bends(sample: Sample) -> Bends:
    """From tangents, which are the bonds' directions. A curvature is the change of the tangent over
    a bond's length, exact on a circle. A torsion is the turn of the plane of bending over a bond's
    length, between -90 and 90 degrees: where a plane curve bends the other way it does not wind."""
    before = np.full(len(sample.order), -1)
    before[sample.next[sample.bonded]] = sample.bonded
    nodes = np.flatnonzero((before >= 0) & (sample.next >= 0))
    if not len(nodes):
        raise Lacking(f"{sample.name}: no fibre of three segments, so no curvature")
    length = np.linalg.norm(sample.vector, axis=1)
    tangent = sample.vector / np.maximum(length, 1e-300)[:, None]
    mean = 0.5 * (length[nodes] + length[before[nodes]])
    curvature = (tangent[nodes] - tangent[before[nodes]]) / np.maximum(mean, 1e-300)[:, None]
    plane = np.zeros_like(tangent)
    plane[nodes] = np.cross(tangent[before[nodes]], tangent[nodes])
    sine = np.linalg.norm(plane, axis=1)
    node = np.zeros(len(before), bool)
    node[nodes] = True
    bonds = sample.bonded[node[sample.bonded] & node[sample.next[sample.bonded]]]
    after = sample.next[bonds]
    sines = np.einsum("ij,ij->i", np.cross(plane[bonds], plane[after]), tangent[bonds])
    turn = np.arctan2(sines, np.einsum("ij,ij->i", plane[bonds], plane[after]))
    turn -= np.pi * np.round(turn / np.pi)
    least = max(STRAIGHT, FLAT * float(np.sqrt(np.mean(sine[nodes]**2))))
    bent = np.minimum(sine[bonds], sine[after]) > least
    torsion = np.where(bent, turn / length[bonds], 0)
    return Bends(nodes, curvature, bonds, torsion, np.where(bent, sine[bonds] * sine[after], 0))


def curvature(sample: Sample) -> Findings:
    """Curvature, torsion and their spectra."""
    found, unit = Findings(trends=("curvature_rms", "torsion_rms")), sample.unit
    bend = bends(sample)
    square = np.einsum("ij,ij->i", bend.curvature, bend.curvature)
    found.add("curvature_rms", np.sqrt(square.mean()), f"1/{unit}", "root mean square")
    found.add("curvature_max", np.sqrt(square.max()), f"1/{unit}", "at one segment")
    weight = bend.weight.sum()
    moments = [bend.weight @ bend.torsion**n / weight if weight else np.nan for n in (1, 2)]
    found.add("torsion_mean", moments[0], f"1/{unit}",
              "of the curve, right-handed above 0, by the square of curvature")
    found.add("torsion_rms", np.sqrt(moments[1]), f"1/{unit}", "by the square of curvature")
    wave, power = spectrum(sample, bend.nodes, bend.curvature)
    peak = int(np.argmax(power)) if len(power) else -1
    bent = len(power) > 0 and power[peak] > 0
    found.add("wave_length", 2 * np.pi / wave[peak] if bent else np.nan, unit,
              "of the wave that holds most of the square of curvature")
    found.add("wave_amplitude", np.sqrt(2 * power[peak]) / wave[peak]**2 if bent else np.nan, unit,
              "deflection of a sine wave with that much curvature")
    for name, rows, values in (("curvature", bend.nodes, bend.curvature),
                               ("torsion", bend.bonds, bend.torsion[:, None])):
        wave, power = spectrum(sample, rows, values)
        if len(wave) > 1 and power.max() > 1e-24 / sample.segment.max()**2:
            label = f"{name}² per wave number, 1/{sample.unit_shown}"
            # The last wave numbers are beyond those of stretched fibres.
            shown = wave <= 0.97 * wave[-1]
            found.curves.append(Curve(f"{name}_spectrum", wave[shown], power[shown] / wave[0],
                                      (f"wave number, 1/{sample.unit_shown}", label),
                                      "logarithmic"))
    return found


def spectrum(sample: Sample, rows: Array, values: Array) -> tuple[Array, Array]:
    """Wave numbers, equally apart from the longest chain's first on, and the mean square of the
    values [R,c] at each (their sum is the mean square of all, without each chain's mean). Rows are
    runs along chains, equally far from each other; each wave of a chain goes to the nearest wave
    number, by the chain's length."""
    chain = sample.chain[rows]
    begin = np.flatnonzero(np.append(True, np.diff(chain) != 0)) if len(rows) else rows
    count = np.diff(np.append(begin, len(rows)))
    used = chain[begin]
    length = np.linalg.norm(sample.vector, axis=1)
    bonds = np.bincount(sample.chain[sample.bonded], minlength=len(sample.start))[used]
    apart = np.add.reduceat(length, sample.start)[used] / np.maximum(bonds, 1)
    long = count >= 4
    if not long.any():
        return np.zeros(0), np.zeros(0)
    first = 2 * np.pi / (count * apart)[long].max()
    power = np.zeros(int(np.ceil(np.pi / (first * apart[long].min()))) + 2)
    for size in np.unique(count[long]):
        some = np.flatnonzero(count == size)
        signal = values[begin[some][:, None] + np.arange(size)]
        waves = np.fft.rfft(signal, axis=1)
        each = (np.abs(waves / size)**2).sum(axis=2)
        each[:, 1:(size + 1) // 2] *= 2  # and as much at the negative wave number
        number = 2 * np.pi * np.arange(each.shape[1]) / (size * apart[some])[:, None]
        place = np.round(number / first).astype(int)
        weight = each * (size * apart[some])[:, None]
        power += np.bincount(place[:, 1:].ravel(), weight[:, 1:].ravel(), len(power))[:len(power)]
    power /= (count * apart)[long].sum()
    last = int(np.flatnonzero(power)[-1]) if power.any() else 0
    return first * np.arange(1, last + 1), power[1:last + 1]
