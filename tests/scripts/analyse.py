"""Tests of scripts/analyse: python3 analyse.py NANOWEFT SCRIPTS"""
import csv
import os
import sys
import unittest

import numpy as np
from PIL import Image
from support import FolderTest, write_state

nanoweft, scripts = sys.argv[1:3]
sys.path.insert(0, scripts)
from nanoweft import kinds, states, units  # noqa: E402
from nanoweft.analysis import contacts, sample, shape, survey  # noqa: E402
from nanoweft.analysis.findings import Column, Settings  # noqa: E402
from nanoweft.pictures.findings import draw_trends, plt  # noqa: E402
from nanoweft.problems import Unusable  # noqa: E402

T, R = 13.56, 6.78


def line(start, direction, count=40, length=T):
    direction = np.array(direction, float) / np.linalg.norm(direction)
    return np.array(start, float) + length * np.arange(count)[:, None] * direction


def state_of(fibres, box=None, periodic=(0, 0, 0), closed=(), **more):
    """A state of these fibres, in the box as the program writes it."""
    lower, upper = np.array(box or ([-1e5] * 3, [1e5] * 3), float)
    periodic = np.array(periodic, bool)
    place = np.concatenate(fibres)
    image = np.floor((place - lower) / (upper - lower)).astype(int) * periodic
    count = [len(one) for one in fibres]
    rows = {"position": place - image * (upper - lower), "image": image,
            "fibre": np.repeat(np.arange(len(fibres)), count),
            "index": np.concatenate([np.arange(n) for n in count])}
    return states.State({**rows, **more}, lower, upper, periodic, closed=np.array(closed, int))


def measured(state, *topics, **settings):
    """The columns of these topics by name."""
    one = sample.Sample("made", state, Settings(**{"radius": (R,), **settings}))
    return {column.name: column.value for topic in topics
            for column in survey.TOPICS[topic](one).columns}


class Orientation(unittest.TestCase):
    def test_aligned_fibres_have_eigenvalues_one_and_zero(self):
        way = np.array([1, 2, 2]) / 3
        found = measured(state_of([line((0, 40 * k, 0), way * (-1)**k) for k in range(5)]),
                         "orientation")
        self.assertAlmostEqual(found["orientation_1"], 1, delta=1e-12)
        self.assertAlmostEqual(found["orientation_2"], 0, delta=1e-12)
        np.testing.assert_allclose([found["direction_" + k] for k in "xyz"], way, atol=1e-12)
        np.testing.assert_allclose([found["S2"], found["S4"], found["planar_S2"]], 1, atol=1e-12)
        self.assertAlmostEqual(found["planar_angle"], np.degrees(np.arctan2(2, 1)), delta=1e-9)

    def test_fibres_all_around_in_a_plane(self):
        angles = np.arange(12) * np.pi / 12
        fibres = [line((0, 0, 50 * k), (np.cos(a), np.sin(a), 0)) for k, a in enumerate(angles)]
        found = measured(state_of(fibres), "orientation")
        np.testing.assert_allclose([found[f"orientation_{k}"] for k in (1, 2, 3)], (0.5, 0.5, 0),
                                   atol=1e-12)
        np.testing.assert_allclose([found["planar_S2"], found["planar_S4"]], 0, atol=1e-12)

    def test_two_perpendicular_directions_have_fourfold_order_alone(self):
        found = measured(state_of([line((0, 0, 0), (1, 0, 0)), line((0, 0, 50), (0, 1, 0))]),
                         "orientation")
        np.testing.assert_allclose([found["planar_S2"], found["planar_S4"]], (0, 1), atol=1e-12)

    def test_directions_in_space_of_a_regular_solid_have_no_order(self):
        golden = (1 + 5**0.5) / 2
        ways = [np.roll((0, sign, golden), k) for k in range(3) for sign in (-1, 1)]
        found = measured(state_of([line((0, 0, 900 * k), way) for k, way in enumerate(ways)]),
                         "orientation")
        # The six axes of an icosahedron are isotropic up to the fourth order.
        np.testing.assert_allclose([found["S2"], found["orientation_1"]], (0, 1 / 3), atol=1e-12)
        self.assertAlmostEqual(found["S4"], 0, delta=1e-12)


