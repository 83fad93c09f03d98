"""Sizes of pores: the largest circles in a projection, the largest spheres in space."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from .findings import Curve, Findings
from .sample import Sample
from .surfaces import Surfaces

Array = NDArray[Any]
LEVELS = 16      # sizes of a distribution
CANDIDATES = 64  # places from which the largest is looked for
CLOSE = 32       # places of fibres that are looked at near each of these
CHUNK = 100_000


def pores(sample: Sample) -> Findings:
    found = Findings(trends=("circle_max", "sphere_max"))
    axis = sample.settings.axis
    flat = Grid(sample, tuple(k for k in range(3) if k != axis))
    plane = "".join("xyz"[k] for k in flat.axes)
    found.add("open_area", float((flat.away > 0).mean()), "1",
              f"share of {plane} that no fibre covers")
    space = Grid(sample, (0, 1, 2))
    for grid, shape, where in ((flat, "circle", f"in the projection to {plane}"),
                               (space, "sphere", "in space")):
        size, share = grid.sizes()
        found.add(f"{shape}_max", 2 * grid.largest(), sample.unit,
                  f"diameter of the largest {shape} between the fibres {where}, within the region")
        found.add(f"{shape}_mean", 2 * np.trapz(share, size), sample.unit, "diameter of the largest"
                  f" {shape} over a point of the void, mean; cells of {grid.cell.max():.3g}")
        if len(size):
            found.curves.append(Curve(f"{shape}s", 2 * size, 100 * share,
                                      (f"diameter of the {shape}, {sample.unit_shown}",
                                       f"void in larger {shape}s, %")))
    return found


class Grid:
    """Cells over the region, and how far the middle of each is from the next surface. The region's
    faces count as surfaces where it does not go round the periodic box."""

    def __init__(self, sample: Sample, axes: tuple[int, ...]) -> None:
        self.axes, self.surfaces = axes, Surfaces(sample, axes)
        self.lower, self.upper = (corner[list(axes)] for corner in sample.region)
        self.wraps = np.array([sample.wraps(k) for k in axes])
        extent = self.upper - self.lower
        side = (extent.prod() / sample.settings.cells)**(1 / len(axes))
        count = np.maximum(np.ceil(extent / side), 1).astype(int)
        self.cell = extent / count
        self.points = self.lower + (np.indices(count).reshape(len(axes), -1).T + 0.5) * self.cell
        self.away = self.far(self.points).reshape(count)

    def far(self, points: Array, near: int = 4) -> Array:
        """Of any points [M,d], looking at so many places of fibres near each."""
        away = np.concatenate([self.surfaces.away(points[k:k + CHUNK], near)
                               for k in range(0, len(points), CHUNK)])
        for k in np.flatnonzero(~self.wraps):
            place = points[:, k]
            away = np.minimum(away, np.minimum(place - self.lower[k], self.upper[k] - place))
        return away

    def largest(self) -> float:
        """Radius of the largest circle or sphere: from the grid's best places on, in ever finer
        steps; 0 without void."""
        mode = ["wrap" if wraps else "nearest" for wraps in self.wraps]
        peaks = np.flatnonzero(ndimage.maximum_filter(self.away, 3, mode=mode) == self.away)
        peaks = peaks[np.argsort(-self.away.flat[peaks])][:CANDIDATES]
        place, best = self.points[peaks], self.far(self.points[peaks], CLOSE)
        steps = np.indices((3,) * len(self.axes)).reshape(len(self.axes), -1).T - 1
        step = 0.5
        while step > 1e-8:
            tried = place[:, None] + step * steps * self.cell
            away = self.far(tried.reshape(-1, len(self.axes)), CLOSE).reshape(len(place), -1)
            chosen = np.argmax(away, axis=1)
            better = away[np.arange(len(place)), chosen]
            moved = better > best + 1e-12 * np.abs(best)
            place[moved], best[moved] = tried[np.arange(len(place)), chosen][moved], better[moved]
            # Those that cannot become the largest any more are left.
            left = best + 2 * step * np.linalg.norm(self.cell) >= best.max()
            place, best = place[left], best[left]
            step *= 1 if moved.any() and step > 0.1 else 0.5
        return max(float(best.max()), 0.0)

    def sizes(self) -> tuple[Array, Array]:
        """Radii, and the share of the void that lies in circles or spheres of that radius or larger
        between the fibres (Gelb and Gubbins, Langmuir 15, 305)."""
        void = self.away > 0
        if not void.any():
            return np.zeros(0), np.zeros(0)
        radius = np.linspace(0, (1 - 1e-9) * self.away.max(), LEVELS)
        share, taken = np.zeros(LEVELS), np.zeros_like(void)
        # What lies in a larger one counts for the smaller ones, too.
        for k in range(LEVELS)[::-1]:
            taken |= self.covered(radius[k])
            share[k] = taken[void].mean()
        return radius, share

    def covered(self, radius: float) -> Array:
        """Cells that lie in a sphere of this radius around a middle that has room for it."""
        wide = [(int(np.ceil(radius / cell)) + 1,) * 2 if wraps else (0, 0)
                for cell, wraps in zip(self.cell, self.wraps)]
        taken = np.pad(self.away < radius, wide, mode="wrap")
        near = ndimage.distance_transform_edt(taken, sampling=self.cell) <= radius
        return np.asarray(near[tuple(slice(a, near.shape[k] - b) for k, (a, b) in enumerate(wide))])
