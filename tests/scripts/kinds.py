"""Tests of the scripts on states with several kinds of fibres: python3 kinds.py SCRIPTS"""
import base64
import json
import os
import re
import sys
import unittest

import h5py
import numpy as np
from PIL import Image
from support import FolderTest, read_state, write_state

THIN, THICK = 6.78, 68.0


def straight(start, count, spacing):
    place = np.tile(np.array(start, float), (count, 1))
    place[:, 0] += spacing * np.arange(count)
    return place


def write_two(name, names="cnt,glass", radii=(THIN, THICK), kind=None, **more):
    """A thin fibre of 101 segments at y = 0 and a thick one of 11 at y = 200, as of a run."""
    kind = np.repeat(np.int32([0, 1]), [101, 11]) if kind is None else kind
    write_state(name, [straight((0, 0, 0), 101, 13.6), straight((0, 200, 0), 11, 136)],
                kind=kind, **more)
    with h5py.File(name, "r+") as file:
        if names is not None:
            file["state/kind"].attrs["kinds"] = names
        if radii:
            fibre = [(radius, 2 * radius, 1, 1, 1, 1, 1, 1) for radius in radii]
            file.create_group("run").attrs["fibre"] = np.ravel(fibre).astype(float)
    return name


def pixels(name):
    return np.asarray(Image.open(name).convert("RGB")).astype(int)


def thickness(picture, column):
    """Lengths of the coloured runs of a column, from above."""
    coloured = np.ptp(picture[:, column], axis=1) > 25
    edges = np.flatnonzero(np.diff(np.concatenate([[0], coloured, [0]])))
    return edges[1::2] - edges[::2]