class Shape(unittest.TestCase):
    def arc(self, radius, count):
        angle = 2 * np.arcsin(T / (2 * radius)) * np.arange(count)
        place = radius * np.column_stack([np.sin(angle), np.cos(angle), 0 * angle])
        return place, angle[-1]

    def test_circular_arc(self):
        place, angle = self.arc(300.0, 50)
        found = measured(state_of([place]), "crimp", "curvature")
        chord = 2 * 300 * np.sin(angle / 2)
        self.assertAlmostEqual(found["crimp_mean"], 49 * T / chord - 1, delta=1e-12)
        np.testing.assert_allclose([found["curvature_rms"], found["curvature_max"]], 1 / 300,
                                   rtol=1e-12)
        self.assertAlmostEqual(found["torsion_rms"], 0, delta=1e-9)

    def test_crimp_is_from_the_first_centre_to_the_last(self):
        angle = np.pi * (np.arange(6) + 0.5) / 6
        place = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
        found = measured(state_of([place]), "crimp")
        # The half segments would make it 0.503; a semicircle has pi/2 - 1.
        self.assertAlmostEqual(found["crimp_mean"], 0.340, delta=5e-4)

    def test_helix(self):
        radius, slope = 200.0, 60.0
        whole = radius**2 + slope**2
        # Four whole turns of the places that have a curvature, so that one wave holds it all.
        angle = 2 * np.pi / 314 * np.arange(4 * 314 + 2)
        for hand in 1, -1:
            helix = np.column_stack([radius * np.cos(angle), hand * radius * np.sin(angle),
                                     slope * angle])
            found = measured(state_of([helix]), "curvature")
            self.assertAlmostEqual(found["curvature_rms"] * whole / radius, 1, delta=1e-4)
            self.assertAlmostEqual(found["torsion_mean"] * whole / slope, hand, delta=1e-4)
            self.assertAlmostEqual(found["wave_length"], 2 * np.pi * np.sqrt(whole), delta=0.05)

    def wave(self, amplitude, length, count):
        x = [0.0]
        height = lambda s: amplitude * np.sin(2 * np.pi * s / length)  # noqa: E731
        for _ in range(count - 1):
            slope = amplitude * 2 * np.pi / length * np.cos(2 * np.pi * x[-1] / length)
            step = T / np.hypot(1, slope)
            for _ in range(8):  # Newton, to equal chords
                rise = height(x[-1] + step) - height(x[-1])
                slope = amplitude * 2 * np.pi / length * np.cos(2 * np.pi * (x[-1] + step) / length)
                step -= (step**2 + rise**2 - T**2) / (2 * (step + rise * slope))
            x.append(x[-1] + step)
        return np.column_stack([x, height(np.array(x)), np.zeros(count)])

    def test_sine_wave_is_one_peak_of_its_spectrum(self):
        place = self.wave(2.0, 40 * T, 322)
        state = state_of([place])
        found = measured(state, "curvature", "crimp")
        self.assertAlmostEqual(found["wave_length"] / (40 * T), 1, delta=2e-3)
        self.assertAlmostEqual(found["wave_amplitude"] / 2, 1, delta=5e-3)
        self.assertAlmostEqual(found["torsion_rms"], 0, delta=1e-6)
        one = sample.Sample("made", state, Settings())
        bend = shape.bends(one)
        _, power = shape.spectrum(one, bend.nodes, bend.curvature)
        self.assertGreater(power.max(), 0.999 * power.sum())
        mean = bend.curvature.mean(axis=0)
        self.assertAlmostEqual(power.sum() / (bend.curvature**2).sum(axis=1).mean() + mean @ mean,
                               1, delta=1e-9)
        self.assertAlmostEqual(found["crimp_mean"], (np.pi * 2 / (40 * T))**2, delta=2e-6)

    def test_fibre_through_the_boundary_keeps_its_shape(self):
        place, _ = self.arc(300.0, 50)
        whole = measured(state_of([place]), "crimp", "curvature")
        cut = measured(state_of([place - 77], ([-200] * 3, [200] * 3), (1, 1, 1)), "crimp",
                       "curvature")
        for name, value in whole.items():
            np.testing.assert_allclose(cut[name], value, atol=1e-9, err_msg=name)

    def test_endless_wave_in_a_periodic_box(self):
        x = np.arange(100) / 100 * 1000
        y = 50 * np.sin(2 * np.pi * x / 1000)
        wave = np.column_stack([x, y, 0 * x])
        found = measured(state_of([wave], ([0, -99, -99], [1000, 99, 99]), (1, 0, 0), (0,)),
                         "crimp", "curvature")
        chords = np.linalg.norm(np.diff(np.vstack([wave, [1000, 0, 0]]), axis=0), axis=1).sum()
        self.assertAlmostEqual(found["crimp_max"], chords / 1000 - 1, delta=1e-12)
        self.assertAlmostEqual(found["wave_length"], chords, delta=1e-6)

    def test_ring_has_no_crimp_until_it_breaks(self):
        angle = 2 * np.pi * np.arange(60) / 60
        ring = 150 * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
        with self.assertRaisesRegex(sample.Lacking, "no crimp"):
            measured(state_of([ring], closed=(0,)), "crimp")
        broken = np.zeros(60, np.int8)
        broken[[10, 40]] = 1
        found = measured(state_of([ring], closed=(0,), bond_broken=broken), "crimp")
        # Two halves, of 30 segments each; one of them through the closing bond.
        half = 29 * np.sin(np.pi / 60) / np.sin(29 * np.pi / 60) - 1
        np.testing.assert_allclose([found["crimp_mean"], found["crimp_max"]], half, rtol=1e-12)


