"""Tests of scripts/bundles: python3 bundles.py NANOWEFT SCRIPTS"""
import os
import re
import sys
import unittest

import h5py
import numpy as np
from support import FolderTest, write_state

SPACING, BESIDE = 13.56, 17.3
HEXAGON = [(0, 0)] + [(np.cos(a), np.sin(a)) for a in np.arange(6) * np.pi / 3]


def tube(y, z, count=40, shift=0.0, backwards=False, spacing=SPACING):
    """A straight tube along x."""
    x = spacing * np.arange(count) + shift
    place = np.stack([x, np.full(count, y), np.full(count, z)], axis=1)
    return place[::-1] if backwards else place


def bundle(places, middle=(0.0, 0.0), **more):
    return [tube(*(np.array(middle) + BESIDE * np.array(place)), **more) for place in places]


def turned(fibres):
    """Along y instead of x."""
    return [fibre[:, [1, 0, 2]] for fibre in fibres]


def contacts_by_force(position, axis, fibre, box, distance, reach):
    """Which segments are side by side, from all pairs."""
    apart = position[None] - position[:, None]
    apart -= box * np.round(apart / box)
    cosine = axis @ axis.T
    mean = axis[:, None] + np.sign(cosine)[..., None] * axis[None]
    mean /= np.maximum(np.linalg.norm(mean, axis=2, keepdims=True), 1e-300)
    shift = (apart * mean).sum(axis=2)
    aside = np.linalg.norm(apart - shift[..., None] * mean, axis=2)
    return ((np.abs(cosine) > 0.9) & (np.abs(shift) <= reach) & (aside < distance)
            & (fibre[:, None] != fibre[None]))