class Kinds(FolderTest):
    def script(self, name, *arguments):
        return self.run_program(os.path.join(scripts, name), *arguments)

    def expect(self, name, *arguments):
        done = self.script(name, *arguments)
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def expect_refusal(self, text, name, *arguments):
        done = self.script(name, *arguments)
        self.assertNotEqual(done.returncode, 0)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        self.assertIn(text, done.stderr)

    def draw(self, *arguments):
        self.expect("render", *arguments, "-o", "out.png")
        return pixels(self.path("out.png"))

    # Without legend, 1360 A and half a thick segment at both ends fill 96 % of the width.
    PIXEL = (1360 + 2 * THICK) / (0.96 * 800)

    def test_each_tube_is_drawn_with_the_radius_of_its_kind(self):
        write_two(self.path("in.h5"))
        view = ["in.h5", "--size", "800x300", "--color", "fibre"]
        thick, thin = thickness(self.draw(*view), 400)
        self.assertAlmostEqual(thick, 2 * THICK / self.PIXEL, delta=2)
        self.assertAlmostEqual(thin, 2 * THIN / self.PIXEL, delta=2)
        thick, thin = thickness(self.draw(*view, "--radius", "20,68"), 400)
        self.assertAlmostEqual(thick, 2 * THICK / self.PIXEL, delta=2)
        self.assertAlmostEqual(thin, 2 * 20 / self.PIXEL, delta=2)
        both = thickness(self.draw(*view, "--radius", "20"), 400)
        self.assertAlmostEqual(both[0], both[1], delta=1)

    def test_kinds_have_a_colour_each_and_a_legend(self):
        write_two(self.path("in.h5"))
        for dark in [], ["--dark"]:
            picture = self.draw("in.h5", "--size", "800x300", *dark)
            legend = picture[:60, -75:]
            self.assertGreater((np.ptp(legend, axis=2) > 60).sum(), 40)
            rows = np.flatnonzero(np.ptp(picture[:, 300], axis=1) > 25)
            split = rows[np.argmax(np.diff(rows)) + 1]
            thick = picture[rows[rows < split], 300].mean(axis=0)
            thin = picture[rows[rows >= split], 300].mean(axis=0)
            self.assertGreater(thin[2], thin[0] + 20)     # the first kind is blue, the second sand
            self.assertGreater(thick[0], thick[2] + 60)
        np.testing.assert_array_equal(picture, self.draw("in.h5", "--size", "800x300", "--dark",
                                                         "--color", "kind"))

    def test_one_kind_needs_no_legend(self):
        write_state(self.path("in.h5"), [straight((0, 0, 0), 20, 13.56)])
        plain, coloured = (self.draw("in.h5", "--size", "300x200", *more)
                           for more in ((), ("--color", "fibre")))
        np.testing.assert_array_equal(plain, coloured)

    def test_export(self):
        state = read_state(write_two(self.path("in.h5")))
        self.expect("export", "in.h5", "-o", "out.xyz")
        with open(self.path("out.xyz")) as file:
            _, header, *rows = file.read().splitlines()
        self.assertIn(":bond_broken:I:1:radius:R:1 step", header)
        rows = [row.split() for row in rows]
        self.assertEqual([row[0] for row in rows], ["cnt"] * 101 + ["glass"] * 11)
        self.assertEqual([float(row[-1]) for row in rows], [THIN] * 101 + [THICK] * 11)
        self.expect("export", "in.h5", "-o", "out.dump")
        with open(self.path("out.dump")) as file:
            *_, header = (file.readline().split() for _ in range(9))
            rows = np.array([line.split() for line in file], float)
        columns = dict(zip(header[2:], rows.T, strict=True))
        np.testing.assert_array_equal(columns["type"], state["kind"] + 1)
        np.testing.assert_array_equal(columns["radius"], np.repeat([THIN, THICK], [101, 11]))
        # Where no run says how thick they are, a viewer shall not read a number.
        write_two(self.path("hand.h5"), radii=())
        self.expect("export", "hand.h5", "-o", "hand.xyz")
        with open(self.path("hand.xyz")) as file:
            self.assertNotIn("radius", file.read())

    def test_report(self):
        state = read_state(write_two(self.path("final.h5")))
        self.expect("report", self.folder)
        with open(self.path("report.html"), encoding="utf-8") as file:
            page = file.read()
        self.assertIn("2 kinds: cnt, glass", page)
        found = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.S)
        series, = json.loads(found[1])["series"]
        self.assertEqual((series["kinds"], series["radii"]), (["cnt", "glass"], [THIN, THICK]))
        np.testing.assert_array_equal(np.frombuffer(base64.b64decode(series["kind"]), np.uint8),
                                      state["kind"])
        self.expect_refusal("--radius: 3 radii given, but the kinds are 2 (cnt, glass)", "report",
                            self.folder, "--radius", "1,2,3")

    def test_wrong_kinds_are_told_in_a_line(self):
        wrong = np.repeat(np.int32([0, 1]), [101, 11])
        wrong[105] = 2
        write_two(self.path("range.h5"), kind=wrong)
        write_two(self.path("negative.h5"), kind=-wrong)
        write_two(self.path("nameless.h5"), names=None, radii=(THIN,))
        write_two(self.path("blank.h5"), names="cnt,,glass")
        write_two(self.path("twice.h5"), names="cnt,cnt")
        write_two(self.path("real.h5"), kind=wrong.astype(float))
        write_two(self.path("short.h5"), kind=wrong[:5])
        write_two(self.path("fibre.h5"), radii=(THIN,))
        for name, text in (
                ("range", "segment 105 is of kind 2, but kinds names 2 (cnt, glass), from 0 on"),
                ("negative", "segment 101 is of kind -1"),
                ("nameless", "segment 101 is of kind 1, but the dataset kind has no attribute"),
                ("blank", "kinds is 'cnt,,glass', not names"),
                ("twice", "kinds is 'cnt,cnt', not names"),
                ("real", "kind holds no whole numbers"),
                ("short", "kind does not match the 112 segments"),
                ("fibre",
                 "fibre of /run does not hold 8 numbers, first a radius above 0, for each")):
            self.expect_refusal(f"{name}.h5: {text}", "export", f"{name}.h5", "-o", "out.xyz")
        for name, text in (("range", "segment 105 is of kind 2"),
                           ("fibre", "fibre of /run does not hold")):
            self.expect_refusal(f"{name}.h5: {text}", "render", f"{name}.h5", "-o", "out.png")
        self.assertFalse({"out.png", "out.xyz"} & set(os.listdir(self.folder)))
        write_two(self.path("in.h5"))
        write_two(self.path("other.h5"), names="glass,cnt")
        self.expect_refusal("--radius: 3 radii given", "render", "in.h5", "--radius", "1,2,3")
        self.expect_refusal("other.h5: of other kinds than in.h5", "render", "in.h5", "other.h5",
                            "--sheet", "-o", "out.png")