class Space(unittest.TestCase):
    def lattice(self, rods=4, apart=40.0, shift=0.0):
        """Endless rods along x on a square lattice, in a box that is periodic in all directions."""
        side = rods * apart
        fibres = [line((0.3, j * apart + shift, k * apart), (1, 0, 0), 12)
                  for j in range(rods) for k in range(rods)]
        return state_of(fibres, ([0, 0, 0], [12 * T, side, side]), (1, 1, 1), range(rods**2))

    def test_ends_are_flat_for_porosity_and_round_for_contacts(self):
        rod = line((0, 0, 0), (1, 0, 0), 3)
        self.assertAlmostEqual(measured(state_of([rod]), "porosity")["extent_x"], 3 * T)
        for apart, expected in ((3 * T + 2 * R + 6.3, 1), (3 * T + 2 * R + 6.5, 0)):
            found = measured(state_of([rod, rod + [apart, 0, 0]]), "contacts")
            self.assertEqual(found["contacts"], expected)

    def test_square_lattice_of_rods(self):
        found = measured(self.lattice(), "porosity", "pores", axis=0, cells=20000)
        self.assertAlmostEqual(found["porosity"], 1 - np.pi * R**2 / 1600, delta=1e-12)
        # On the diagonal, halfway between two axes.
        for name in "circle_max", "sphere_max":
            self.assertAlmostEqual(found[name], 40 * 2**0.5 - 2 * R, delta=1e-5)
        self.assertAlmostEqual(found["open_area"], found["porosity"], delta=0.01)
        self.assertLess(found["circle_mean"], found["circle_max"])
        self.assertGreater(found["circle_mean"], 0.85 * found["circle_max"])

    def test_a_row_of_rods_seen_from_above_leaves_slits(self):
        found = measured(self.lattice(), "pores", axis=2, cells=20000)
        self.assertAlmostEqual(found["circle_max"], 40 - 2 * R, delta=1e-5)
        self.assertAlmostEqual(found["circle_mean"], 40 - 2 * R, delta=1.5)
        self.assertAlmostEqual(found["open_area"], 1 - 2 * R / 40, delta=0.01)

    def below(self, y):
        """Area of a disc around 0 below y."""
        t = np.clip(y / R, -1, 1)
        return R**2 * (np.pi / 2 + t * np.sqrt(1 - t * t) + np.arcsin(t))

    def test_profile_is_exact_and_periodic(self):
        for shift in 0.0, 13.0:
            one = sample.Sample("made", self.lattice(shift=shift),
                                Settings(axis=1, bins=16, radius=(R,)))
            curve, = (c for c in survey.porosity(one).curves if c.name == "fraction_profile")
            # Layers at y = 0, 40, ... and slabs of 10: the discs' parts in them.
            edges = np.arange(-1, 18) * 10.0
            parts = sum(np.diff(self.below(edges - 40 * k - shift)) for k in range(-1, 6))
            np.testing.assert_allclose(curve.y, parts[1:17] * 4 / (10 * 160), atol=1e-12)
            self.assertAlmostEqual(curve.y.mean(), np.pi * R**2 / 1600, delta=1e-12)

    def test_inclined_cylinder_in_a_profile(self):
        way = np.array([1, 0, 1]) / 2**0.5
        state = state_of([line((0, 0, 0), way, 3)])
        found = measured(state, "porosity")
        high = 3 * T / 2**0.5 + 2 * R / 2**0.5
        np.testing.assert_allclose([found["extent_x"], found["extent_y"], found["extent_z"]],
                                   [high, 2 * R, high])
        self.assertAlmostEqual(found["fibre_volume"], np.pi * R**2 * 3 * T, delta=1e-9)
        one = sample.Sample("made", state, Settings(bins=10, radius=(R,)))
        curve = survey.porosity(one).curves[0]
        # By random points in the cylinder.
        random = np.random.default_rng(1)
        along = random.uniform(-0.5, 2.5, 200000) * T
        aside = R * np.sqrt(random.random(200000)) * np.cos(2 * np.pi * random.random(200000))
        limits = T / 2**0.5 + np.array([-0.5, 0.5]) * high
        expected = np.histogram((along + aside) / 2**0.5, 10, limits)[0] / len(along)
        np.testing.assert_allclose(curve.y / curve.y.sum(), expected, atol=0.004)

    def test_region_cuts_fibres(self):
        state = state_of([line((0, 0, 0), (1, 0, 0)), line((0, 0, 500), (1, 0, 0))])
        found = measured(state, "porosity",
                         region={0: (100.0, 150.0), 1: (-10.0, 10.0), 2: (-50.0, 50.0)})
        self.assertAlmostEqual(found["volume_fraction"], np.pi * R**2 / 2000, delta=1e-12)
        # Across a periodic boundary, from either side of it.
        box = [0, -99, -99], [40 * T, 99, 99]
        for low in 0.0, -30.0, 40 * T - 30:
            found = measured(state_of([line((0, 0, 0), (1, 0, 0))], box, (1, 0, 0), (0,)),
                             "porosity",
                             region={0: (low, low + 60), 1: (-10.0, 10.0), 2: (-50.0, 50.0)})
            self.assertAlmostEqual(found["volume_fraction"], np.pi * R**2 / 2000, delta=1e-12)


    def test_region_cuts_fibres_lengthwise(self):
        # A sheet of fibres at z = 0, 14 A apart; the region covers eight of them.
        state = state_of([line((0, 14.0 * k, 0), (1, 0, 0)) for k in range(-3, 11)])
        for low, high in ((-2.0, 2.0), (0.5, 6.0), (-R, R), (-20.0, 60.0)):
            limits = {0: (100.0, 150.0), 1: (-7.0, 7 * 14 + 7.0), 2: (low, high)}
            found = measured(state, "porosity", region=limits)
            area = 8 * (self.below(high) - self.below(low))
            self.assertAlmostEqual(found["volume_fraction"], area / (8 * 14 * (high - low)),
                                   delta=1e-12)
        # Where two faces cut a fibre, its quarters count by the product of both shares.
        found = measured(state_of([line((0, 0, 0), (1, 1, 0))]), "porosity",
                         region={0: (100.0, 200.0), 1: (100.0, 200.0), 2: (-50.0, 50.0)})
        across = np.linspace(-R, R, 2001)[:-1] + R / 2000
        chord = 2 * np.sqrt(R**2 - across**2)
        exact = (chord * (100 * 2**0.5 - 2 * np.abs(across))).sum() * R / 1000
        self.assertAlmostEqual(found["fibre_volume"] / exact, 1, delta=0.02)

    def test_a_projection_leaves_out_what_is_beyond_the_region(self):
        sheet = [line((0, 40.0 * k, 0), (1, 0, 0)) for k in range(8)]
        stray = [line((0, 40.0 * k + 20, 500), (1, 0, 0)) for k in range(7)]
        limits = {0: (100.0, 400.0), 1: (0.0, 280.0), 2: (-20.0, 20.0)}
        alone, both = (measured(state_of(fibres), "pores", axis=2, cells=5000, region=limits)
                       for fibres in (sheet, sheet + stray))
        for name in "open_area", "circle_max":
            self.assertEqual(alone[name], both[name])


