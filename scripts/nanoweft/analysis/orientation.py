"""Which way fibres run: orientation tensor and parameters of order, in space and in a plane."""

from __future__ import annotations

import numpy as np

from .findings import Curve, Findings
from .sample import Sample

NAMES = ("xx", "yy", "zz", "xy", "xz", "yz")


def orientation(sample: Sample) -> Findings:
    """By lengths of fibre. Hermans' S2 and its fourth-order sibling S4 are means of the Legendre
    polynomials P2 and P4 of the cosine to the main direction."""
    found = Findings(trends=("orientation_1", "orientation_2", "orientation_3", "S2", "planar_S2"))
    length, along = sample.pieces.length, sample.pieces.direction
    total = length.sum()
    tensor = np.einsum("p,pi,pj->ij", length, along, along) / total
    for name in NAMES:
        i, j = ("xyz".index(letter) for letter in name)
        found.add(f"orientation_{name}", tensor[i, j], "1",
                  "mean of the products of direction cosines")
    values, vectors = np.linalg.eigh(tensor)
    for k, value in enumerate(values[::-1], 1):
        found.add(f"orientation_{k}", value, "1", "eigenvalue of the orientation tensor")
    main = vectors[:, 2] * np.sign(vectors[np.argmax(np.abs(vectors[:, 2])), 2])
    for letter, value in zip("xyz", main):
        found.add(f"direction_{letter}", value, "1", "main direction: eigenvector of orientation_1")
    square = (along @ main)**2
    found.add("S2", length @ (1.5 * square - 0.5) / total, "1",
              "Hermans' parameter about the main direction: 1 aligned, 0 random in space")
    found.add("S4", length @ (4.375 * square**2 - 3.75 * square + 0.375) / total, "1",
              "mean of P4 about the main direction")
    planar(sample, found)
    return found


def planar(sample: Sample, found: Findings) -> None:
    """Of the projection along the axis through thickness, by projected length."""
    axis = sample.settings.axis
    across = [k for k in range(3) if k != axis]
    flat = sample.pieces.vector[:, across] @ np.array([1, 1j])
    weight, plane = np.abs(flat), "xyz"[across[0]] + "xyz"[across[1]]
    total = weight.sum()
    known = total > 1e-9 * sample.pieces.length.sum()
    turn = np.where(weight > 0, flat / np.maximum(weight, 1e-300), 1)
    order = weight @ turn**2 / total if known else np.nan
    fourfold = weight @ turn**4 / total if known else np.nan
    found.add("planar_S2", np.abs(order), "1",
              f"projected to {plane}, |mean of exp 2i angle|: 1 aligned, 0 random")
    found.add("planar_S4", np.abs(fourfold), "1",
              f"projected to {plane}, |mean of exp 4i angle|: 1 also for a perpendicular grid")
    found.add("planar_angle", np.degrees(0.5 * np.angle(order)), "degrees",
              f"of the main direction in {plane} from {plane[0]}")
    if known:
        edges = np.linspace(-92.5, 87.5, 37)  # 0 and 90 degrees are in the middle of a bin
        angle = (np.degrees(np.angle(turn)) + 92.5) % 180 - 92.5
        share = np.histogram(angle, edges, weights=weight)[0] / total
        found.curves.append(Curve("orientation", 0.5 * (edges[1:] + edges[:-1]), 36 * share,
                                  (f"direction in {plane}, degrees", "over that of random fibres"),
                                  "steps"))
