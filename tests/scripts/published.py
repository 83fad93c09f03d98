"""Tests of published numbers: python3 published.py SCRIPTS (NANOWEFT_PROGRAM names the program)"""
from __future__ import annotations

import math
import pathlib
import sys
import unittest
import unittest.mock

import numpy as np
from support import FolderTest


class SelfFolding(FolderTest):
    def test_a_tube_folds_from_the_length_of_an_elastica_with_the_tubes_adhesion_on(self) -> None:
        folder = pathlib.Path(self.folder)
        short, long = (self_folding.relaxed(folder, n) for n in (220, 300))
        self.assertGreater(short, 0)
        self.assertLess(long, 0)
        fall = (short - long) / (80 * self_folding.T)
        self.assertAlmostEqual(fall / (self_folding.GAMMA / 2), 1, delta=2e-3)
        critical = (300 * self_folding.T + long / fall) / self_folding.REACH
        # 11.850 from the planar curve; 4 pi for a loop that is a circle of a thin tube.
        self.assertAlmostEqual(critical, 11.85, delta=0.02)
        self.assertLess(critical, self_folding.CIRCLE)


class Windings(FolderTest):
    def test_a_ring_winds_as_often_as_bending_against_adhesion_says(self) -> None:
        folder = pathlib.Path(self.folder)
        found = [windings.relaxed(folder, 375, n) for n in (2, 3, 4)]
        closed = [windings.closed_form(375, n) for n in (2, 3, 4)]
        self.assertEqual((np.argmin(found), np.argmin(closed)), (1, 1))
        np.testing.assert_allclose(found[:2], closed[:2], rtol=0.01)


class PullOut(FolderTest):
    def test_the_force_that_parts_two_tubes_is_their_adhesion_per_length(self) -> None:
        way, force = pull_out.pulled(pathlib.Path(self.folder), 2)
        mean = pull_out.mean(way, force)
        self.assertAlmostEqual(mean / pull_out.closed_form(2)[1], 1, delta=0.01)
        # Filleter et al.: 0.3 nN a neighbour.
        self.assertAlmostEqual(mean * pull_out.NANONEWTON, 0.3, delta=0.02)


class Insulin(FolderTest):
    def test_a_fibril_across_a_gap_has_the_modulus_of_its_preset(self) -> None:
        folder = pathlib.Path(self.folder)
        insulin.beam(folder / "beam.h5")
        loads = np.array([0.001, 0.008])
        bent = np.array([-insulin.deflection(folder, -load) for load in loads])
        stiffening, stiffness = np.polyfit(bent**2, loads / bent, 1)
        self.assertAlmostEqual(stiffness / insulin.stiffness(), 1, delta=2e-3)
        self.assertAlmostEqual(stiffening / stiffness * insulin.RADIUS**2, 0.24, delta=0.01)

    def test_fibrils_that_scatter_are_as_strong_as_the_weakest_of_their_bonds(self) -> None:
        # The mean of the least of 40 normal numbers is 2.161 standard deviations below theirs.
        self.assertAlmostEqual(insulin.weakest_link(), 0.6 * (1 - 0.2161), delta=1e-4)


class Rods(FolderTest):
    def test_two_crossed_rods_push_as_hertz_says_and_not_beyond_their_ends(self) -> None:
        x, y = np.array([[1.0, 0, 0]]), np.array([[0.0, 1, 0]])
        apart = np.array([[0, 0, 0.99 * 2 * rods.RADIUS]])
        self.assertAlmostEqual(rods.forces(apart, x, y, 10.0)[0], 0.01**1.5, delta=1e-12)
        for along, expected in ((24.9, 1.0), (27.5, 0.5), (30.1, 0.0)):
            beyond = rods.forces(apart + [[along, 0, 0]], x, y, 10.0)[0]
            self.assertAlmostEqual(beyond / 0.01**1.5, expected, delta=0.01)

    def test_packings_that_do_not_tell_where_they_jam_give_no_number(self) -> None:
        found = rods.Packing(*[0.5] * len(rods.Packing._fields))
        loose = found._replace(force=0.0)
        step = rods.Step(1.0, 0.0, found)
        for then in (step._replace(packing=loose), step._replace(energy=2.0)):
            steps = iter([step, then])
            with unittest.mock.patch.multiple(rods, start=unittest.mock.DEFAULT,
                                              press=unittest.mock.DEFAULT,
                                              loosen=unittest.mock.DEFAULT,
                                              rest=lambda *_: next(steps)):
                done, jammed = rods.jam(pathlib.Path(), rods.Rods(5, 0.66))
            self.assertEqual(len(done), 2)
            self.assertTrue(math.isnan(jammed))

    def test_loose_rods_bear_nothing(self) -> None:
        # Five rods that all touch, and a sixth that touches one of them.
        first, second = np.triu_indices(5, 1)
        pairs = np.array([np.append(first, 0), np.append(second, 5), np.ones(11)])
        force, contacts = rods.backbone(pairs, 6)
        self.assertEqual(len(force), 10)
        self.assertEqual(contacts.max(), 4)


class Buckypaper(unittest.TestCase):
    def test_numbers_of_lots_have_their_error_and_are_not_told_where_it_is_larger(self) -> None:
        lots = [[buckypaper.Leg(0.8, 1e-3, modulus, 0.5 * modulus)] for modulus in (0.1, -0.3, 0.3)]
        mean, error = buckypaper.mean(lots)
        self.assertAlmostEqual(error[0, 2], np.sqrt(0.28 / 9), delta=1e-12)
        self.assertEqual(buckypaper.shown(mean[0, 2], error[0, 2], 2), "not told from 0")
        self.assertEqual(buckypaper.shown(mean[0, 1], error[0, 1], 3), "0.001 +- 0.000")
        alone, unknown = buckypaper.mean(lots[:1])
        self.assertEqual(buckypaper.shown(alone[0, 2], unknown[0, 2], 2), "0.10")
        self.assertEqual(len(buckypaper.mean([*lots, []])[0]), 0)

    def test_a_power_of_the_solid_share_has_the_errors_of_both_its_ends(self) -> None:
        exponent, error = buckypaper.power(np.array([0.75, 0.5]), np.array([0.1, 1.6]),
                                           np.array([0.003, 0.064]))
        self.assertAlmostEqual(exponent, 4, delta=1e-12)
        self.assertAlmostEqual(error, 0.05 / np.log(2), delta=1e-12)


if __name__ == "__main__":
    sys.path.insert(0, sys.argv[1])
    from nanoweft.published import buckypaper, insulin, pull_out, rods, self_folding, windings
    unittest.main(argv=sys.argv[:1])