class Contacts(unittest.TestCase):
    def test_crossings_count_once_each(self):
        pitch, gap = 5.5 * T, 2 * R + 3.4
        # Six by six, some crossings in the middle of a segment and some at its end.
        fibres = ([line((0, pitch * (k + 0.5), 0), (1, 0, 0)) for k in range(6)]
                  + [line((pitch * (k + 0.5), 0, gap), (0, 1, 0)) for k in range(6)])
        found = measured(state_of(fibres), "contacts")
        self.assertEqual((found["contacts"], found["contacts_per_fibre"]), (36, 6))
        self.assertEqual(found["partners_per_fibre"], 6)
        self.assertAlmostEqual(found["least_gap"], 3.4, delta=1e-9)
        self.assertAlmostEqual(found["contact_distance"], 12 * 40 * T / 72, delta=1e-9)
        self.assertEqual(measured(state_of(fibres), "contacts", gap=3.3)["contacts"], 0)

    def test_side_by_side_is_one_contact(self):
        one, other = line((0, 0, 0), (1, 0, 0)), line((3, 17.1, 0), (1, 0, 0))
        for pair in ([one, other], [one, other[::-1]]):
            self.assertEqual(measured(state_of(pair), "contacts")["contacts"], 1)
        bowed = other.copy()
        bowed[15:25, 1] += 30
        self.assertEqual(measured(state_of([one, bowed]), "contacts")["contacts"], 2)

    def test_what_breaks_leave_of_a_fibre_counts_as_one_each(self):
        fibres = [line((0, (2 * R + 3) * k, 0), (1, 0, 0), 20) for k in range(3)]
        for order in (0, 1, 2), (1, 0, 2), (0, 2, 1):
            broken = np.zeros((3, 20), np.int8)
            broken[order.index(1), 9] = 1
            state = state_of([fibres[k] for k in order], bond_broken=broken.ravel())
            found = measured(state, "contacts")
            self.assertEqual([found[name] for name in ("contacts", "contacts_per_fibre",
                                                       "partners_per_fibre")], [4, 2, 2])

    def test_contact_through_the_boundary(self):
        box = [0, 0, 0], [600, 600, 600]
        fibres = [line((20, 590, 300), (1, 0, 0), 20), line((100, 7.1, 200), (0, 0, 1), 20)]
        self.assertEqual(measured(state_of(fibres, box, (0, 1, 0)), "contacts")["contacts"], 1)
        self.assertEqual(measured(state_of(fibres, box), "contacts")["contacts"], 0)

    def test_endless_rods_side_by_side_touch_once(self):
        rods = [line((0, 0, 0), (1, 0, 0), 20), line((5, 17.1, 0), (1, 0, 0), 20)]
        state = state_of(rods, ([0, -99, -99], [20 * T, 99, 99]), (1, 0, 0), (0, 1))
        self.assertEqual(measured(state, "contacts")["contacts"], 1)

    def test_pairs_of_two_kinds_against_all_pairs(self):
        random = np.random.default_rng(5)
        side, of = 260.0, np.repeat([0, 1], [30, 5])
        fibres = []
        for kind in of:
            bend = np.cumsum(random.normal(0, 0.15, (9, 3)), axis=0) + random.normal(0, 1, 3)
            steps = (T, 40.0)[kind] * bend / np.linalg.norm(bend, axis=1, keepdims=True)
            fibres.append(np.cumsum(steps, axis=0) + random.uniform(0, side, 3))
        for periodic in (1, 0, 1), (1, 1, 1):
            state = states.of_kinds(state_of(fibres, ([0] * 3, [side] * 3), periodic),
                                    ("thin", "thick"), of)
            one = sample.Sample("made", state, Settings(radius=(6.0, 20.0)))
            touching, least = contacts.pairs(one, 5.0)
            found = set(map(tuple, touching.tolist()))
            expected, closest = self.by_points(one, 5.0)
            self.assertGreater(len(expected), 50)
            # Points on the pieces are a little farther from each other than the pieces.
            self.assertLessEqual(expected, found)
            self.assertLess(len(found - expected), 0.05 * len(found) + 3)
            self.assertAlmostEqual(least, closest, delta=0.5)

    def by_points(self, one, gap):
        """The same from points on all pieces."""
        pieces = one.pieces
        part = np.linspace(0, 1, 9)
        points = pieces.begin[:, None] + part[:, None] * pieces.vector[:, None]
        radius, fibre = one.thickness[one.kind[pieces.row]], one.fibre[pieces.row]
        found, closest = set(), np.inf
        for a in range(len(pieces)):
            others = np.flatnonzero(fibre > fibre[a])
            apart = points[others][:, None] - points[a][None, :, None]
            apart -= np.where(one.state.periodic, one.state.box * np.round(apart / one.state.box),
                              0)
            least = np.sqrt((apart**2).sum(axis=-1).min(axis=(1, 2))) - radius[a] - radius[others]
            found |= {(a, b) for b in others[least < gap]}
            closest = min(closest, least.min(initial=np.inf))
        return found, closest