class Bundles(FolderTest):
    def run_bundles(self, *arguments):
        return self.run_program(os.path.join(scripts, "bundles"), *arguments)

    def survey(self, fibres, *arguments, **more):
        """Share of segments by class of size, mean and largest size, neighbours, and the edges."""
        if fibres:
            write_state(self.path("in.h5"), fibres, **more)
        done = self.run_bundles("in.h5", *arguments)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        share = [float(text) for text in re.search("segments, % +(.*)", done.stdout)[1].split()]
        self.assertAlmostEqual(sum(share), 100, delta=0.05)
        mean, largest, neighbours = map(float, re.search(
            r"bundle ([\d.]+), largest (\d+); mean number of neighbours ([\d.]+)",
            done.stdout).groups())
        edges = {line.split()[0]: [int(text) for text in line.split()[1:]]
                 for line in done.stdout.splitlines()
                 if re.match("  (bottom|top|left|right) ", line)}
        return share, mean, largest, neighbours, edges

    def test_hexagonal_bundle(self):
        share, mean, largest, neighbours, _ = self.survey(bundle(HEXAGON))
        self.assertEqual((share, mean, largest), ([0, 0, 0, 100, 0, 0, 0], 7, 7))
        # The one in the middle touches six, the others three.
        self.assertAlmostEqual(neighbours, 24 / 7, delta=5e-4)

    def test_tubes_out_of_step_and_backwards(self):
        shifts = np.random.default_rng(1).uniform(-0.5, 0.5, 7) * SPACING
        fibres = [tube(*(BESIDE * np.array(place)), shift=shift, backwards=k % 2 == 0)
                  for k, (place, shift) in enumerate(zip(HEXAGON, shifts))]
        for every in "1", "5":
            self.assertEqual(self.survey(fibres, "--every", every)[1:3], (7, 7))

    def test_kinds_with_segments_of_their_own(self):
        # One of long segments amid six of short ones, as long as it.
        shifts = 10 + np.random.default_rng(2).uniform(-0.25, 0.25, 6) * SPACING
        fibres = [tube(0, 0, spacing=4 * SPACING)]
        fibres += [tube(*(BESIDE * np.array(place)), count=156, shift=shift)
                   for place, shift in zip(HEXAGON[1:], shifts)]
        write_state(self.path("in.h5"), fibres, kind=np.repeat([1, 0], [40, 6 * 156]))
        with h5py.File(self.path("in.h5"), "r+") as file:
            file["state/kind"].attrs["kinds"] = "short,long"
        _, mean, largest, neighbours, _ = self.survey(None, "--every", "1")
        self.assertEqual((mean, largest), (7, 7))
        # Each long segment has six beside it, each short one three.
        self.assertAlmostEqual(neighbours, (40 * 6 + 6 * 156 * 3) / 976, delta=5e-4)

    def test_two_bundles_apart(self):
        fibres = bundle(HEXAGON[:3]) + bundle(HEXAGON[:4], (60.0, 0.0))
        share, mean, largest, neighbours, _ = self.survey(fibres)
        self.assertEqual((share[2], largest), (100, 4))
        self.assertAlmostEqual(mean, (3 * 3 + 4 * 4) / 7, delta=0.006)
        # A triangle, and two triangles that share a side.
        self.assertAlmostEqual(neighbours, (3 * 2 + 2 * 5) / 7, delta=5e-4)
        # With what lies between them bridged they are one.
        self.assertEqual(self.survey(fibres, "--distance", "45")[1:3], (7, 7))

    def test_bundle_that_parts_counts_where_it_is(self):
        x = SPACING * np.arange(100)
        part = np.clip(x - x[50], 0, None) * 0.3
        fibres = [np.stack([x, sign * (part + BESIDE / 2), np.full(100, z)], axis=1)
                  for sign in (-1, 1) for z in (0, BESIDE)]
        share, _, largest, _, _ = self.survey(fibres, "--every", "1")
        # Segments 0 to 50 touch; two more to the right have those in their cross-section.
        self.assertEqual((largest, share[2], share[1]), (4, 53, 47))

    def test_short_gap_does_not_part_a_bundle(self):
        fibres = bundle(HEXAGON[:2])
        fibres[1][20, 1] += 3
        self.assertEqual(self.survey(fibres, "--every", "1")[1:3], (2, 2))

    def test_crossing_tubes_do_not_count(self):
        done = self.run_program(nanoweft, *"-weave_fibres 8,8 -weave_segments 40 -ts_max_steps 0"
                                " -state_output in.h5 -progress_interval 0".split())
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        share, mean, _, neighbours, edges = self.survey(None, "--every", "1")
        self.assertEqual((share[0], mean, neighbours), (100, 1, 0))
        self.assertEqual(set(map(tuple, edges.values())), {(1, 1, 1, 1)})

    def test_bundle_through_the_boundary(self):
        box = [-30, -10, -50], [30, 41 * SPACING, 50]
        # Along y, their distance through the boundary is BESIDE.
        apart = 60 - BESIDE
        one, other = turned(bundle([(0, 0)], (-29.0, 0.0)) + bundle([(0, 0)], (-29.0 + apart, 0.0)))
        for shift in 0, 60, -120:
            write_state(self.path("in.h5"), [one, other + [shift, 0, 0]], box=box)
            self.assertEqual(self.survey(None)[1:3], (2, 2))
        self.assertEqual(self.survey([one, other])[1:3], (1, 1))

    def test_edges(self):
        side = 60 * SPACING
        row = [(0, k) for k in range(6)]
        more = {"count": 60}
        fibres = (bundle(row[:3], (0.0, 0.0), **more) + bundle(row[:4], (side, 0.0), **more)
                  + turned(bundle(row[:5], (0.0, 0.0), **more))
                  + turned(bundle(row, (side, 0.0), **more)))
        # One that came off alone is not the edge, and one in the middle is no part of it.
        fibres += bundle([(0, 0)], (-300.0, 0.0), **more) + bundle(row, (side / 2, 0.0), **more)
        expected = {"bottom": [3] * 4, "top": [4] * 4, "left": [5] * 4, "right": [6] * 4}
        self.assertEqual(self.survey(fibres)[4], expected)
        # In a direction that is periodic, here x, there are none.
        edges = self.survey(fibres, box=([-1e4] * 3, [1e4] * 3))[4]
        self.assertEqual(set(edges), {"bottom", "top"})

    def test_against_all_pairs(self):
        sys.path.insert(0, scripts)
        from nanoweft.analysis.bundles import Fabric
        from nanoweft.states import State
        random = np.random.default_rng(3)
        side = 160.0
        for periodic in np.zeros(3, int), np.ones(3, int), np.array([1, 0, 1]):
            fibres = []
            for _ in range(60):
                bend = np.cumsum(random.normal(0, 0.15, (12, 3)), axis=0) + [1, 0, 0]
                steps = SPACING * bend / np.linalg.norm(bend, axis=1, keepdims=True)
                fibres.append(np.cumsum(steps, axis=0) + random.uniform(0, side, 3))
            position = np.concatenate(fibres)
            state = {"position": position, "fibre": np.repeat(np.arange(60), 12),
                     "index": np.tile(np.arange(12), 60),
                     "lower": np.zeros(3), "upper": np.full(3, side), "periodic": periodic}
            # Images: each lies in the box, as the program writes it.
            image = np.floor(position / side).astype(int) * periodic
            state.update(position=position - image * side, image=image)
            rows = {key: state[key] for key in ("position", "fibre", "index", "image")}
            fabric = Fabric(State(rows, state["lower"], state["upper"], periodic != 0), 20.0)
            expected = contacts_by_force(position, fabric.axis, state["fibre"],
                                         np.where(periodic, side, 1e9), 20.0, 0.75 * fabric.length)
            self.assertGreater(expected.sum(), 100)
            fibres_beside = [len(set(state["fibre"][row])) for row in expected]
            np.testing.assert_array_equal(fabric.neighbours, fibres_beside)
            np.testing.assert_array_equal(fabric.sizes(np.arange(720)),
                                          [self.size_by_force(fabric, expected, state, side, k)
                                           for k in range(720)])

    def size_by_force(self, fabric, contact, state, side, seed):
        apart = fabric.position - fabric.position[seed]
        apart -= np.where(state["periodic"], side,
                          1e9) * np.round(apart / np.where(state["periodic"], side, 1e9))
        inside = np.abs(apart @ fabric.axis[seed]) <= 2.5 * fabric.length
        found, front = {seed}, [seed]
        while front:
            row = front.pop()
            beside = [k for k in (row - 1, row + 1)
                      if 0 <= k < 720 and state["fibre"][k] == state["fibre"][row]]
            for k in [*beside, *np.flatnonzero(contact[row])]:
                if inside[k] and k not in found:
                    found.add(k)
                    front.append(k)
        return len(set(state["fibre"][list(found)]))

    def test_the_distance_follows_the_radius(self):
        state = states.of_fibres([(np.zeros((2, 3)), np.zeros((2, 4)))], (0, 0, 0), (9, 9, 9))
        self.assertEqual(bundles.usual_distance(state), 20)
        for radii, expected in ((6.78,), 20), ((68.0,), 2 * 68 + 6.44):
            state.kinds = kinds.Kinds((), radii)
            self.assertAlmostEqual(bundles.usual_distance(state), expected, 9)
        state.kinds = kinds.Kinds(("a", "b"), (6.78, 68.0))
        with self.assertRaisesRegex(Lacking, "^of fibres of different radii$"):
            bundles.usual_distance(state)
        # A radius that is given comes before those of the run.
        for given in (20.0,), (20.0, 20.0):
            self.assertAlmostEqual(bundles.usual_distance(state, given), 2 * 20 + 6.44, 9)
        with self.assertRaisesRegex(Lacking, "^of fibres of different radii$"):
            bundles.usual_distance(state, (6.78, 20.0))
        state.units = "si"
        with self.assertRaisesRegex(Lacking, "^in si units$"):
            bundles.usual_distance(state, (20.0,))
        with self.assertRaisesRegex(Lacking, "^in si units and of fibres of different radii$"):
            bundles.usual_distance(state)

    def test_a_given_radius_widens_the_distance(self):
        thick = [tube(*(43.78 * np.array(place))) for place in HEXAGON]
        self.assertEqual(self.survey(thick)[1:3], (1, 1))
        self.assertEqual(self.survey(thick, "--radius", "20")[1:3], (7, 7))

    def test_the_help_says_how_the_distance_follows(self):
        gap = bundles.usual_distance(
            states.of_fibres([(np.zeros((2, 3)), np.zeros((2, 4)))], (0, 0, 0), (9, 9, 9)), (0,))
        for script in "bundles", "analyse":
            done = self.run_program(os.path.join(scripts, script), "--help")
            self.assertIn(f"2 r + {gap:.4g} Angstrom", " ".join(done.stdout.split()))

    def test_picture(self):
        write_state(self.path("a.h5"), bundle(HEXAGON))
        write_state(self.path("b.h5"), bundle(HEXAGON[:3]))
        done = self.run_bundles("a.h5", "b.h5", "-o", "out.png")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertGreater(os.path.getsize(self.path("out.png")), 5000)

    def test_refusals(self):
        write_state(self.path("good.h5"), bundle(HEXAGON))
        write_state(self.path("dots.h5"), [tube(0, 0, count=1), tube(50, 0, count=1)])
        with open(self.path("text.h5"), "w") as file:
            file.write("no HDF5")
        for text, *arguments in (("no such file", "none.h5"), ("damaged", "text.h5"),
                                 ("no bonds", "dots.h5"),
                                 ("more than five segments", "good.h5", "--distance", "500"),
                                 ("lower --every", "good.h5", "--every", "100"),
                                 ("cannot write", "good.h5", "-o", "none/out.png"),
                                 ("invalid", "good.h5", "--distance", "-3"),
                                 ("2 radii given", "good.h5", "--radius", "1,2"),
                                 ("invalid", "good.h5", "--strip", "2"),
                                 ("required",)):
            done = self.run_bundles(*arguments)
            self.assertNotEqual(done.returncode, 0)
            self.assertNotIn("Traceback", done.stderr)
            self.assertIn(text, done.stderr.splitlines()[-1])


if __name__ == "__main__":
    nanoweft, scripts = sys.argv[1:3]
    sys.path.insert(0, scripts)
    from nanoweft import kinds, states  # noqa: E402
    from nanoweft.analysis import bundles  # noqa: E402
    from nanoweft.analysis.sample import Lacking  # noqa: E402
    unittest.main(argv=sys.argv[:1])