class Package(FolderTest):
    """States of two kinds, read, laid and written by the package itself."""

    def test_names_may_be_an_array(self):
        for names in "cnt,glass", ["cnt", "glass"], np.array([b"cnt", b"glass"]):
            state = states.read(write_two(self.path("in.h5"), names))
            self.assertEqual(state.kinds.names, ("cnt", "glass"))
            self.assertEqual(state.kinds.radii, (THIN, THICK))
            np.testing.assert_array_equal(state.radius(), np.repeat([THIN, THICK], [101, 11]))

    def distances(self, state):
        """The smallest distance between segments of different fibres, by the kinds of the two."""
        x, fibre, kind = state["position"], state["fibre"], state["kind"]
        least = np.full((2, 2), np.inf)
        for i in range(len(x)):
            other = fibre != fibre[i]
            apart = x - x[i]
            # A thick segment is a piece of a straight line along x.
            apart[:, 0] = np.where(kind + kind[i] > 0, 0, apart[:, 0])
            far = np.linalg.norm(apart, axis=1)
            for k in 0, 1:
                least[kind[i], k] = min(least[kind[i], k],
                                        far[other & (kind == k)].min(initial=np.inf))
        return least

    def test_a_composite_has_no_overlap_and_bonds_without_strain(self):
        state = generators.composite(generators.Plies(warp=3, weft=10, segments=4, gap=5.0))
        self.assertEqual(state.kinds.names, ("cnt", "glass"))
        np.testing.assert_array_equal(np.bincount(state["kind"][state["index"] == 0]), [20, 6])
        radii = np.array([THIN, THICK])
        self.assertGreater((self.distances(state) - radii[:, None] - radii).min(), 5.0 - 1e-6)
        for fibre in range(26):
            own = state["fibre"] == fibre
            bonds = np.linalg.norm(np.diff(state["position"][own], axis=0), axis=1)
            np.testing.assert_allclose(bonds, (13.56, 136)[state["kind"][own][0]], rtol=1e-9)
            # Over one, under the next.
            if state["kind"][own][0] == 0:
                self.assertGreater(np.ptp(state["position"][own, 2]), 2 * THICK)
        lower, upper = state["position"].min(axis=0), state["position"].max(axis=0)
        self.assertTrue((state.lower < lower - THICK).all() and (state.upper > upper + THICK).all())

    def test_strands_lie_between_thick_fibres_without_overlap(self):
        state = generators.composite(generators.Plies(warp=2, weft=6, segments=4, strand=7))
        # One strand under, between and over the two plies.
        np.testing.assert_array_equal(np.bincount(state["kind"][state["index"] == 0]), [12 + 21, 4])
        radii = np.array([THIN, THICK])
        least = (self.distances(state) - radii[:, None] - radii).min()
        self.assertGreater(least, generators.GAP - 1e-6)

    def test_a_state_at_rest_turns_from_each_segment_to_the_next(self):
        x = np.cumsum([(np.cos(0.1 * k), 0, np.sin(0.1 * k)) for k in range(9)], axis=0)
        q = rotations.along(x)
        state = states.at_rest(states.of_fibres([(x, q), (x + 50, q)], [-99] * 3, [99] * 3))
        rest = state["rest_rotation"].reshape(2, 9, 3)
        np.testing.assert_allclose(np.linalg.norm(rest[:, 1:7], axis=2), 0.1, rtol=1e-9)
        np.testing.assert_array_equal(rest[:, 8], 0)

    def test_a_composite_follows_from_its_seed(self):
        first, again, other = (generators.composite(generators.Plies(seed=seed))
                               for seed in (1, 1, 2))
        np.testing.assert_array_equal(first["position"], again["position"])
        self.assertGreater(np.abs(first["position"] - other["position"]).max(), 1)

    def test_a_bench_has_the_segments_asked_for_at_rest(self):
        for thin, thick in (50_000, 200), (1_234, 30):
            state = generators.mixed_bench(thin, thick)
            self.assertEqual(np.bincount(state["kind"]).tolist(), [thin, thick])
        least = self.distances(state)
        self.assertAlmostEqual(least[0, 1], THIN + THICK + generators.GAP, delta=1e-6)
        self.assertGreater(least[0, 0], generators.TOUCHING - 1e-6)
        self.assertGreater(least[1, 1], 2 * THICK)

    def test_written_and_read_again(self):
        state = generators.composite()
        states.write(self.path("in.h5"), state)
        again = states.read(self.path("in.h5"))
        self.assertEqual(again.kinds, state.kinds)
        self.assertEqual(again["kind"].dtype, np.int32)
        np.testing.assert_array_equal(again["kind"], state["kind"])
        self.assertTrue(np.isnan(again.radius()).all())
        np.testing.assert_array_equal(again.radius((1, 2)), state["kind"] + 1)


if __name__ == "__main__":
    scripts = sys.argv[1]
    sys.path.insert(0, scripts)
    from nanoweft import generators, rotations, states  # noqa: E402
    unittest.main(argv=sys.argv[:1])