class Loads(unittest.TestCase):
    def setUp(self):
        # Thin fibres, one stretched by 1 %, one that has flowed as far; a thick one pressed by 2 %.
        fibres = [line((0, 0, 0), (1, 0, 0), 11, 1.01 * T),
                  line((0, 50, 0), (1, 0, 0), 11, 1.01 * T),
                  line((0, 200, 0), (0, 0, 1), 6, 0.98 * 40)]
        flowed = np.repeat([0, 0.01 * T, 0], (11, 11, 6))
        self.state = states.of_kinds(state_of(fibres, rest_extension=flowed), ("thin", "thick"),
                                     [0, 0, 1])
        self.state.run["fibre"] = np.array([R, T, 2649 * units.AMU, 1, 60, 1, 1, 1,
                                            20.0, 40.0, 9e6, 1, 300, 1, 1, 1])
        self.state.kinds = kinds.Kinds(("thin", "thick"), (R, 20.0))

    def test_stress_of_stretched_fibres(self):
        one = sample.Sample("made", self.state, Settings())
        found = survey.TOPICS["stress"](one)
        each = next(curve.y for curve in found.curves if curve.name == "stress_by_fibre")
        thin = 60 * 0.01 * T / (np.pi * R**2) / units.GPA
        thick = -300 * 0.02 * 40 / (np.pi * 400) / units.GPA
        np.testing.assert_allclose(each, [thin, 0, thick], atol=1e-9)
        numbers = {column.name: column.value for column in found.columns}
        np.testing.assert_allclose([numbers["stress_" + name] for name in ("min", "max", "mean")],
                                   [thick, thin, (10 * thin + 5 * thick) / 25], atol=1e-9)

    def test_a_stretched_fibre_has_the_mass_of_its_segments(self):
        for strain in 0.0, 0.2:
            long = T * (1 + strain)
            box = [0, -20, -20], [12 * long, 20, 20]
            state = state_of([line((0.1, 0, 0), (1, 0, 0), 12, long)], box, (1, 1, 1), (0,))
            state.run["fibre"] = np.array([R, T, 2649 * units.AMU, 1, 60, 1, 1, 1])
            state.kinds = kinds.Kinds((), (R,))
            grams = 12 * 2649 * 1.66053906660e-24
            self.assertAlmostEqual(measured(state, "porosity", radius=())["density"],
                                   grams / (12 * long * 1600 * 1e-24), delta=1e-9)

    def test_density_in_grams(self):
        limits = {0: (20.0, 60.0), 1: (-10.0, 10.0), 2: (-10.0, 10.0)}
        found = measured(self.state, "porosity", radius=(), region=limits)
        grams = 2649 * 1.66053906660e-24 * 40 / (1.01 * T)  # stretched by 1 %
        self.assertAlmostEqual(found["density"], grams / (40 * 20 * 20 * 1e-24), delta=1e-6)

    def test_energy_of_each_kind(self):
        one = sample.Sample("made", self.state, Settings())
        one.fields = {f"{part}_energy": np.arange(28) * (k + 1.0)
                      for k, part in enumerate(("stretch", "shear", "bending", "torsion", "pair"))}
        found = {column.name: column.value for column in survey.TOPICS["energy"](one).columns}
        self.assertEqual((found["energy_stretch_thin"], found["energy_pair_thick"]), (231, 5 * 147))
        self.assertEqual(found["energy_elastic_thick"], 10 * 147)

    def test_energy_of_links_is_named(self):
        one = sample.Sample("made", self.state, Settings())
        one.fields = {f"{part}_energy": np.ones(28)
                      for part in ("stretch", "shear", "bending", "torsion", "pair")}
        for links, stretch, elastic in (
                ([], "stretch of thin", "all of the bonds of thin"),
                ([[0, 12]], "stretch of thin in bonds and links",
                 "all of the bonds and links of thin")):
            self.state.links = np.reshape(links, (-1, 2)).astype(int)
            text = {column.name: column.meaning
                    for column in survey.TOPICS["energy"](one).columns}
            self.assertEqual((text["energy_stretch_thin"], text["energy_elastic_thin"],
                              text["energy_pair_thin"]), (stretch, elastic, "pair of thin"))

    def test_bundle_of_three(self):
        places = [(0, 0), (17.3, 0), (17.3 / 2, 15), (300, 0)]
        found = measured(state_of([line((0, y, z), (1, 0, 0)) for y, z in places]), "bundles")
        self.assertEqual((found["bundle_max"], found["bundle_mean"], found["bundle_alone"]),
                         (3, 2.5, 0.25))

    def test_a_given_radius_is_that_of_bundles_and_of_the_stress(self):
        turns = np.arange(6) * np.pi / 3
        places = 43.78 * np.column_stack([np.cos(turns), np.sin(turns)])
        state = state_of([line((0, y, z), (1, 0, 0)) for y, z in [(0, 0), *places]])
        found = measured(state, "bundles", "contacts", radius=(20.0,))
        self.assertEqual((found["bundle_mean"], found["bundle_alone"], found["contacts"]),
                         (7, 0, 12))
        found, thin = (measured(self.state, "stress", radius=radii) for radii in ((2 * R, 20), ()))
        self.assertAlmostEqual(found["stress_max"], thin["stress_max"] / 4, delta=1e-9)


