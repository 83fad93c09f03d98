"""Tests of random networks held together by links: python3 network.py NANOWEFT SCRIPTS"""
from __future__ import annotations

import os
import sys
import unittest

import h5py
import numpy as np
from numpy.typing import NDArray
from support import FolderTest

Array = NDArray[np.float64]
# Of the (10,10) tube (model.md 2), and of the links in run.opts.
B1, B2, B3, B4, LINK, T = 67.592687, 19780.6, -4032.14, 1470.55, 600.0, 13.56
SHEAR = 1e-6


def add(matrix: Array, rows: list[int], factors: Array, stiffness: float) -> None:
    """Adds the energy stiffness/2 (factors . x[rows])^2."""
    matrix[np.ix_(rows, rows)] += stiffness * np.outer(factors, factors)


def frame_energies(name: str) -> tuple[float, float]:
    """Elastic energy of a sheared network at its start and at rest, of linear EVM bonds in a plane:
    x, y and the turn of each segment are the unknowns."""
    with h5py.File(name) as file:
        x, fibre, index = (file[f"state/{key}"][()] for key in ("position", "fibre", "index"))
        ends = file["link/segments"][()]
    size = index.max() + 1
    matrix, load, energy = np.zeros((3 * len(x), 3 * len(x))), np.zeros(3 * len(x)), 0.0
    for i in np.flatnonzero(index < size - 1):
        chord = x[i + 1, :2] - x[i, :2]
        r = np.linalg.norm(chord)
        (c, s), rows = chord / r, list(range(3 * i, 3 * i + 6))
        longer, turned = np.array([-c, -s, 0, c, s, 0]), np.array([s, -c, 0, -s, c, 0]) / T
        first, second = np.eye(6)[2] - turned, np.eye(6)[5] - turned
        add(matrix, rows, longer, B1)
        # Of shear, bending and torsion to second order in the angles between segments and chord.
        add(matrix, rows, first, B2 / 2)
        add(matrix, rows, second, B2 / 2)
        add(matrix, rows, first - second, B3 + B4 / 2)
        load[rows] -= B1 * (r - T) * longer
        energy += 0.5 * B1 * (r - T)**2
    for i, j in ends @ [size, 1]:
        for axis in 0, 1:
            add(matrix, [3 * i + axis, 3 * j + axis], np.array([1.0, -1.0]), LINK)
    # Loose pieces, which no load moves, are held by next to nothing.
    rest = np.linalg.solve(matrix + 1e-8 * np.eye(len(matrix)), load)
    return energy, energy - 0.5 * load @ rest


class Network(FolderTest):
    def setUp(self) -> None:
        super().setUp()
        self.network = generators.Network(fibres=80, segments=10, across=24, seed=2)

    def share_left(self, share: float = 1.0) -> float:
        """Elastic energy at rest over that at the start, with this share of the links."""
        generators.network(self.path("network.h5"), self.network, share, SHEAR)
        options = os.path.join(scripts, "..", "runs", "network", "run.opts")
        done = self.run_program(nanoweft, "-options_file", options, "-scene_file", "network.h5",
                                "-energy_monitor", "ascii:energy.csv", "-overwrite",
                                "-state_output", "relaxed.h5")
        self.assertIn("converged", done.stdout, done.stderr)
        elastic = tables.read(self.path("energy.csv")).elastic
        return float(elastic[-1] / elastic[0])

    def test_a_network_at_rest_has_the_energy_of_a_linear_frame(self) -> None:
        left = self.share_left()
        start, rest = frame_energies(self.path("network.h5"))
        self.assertGreater(left, 0.01)
        self.assertAlmostEqual(left / (rest / start), 1, delta=1e-3)

    def test_the_modulus_rises_with_links_per_fibre(self) -> None:
        # Of the same fibres with 2, 4.4, 5.4 and 6.8 links each; two leave them loose.
        left = [self.share_left(share) for share in (0.3, 0.65, 0.8, 1.0)]
        self.assertLess(left[0], 1e-4)
        for fewer, more in zip(left[:-1], left[1:]):
            self.assertGreater(more, 1.5 * fewer)
        self.assertLess(left[-1], 1)

    def test_links_are_where_fibres_cross(self) -> None:
        network = self.network
        count = generators.network(self.path("network.h5"), network)
        with h5py.File(self.path("network.h5")) as file:
            x, ends = file["state/position"][()], file["link/segments"][()]
            box = file["state"].attrs["upper"] - file["state"].attrs["lower"]
        self.assertEqual(len(ends), count)
        rows = ends @ [network.segments, 1]
        apart = x[rows[:, 0]] - x[rows[:, 1]]
        self.assertLess(np.abs(apart - np.round(apart / box) * box).max(), 1e-9)
        self.assertTrue((ends[:, 0, 0] != ends[:, 1, 0]).all())
        # All segments at one place are held together: n of them by n - 1 links.
        node = network.nodes(network.lay()).ravel()
        self.assertEqual(count, len(node) - len(np.unique(node)))


if __name__ == "__main__":
    nanoweft, scripts = sys.argv[1:3]
    sys.path.insert(0, scripts)
    from nanoweft import generators, tables
    unittest.main(argv=sys.argv[:1])