class Command(FolderTest):
    def analyse(self, *arguments):
        return self.run_program(os.path.join(scripts, "analyse"), *arguments)

    def table(self, name):
        with open(self.path(name), newline="") as file:
            lines = file.readlines()
        return lines, list(csv.DictReader(line for line in lines if not line.startswith("#")))

    def test_snapshots_of_a_run(self):
        frames = self.simulate(nanoweft, "-weave_fibres 4,4 -weave_segments 24 -ts_max_steps 60"
                               " -damping_local 0.4 -snapshot_interval 60 -monitor_interval 60"
                               " -energy_monitor ascii:energy.csv")
        done = self.analyse(*frames, "-o", "table.csv", "--curves", "curves.csv", "--cells", "9000")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        lines, rows = self.table("table.csv")
        self.assertEqual([row["step"] for row in rows], ["0", "60"])
        for name in list(rows[0])[3:]:
            self.assertTrue(any(text.startswith(f"# {name} [") for text in lines), name)
        # Sixteen crossings, and the energies of the run's own table; /field is in single precision.
        self.assertEqual([float(row["contacts"]) for row in rows], [16, 16])
        _, energies = self.table("energy.csv")
        for row, energy in zip(rows, energies):
            for part in "stretch", "bending", "pair":
                expected = float(energy[part])
                self.assertAlmostEqual(float(row[f"energy_{part}"]), expected,
                                       delta=1e-5 * abs(expected) + 1e-6)
        # Just laid, fibres are neither stretched nor pressed.
        self.assertAlmostEqual(float(rows[0]["stress_mean"]), 0, delta=1e-3)
        self.assertNotEqual(float(rows[1]["stress_mean"]), 0)
        _, points = self.table("curves.csv")
        self.assertEqual(sum(one["curve"] == "stress_by_fibre" for one in points), 16)

    def test_what_a_state_made_by_hand_lacks(self):
        write_state(self.path("hand.h5"), [line((0, 20 * k, 0), (1, 0, 0)) for k in range(3)])
        done = self.analyse("hand.h5", "--bins", "10")
        self.assertEqual(done.returncode, 0)
        for text in "give --radius", "-snapshot_file", "no stress", "no energy":
            self.assertIn(text, done.stderr)
        self.assertIn("orientation_1", done.stdout)
        self.assertNotIn("porosity", done.stdout)
        done = self.analyse("hand.h5", "--what", "porosity", "--radius", "6.78", "--region",
                            "z=-10,10")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("porosity", done.stdout)

    def test_plots_of_one_and_of_two_files(self):
        for k, gap in enumerate((20.0, 30.0)):
            write_state(self.path(f"{k}.h5"), [line((0, gap * j, 0), (1, 0, 0)) for j in range(3)],
                        5.0 * k)
        sizes = []
        for files in (["0.h5"], ["0.h5", "1.h5"]):
            done = self.analyse(*files, "--radius", "6.78", "--what", "porosity", "--plot",
                                "out.png")
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            with Image.open(self.path("out.png")) as picture:
                sizes.append(picture.size)
        # The numbers over time have a panel of their own.
        self.assertGreater(sizes[1][0], 1.5 * sizes[0][0])

    def test_trends_have_a_line_for_each_stage(self):
        rows = []
        for stage, time in (1, 50.0), (0, 300.0), (1, 0.0), (0, 0.0):
            state = state_of([line((0, 0, 0), (1, 0, 0))])
            state.time, state.run = time, {"stage": np.array([stage])}
            column = Column("a", 1000 * stage + time, "1", "")
            rows.append(survey.Row("made", state, [column], [], (("a",),)))
        figure, panel = plt.subplots()
        draw_trends(panel, ("a",), rows)
        self.assertEqual([(each.get_label(), each.get_xdata().tolist(), each.get_ydata().tolist())
                          for each in panel.lines],
                         [("a, stage 1", [0, 300], [0, 300]), ("a, stage 2", [0, 50],
                                                               [1000, 1050])])
        plt.close(figure)

    def test_refusals(self):
        write_state(self.path("good.h5"), [line((0, 0, 0), (1, 0, 0))])
        write_state(self.path("state.csv"), [line((0, 0, 0), (1, 0, 0))])
        with open(self.path("text.h5"), "w") as file:
            file.write("no HDF5")
        for text, *arguments in (("damaged", "text.h5"),
                                 ("2 radii given", "good.h5", "--radius", "1,2"),
                                 ("cannot write", "good.h5", "--what", "crimp", "-o", "none/a.csv"),
                                 ("'colour' is none of", "good.h5", "--what", "crimp,colour"),
                                 ("invalid", "good.h5", "--region", "z=3,2"),
                                 ("is a state", "-o", "good.h5", "text.h5"),
                                 ("is a state", "-o", "state.csv", "state.csv"),
                                 ("different names", "good.h5", "-o", "a.csv", "--curves",
                                  "a.csv")):
            with self.subTest(text=text):
                done = self.analyse(*arguments)
                self.assertIn(done.returncode, (1, 2))
                self.assertNotIn("Traceback", done.stderr)
                self.assertIn(text, done.stderr.splitlines()[-1])
                self.assertFalse(os.path.exists(self.path("none")))

    def test_bundles_of_different_radii_need_a_distance(self):
        state = states.of_kinds(state_of([line((0, 0, 0), (1, 0, 0)), line((0, 40, 0), (1, 0, 0))]),
                                ("thin", "thick"), (0, 1))
        with self.assertRaisesRegex(sample.Lacking, "^made: of fibres of different radii; give"
                                    " --beside$"):
            measured(state, "bundles", radius=(R, 2 * R))
        self.assertIn("bundle_mean", measured(state, "bundles", radius=(R, 2 * R), beside=30.0))

    def test_a_topic_that_is_asked_for_needs_its_data(self):
        write_state(self.path("good.h5"), [line((0, 0, 0), (1, 0, 0))])
        write_state(self.path("dots.h5"), [line((0, 0, 0), (1, 0, 0), 1)])
        for text, name, topic in (("give --radius", "good.h5", "pores"),
                                  ("give --radius", "good.h5", "contacts"),
                                  ("no bonds", "dots.h5", "orientation"),
                                  ("no fibre of two segments", "dots.h5", "crimp"),
                                  ("no fibre of three segments", "dots.h5", "curvature"),
                                  ("-state_output", "good.h5", "stress"),
                                  ("-snapshot_file", "good.h5", "energy")):
            with self.subTest(topic=topic), self.assertRaisesRegex(sample.Lacking, text):
                survey.look(self.path(name), [topic], Settings(), None)
        with self.assertRaisesRegex(Unusable, "more than five segments"):
            survey.look(self.path("good.h5"), ["contacts"], Settings(radius=(R,), gap=900.0), {})
        # A lone segment has the direction of its orientation.
        row = survey.look(self.path("dots.h5"), ["orientation", "contacts"],
                          Settings(length=T, radius=(R,)), None)
        self.assertEqual((row.value("orientation_xx"), row.value("contacts")), (1, 0))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
