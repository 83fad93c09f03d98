"""Tests of scripts/render: python3 render.py NANOWEFT SCRIPTS"""
import os
import runpy
import stat
import sys
import types
import unittest

import h5py
import numpy as np
from PIL import Image
from support import FolderTest, write_state

RADIUS, SPACING = 6.78, 13.56


def straight(start, direction, count):
    return np.array(start, float) + SPACING * np.arange(count)[:, None] * np.array(direction, float)


def pixels(name):
    return np.asarray(Image.open(name).convert("RGB")).astype(int)


def coloured(picture):
    """Pixels that are no grey, as are paper, shadows and writing."""
    return np.ptp(picture, axis=2) > 25


def reddish(picture):
    return (picture[..., 0] > picture[..., 2] + 60) & (picture[..., 0] > picture[..., 1] + 60)


def bluish(picture):
    return picture[..., 2] > picture[..., 0] + 40


class Render(FolderTest):
    def render(self, *arguments):
        return self.run_program(os.path.join(scripts, "render"), *arguments)

    def draw(self, *arguments, output="out.png"):
        done = self.render(*arguments, "-o", output)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return pixels(self.path(output)) if output.endswith("png") else self.path(output)

    def expect_refusal(self, text, *arguments):
        before = sorted(os.listdir(self.folder))
        done = self.render(*arguments)
        self.assertNotEqual(done.returncode, 0)
        self.assertNotIn("Traceback", done.stderr)
        self.assertIn(text, done.stderr.splitlines()[-1])
        if "usage" not in done.stderr:
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        self.assertEqual(sorted(os.listdir(self.folder)), before)

    def test_a_view_past_everything_is_said(self):
        write_state(self.path("in.h5"), [straight((0, 0, 0), (1, 0, 0), 20)])
        done = self.render("in.h5", "--zoom", "8", "--center", "0,200")
        self.assertEqual((done.returncode, done.stdout), (0, "in.png\n"))
        self.assertEqual(done.stderr, "render: warning: in.h5: nothing of it is in view; "
                                      "it reaches from 0,0,0 to 257.6,0,0\n")
        # A segment's edge is enough.
        self.draw("in.h5", "--zoom", "8", "--center", "0,5", "--size", "600x300")

    def test_tubes_are_as_thick_and_long_as_they_should(self):
        write_state(self.path("in.h5"), [straight((0, 0, 0), (1, 0, 0), 20)])
        # All of it fills 96 % of the width.
        pixel = (19 * SPACING + 2 * RADIUS) / (0.96 * 600)
        for zoom in 1, 3:
            picture = coloured(self.draw("in.h5", "--size", "600x300", "--zoom", str(zoom)))
            self.assertEqual(picture.shape, (300, 600))
            self.assertAlmostEqual(picture[:, 300].sum(), zoom * 2 * RADIUS / pixel, delta=2)
            self.assertAlmostEqual(picture.any(axis=0).sum(), min(600, 0.96 * 600 * zoom), delta=3)
        # With the first segment in the middle the left half is empty but for the round end.
        picture = coloured(self.draw("in.h5", "--size", "600x300", "--center", "0,0"))
        self.assertAlmostEqual(np.argmax(picture.any(axis=0)), 300 - RADIUS / pixel, delta=3)
        picture = coloured(self.draw("in.h5", "--size", "600x300", "--radius", str(2 * RADIUS)))
        wider = (19 * SPACING + 4 * RADIUS) / (0.96 * 600)
        self.assertAlmostEqual(picture[:, 300].sum(), 4 * RADIUS / wider, delta=2)

    def test_what_lies_above_hides_what_lies_below(self):
        low = straight((0, 67.8, 0), (1, 0, 0), 11)
        high = straight((67.8, 0, 20), (0, 1, 0), 11)
        write_state(self.path("in.h5"), [low, high], group=np.repeat([1, 2], 11))  # vermilion, blue
        for size, zoom in ((400, 1), (200, 1), (400, 0.1)):
            options = ["--color", "group", "--size", f"{size}x{size}", "--zoom", str(zoom),
                       "--labels", "x"]
            above = self.draw("in.h5", *options)
            below = self.draw("in.h5", *options, "--view=-90,-90")
            for picture, upper in ((above, bluish), (below, reddish)):
                area = coloured(picture)
                area[:, -95:] = False  # the legend
                rows, columns = np.nonzero(area)
                centre = picture[rows.min() // 2 + rows.max() // 2,
                                 columns.min() // 2 + columns.max() // 2]
                self.assertTrue(upper(centre), (size, zoom, centre))

    def test_colours_follow_any_dataset(self):
        fibres = [straight((0, 60 * k, 0), (1, 0, 0), 10) for k in range(2)]
        load = np.repeat([[0.0, 0.0, 0.0], [3.0, 0.0, -4.0]], 10, axis=0)
        write_state(self.path("in.h5"), fibres, velocity=load,
                    field={"load": np.linalg.norm(load, axis=1),
                           "signed": np.repeat([-2.0, 1.0], 10),
                           "hole": np.repeat([np.nan, 1.0], 10), "short": np.zeros(3),
                           "tensor": np.zeros((20, 3, 3)), "nothing": np.full(20, np.nan)})

        def fibre_colours(*options):
            picture = self.draw("in.h5", "--size", "400x240", *options)[:, :280]
            rows = np.flatnonzero(coloured(picture)[:, 140])
            split = rows[np.argmax(np.diff(rows)) + 1]
            return (picture[rows[rows >= split], 140].mean(axis=0),
                    picture[rows[rows < split], 140].mean(axis=0))

        first, second = fibre_colours("--color", "load")
        self.assertGreater(first[2], first[1])   # viridis: from violet to yellow
        self.assertGreater(second[1], second[2] + 60)
        np.testing.assert_array_equal(fibre_colours("--color", "velocity"), [first, second])
        first, _ = fibre_colours("--color", "load", "--range=-100,5")
        self.assertGreater(first[0], first[2])   # 0 is near the upper end
        first, second = fibre_colours("--color", "signed")
        self.assertGreater(first[2], first[0] + 60)  # even about zero: -2 is blue, 1 a pale red
        self.assertGreater(second[0], second[2] + 20)
        self.draw("in.h5", "--color", "hole")
        for color, text in (("short", "short holds no number or vector for each segment"),
                            ("tensor", "tensor holds no number"), ("nothing", "no finite number"),
                            ("nowhere", "no dataset nowhere"), ("fibre/x", "no dataset")):
            self.expect_refusal(text, "in.h5", "-o", "none.png", "--color", color)

    def test_every_kind_has_its_own_length_without_strain(self):
        write_state(self.path("in.h5"), [straight((0, 0, 0), (1, 0, 0), 12),
                                         40 / 13.56 * straight((0, 20, 0), (1, 0, 0), 6)],
                    kind=np.repeat([0, 1], (12, 6)))
        for fibre in (None, [6.78, 13.56, 1, 1, 1, 1, 1, 1, 20, 40, 1, 1, 1, 1, 1, 1]):
            with h5py.File(self.path("in.h5"), "a") as file:
                file["state/kind"].attrs["kinds"] = "thin,thick"
                if fibre:
                    file.create_group("run").attrs["fibre"] = np.array(fibre, float)
            made = stage.Stage(stage.View("stretch"), [self.path("in.h5")])
            np.testing.assert_allclose(made.values(*stage.load(self.path("in.h5"), "stretch")), 0,
                                       atol=1e-9)
            stage.load.cache_clear()

    def test_a_group_has_one_colour_in_all_pictures_of_a_sheet(self):
        legends = []
        for name, masks in (("a.h5", [0, 2]), ("b.h5", [1, 2])):
            write_state(self.path(name), [straight((0, 0, 0), (1, 0, 0), 10)],
                        group=np.repeat(masks, 5))
        made = stage.Stage(stage.View("group"), [self.path("a.h5"), self.path("b.h5")])
        legends = [dict(made.colours_of(self.path(name)).legend) for name in ("a.h5", "b.h5")]
        self.assertEqual(set(legends[0]), {"no group", "group mask 2"})
        self.assertEqual(set(legends[1]), {"group mask 1", "group mask 2"})
        self.assertEqual(legends[0]["group mask 2"], legends[1]["group mask 2"])
        self.assertEqual(len({*legends[0].values(), *legends[1].values()}), 3)

    def test_broken_bonds(self):
        broken = np.zeros(2000, np.int8)
        broken[499] = broken[1200] = 1
        fibres = [straight((0, 300 * k, 0), (1, 0, 0), 1000) for k in range(2)]
        write_state(self.path("in.h5"), fibres, bond_broken=broken)
        write_state(self.path("whole.h5"), fibres)
        # Seen whole, a tube is thinner than a pixel; the marks are not.
        marked = reddish(self.draw("in.h5", "--size", "1000x300",
                                   "--color", "broken")[40:260, :800])
        columns = np.flatnonzero(marked.any(axis=0))
        self.assertEqual(np.count_nonzero(np.diff(columns) > 1), 1)  # two places
        self.assertGreaterEqual(len(columns), 8)
        self.assertGreaterEqual(marked.sum(axis=0).max(), 4)
        whole = reddish(self.draw("whole.h5", "--size", "1000x300",
                                  "--color", "broken")[40:260, :800])
        self.assertEqual(whole.sum(), 0)
        plain = self.draw("in.h5", "--size", "1000x300", "--color", "height")
        breaks = self.draw("in.h5", "--size", "1000x300", "--color", "height", "--breaks")
        self.assertGreater(reddish(breaks)[40:260, :800].sum(),
                           reddish(plain)[40:260, :800].sum() + 20)
        # Close up there is a gap, of nearly two bonds and without marks.
        middle = ["--size", "600x300", "--zoom", "50", "--center", f"{499.5 * SPACING},0"]
        pixel = (999 * SPACING + 2 * RADIUS) / (0.96 * 600) / 50
        row = coloured(self.draw("in.h5", *middle))[150 - 24:150 - 10].any(axis=0)
        self.assertTrue(row[:200].all() and row[400:].all())
        self.assertAlmostEqual((~row).sum(), (1.9 * SPACING - 2 * RADIUS) / pixel, delta=4)

    def test_nothing_is_drawn_through_the_box(self):
        x = straight((5, 0, 0), (1, 0, 0), 20)
        for whole, more in (False, {"image": np.zeros((20, 3), int)}), (True, {}):
            write_state(self.path("in.h5"), [np.append(x[10:], x[:10], axis=0)],
                        box=([0, -50, -50], [20 * SPACING, 50, 50]), **more)
            picture = coloured(self.draw("in.h5", "--size", "600x300", "--radius", "3"))
            # A bond right across would close the gap between the two pieces. Without images the
            # second goes on where the first ends.
            gap = ~picture[:, 280:320].any(axis=0)
            self.assertEqual(gap.any(), not whole)

    def three_frames(self):
        names = []
        for k in 2, 0, 1:
            names.append(f"frame{k}.h5")
            write_state(self.path(names[-1]), [straight((400 * k, 0, 0), (1, 0, 0), 10)],
                        time=1e5 * k, step=10 * k)
        return names

    def film(self, *arguments):
        film = Image.open(self.draw(*arguments, output="out.gif"))
        self.addCleanup(film.close)
        return film

    def test_links_are_drawn_once_and_by_the_nearest_image(self):
        def link_pixels(links, box=None, broken=None):
            fibres = [straight((5, y, 0), (1, 0, 0), 20) for y in (-80, 0, 80)]
            write_state(self.path("in.h5"), fibres, box=box)
            with h5py.File(self.path("in.h5"), "r+") as file:
                file["state"].attrs["periodic"] = [0, int(box is not None), 0]
                file["link/segments"] = links
                file["link/kind"] = np.arange(len(links), dtype=np.int32)
                file["link/kind"].attrs["kinds"] = "soft,stiff"
                if broken:
                    file["link/broken"] = np.array(broken, np.int8)
            picture = self.draw("in.h5", "--size", "300x250")[:, :220]  # without the legend
            return ((picture[..., 0] > picture[..., 1] + 90)
                    & (picture[..., 2] > picture[..., 1] + 60))

        inside, across = [[0, 4], [1, 4]], [[0, 14], [2, 14]]
        one = link_pixels([inside])
        columns = np.flatnonzero(one.any(axis=0))
        self.assertLess(columns[-1] - columns[0], 8)
        self.assertGreater(one.any(axis=1).sum(), 50)  # from axis to axis
        # A broken link is gone.
        np.testing.assert_array_equal(link_pixels([inside, across], broken=[0, 1]), one)
        # Through the boundary a link leaves the piece at both sides, and does not cross the middle.
        both = link_pixels([across], box=([0, -100, -50], [400, 100, 50]))
        rows = np.flatnonzero(both.any(axis=1))
        self.assertFalse(both[110:140].any())
        self.assertTrue(rows[0] < 110 and rows[-1] > 140)
        self.assertGreater(link_pixels([across]).any(axis=1).sum(), 100)

    def test_labels_count_broken_links(self):
        broken = np.zeros(60, np.int8)
        broken[[3, 25]] = 1
        write_state(self.path("in.h5"), [straight((5, y, 0), (1, 0, 0), 20) for y in (-80, 0, 80)],
                    bond_broken=broken)
        with h5py.File(self.path("in.h5"), "r+") as file:
            file["link/segments"] = [[[0, 4], [1, 4]], [[0, 14], [2, 14]], [[1, 9], [2, 9]]]
            file["link/broken"] = np.array([1, 0, 1], np.int8)
        script = runpy.run_path(os.path.join(scripts, "render"))
        marked = types.SimpleNamespace(how="fibre", marked=True)
        self.assertEqual(script["label"](marked, self.path("in.h5"), "x"), "x, 4 broken bonds")

    def test_walls_are_drawn_as_balls_and_rods(self):
        write_state(self.path("in.h5"), [straight((0, 0, 0), (1, 0, 0), 40)])
        ball = self.draw("in.h5", "--size", "600x300", "--solid", "260,0,0,80")
        rod = self.draw("in.h5", "--size", "600x300", "--solid", "100,0,-62,420,0,-62,60")
        scale = 0.96 * 600 / (39 * SPACING + 2 * RADIUS)
        for picture, wide, high in ((ball, 160, 160), (rod, 440, 120)):
            # Warm as they are, where paper and shadows are grey; the fibre is left out.
            solid = (picture[..., 0] > picture[..., 2] + 4) & ~coloured(picture)
            solid[130:170] = False
            for axis, extent in (0, wide), (1, high):
                found = np.flatnonzero(solid.any(axis=axis))
                self.assertAlmostEqual(found[-1] - found[0], extent * scale,
                                       delta=0.06 * extent * scale)
        # The ball hides the fibre, which lies upon the rod.
        self.assertFalse(coloured(ball)[140:160, 260:340].any())
        self.assertTrue(coloured(rod)[140:160, 260:340].any())
        for wrong in ("1,2,3", "0,0,0,-5", "a,b,c,d"):
            self.expect_refusal("--solid", "in.h5", "--solid", wrong, "-o", "none.png")

    def test_links_that_end_nowhere_are_refused(self):
        write_state(self.path("in.h5"), [straight((0, 0, 0), (1, 0, 0), 5)])
        with h5py.File(self.path("in.h5"), "r+") as file:
            file["link/segments"] = [[[0, 1], [7, 2]]]
        self.expect_refusal("fibre 7, segment 2", "in.h5", "-o", "none.png")

    def test_movie(self):
        film = self.film(*self.three_frames(), "--size", "500x200", "--dark")
        self.assertEqual((film.n_frames, film.size), (3, (500, 200)))
        middles, labels = [], []
        for frame in range(3):
            film.seek(frame)
            picture = np.asarray(film.convert("RGB")).astype(int)
            self.assertLess(picture[-1, -1].max(), 40)
            middles.append(np.flatnonzero(coloured(picture[30:170]).any(axis=0)).mean())
            labels.append(picture[:18].tobytes())
        # Sorted by step, and the camera stands still: equal moves of 400 A.
        np.testing.assert_allclose(np.diff(middles),
                                   400 * 0.96 * 500 / (800 + 9 * SPACING + 2 * RADIUS), atol=2)
        self.assertEqual(len(set(labels)), 3)

    def test_movie_through_ffmpeg(self):
        fake = self.path("ffmpeg")
        with open(fake, "w") as file:
            file.write('#!/bin/sh\nfor last; do :; done\ncat > "$last"\n')
        os.chmod(fake, os.stat(fake).st_mode | stat.S_IXUSR)
        path, os.environ["PATH"] = os.environ["PATH"], self.folder + ":" + os.environ["PATH"]
        try:
            raw = self.draw(*self.three_frames(), "--size", "301x201", output="out.mp4")
            self.assertEqual(os.path.getsize(raw), 3 * 300 * 200 * 3)
            with open(fake, "w") as file:
                file.write("#!/bin/sh\necho no such codec >&2\nexit 1\n")
            self.expect_refusal("no such codec", "frame0.h5", "-o", "bad.mp4")
            os.environ["PATH"] = "/nowhere"
            self.expect_refusal("no ffmpeg", "frame0.h5", "-o", "bad.mp4")
        finally:
            os.environ["PATH"] = path

    def test_sheet(self):
        names = self.three_frames()
        options = ["--sheet", "--columns", "3", "--size", "900x160", "--labels", "III", "I", "II"]
        picture = self.draw(*names, *options)
        self.assertEqual(picture.shape[:2], (160, 900))
        label, panels = picture[:24], coloured(picture[26:130])
        for k, at in enumerate((2, 0, 1)):  # in the order given; all at one scale
            columns = np.flatnonzero(panels[:, 300 * k + 6:300 * k + 294].any(axis=0))
            extent = 800 + 9 * SPACING + 2 * RADIUS
            # Panels are (900 - 2 x 6) / 3 wide.
            start = 302 * k + 0.02 * 296 + 400 * at * 0.96 * 296 / extent - 300 * k - 6
            self.assertAlmostEqual(columns[0], max(start, 0), delta=3)
        ink = [(label[:, 300 * k + 2:300 * k + 200].min(axis=2) < 128).sum() for k in range(3)]
        self.assertGreater(ink[0], ink[2])
        self.assertGreater(ink[2], ink[1])
        self.assertGreater(ink[1], 0)

    def test_scale_bar(self):
        # 19 bonds and two radii, 271.2 A, are 576 pixels: the bar of 5 nm is 106 pixels long.
        write_state(self.path("in.h5"), [straight((0, 0, 0), (1, 0, 0), 20)])
        picture = self.draw("in.h5", "--size", "600x300")
        row = picture[300 - 10].max(axis=1) < 128
        run = np.flatnonzero(~row[np.argmax(row):])[0]
        self.assertAlmostEqual(run, 50 / (271.2 / 576), delta=2)

    def test_a_weave_of_the_program(self):
        frames = self.simulate(nanoweft, "-weave_fibres 4,4 -weave_segments 24 -damping_local 0.4"
                               " -ts_max_steps 20 -snapshot_interval 10")
        for options in (["--view", "iso"], ["--color", "stretch", "--length", "13.56"],
                        ["--color", "height"],
                        ["--color", "velocity", "--view=-30,20"], ["--color", "group", "--dark"],
                        ["--color", "broken", "--view", "side"]):
            picture = self.draw(frames[-1], "--size", "300x200", *options)
            self.assertGreater(np.ptp(picture), 100)
        self.assertEqual(self.film(*frames, "--size", "200x150").n_frames, 3)

    def test_refusals(self):
        fibre = [straight((0, 0, 0), (1, 0, 0), 500)]
        write_state(self.path("in.h5"), fibre)
        write_state(self.path("empty.h5"), [])
        write_state(self.path("nan.h5"), [np.full((3, 3), np.nan)])
        write_state(self.path("short.h5"), fibre, group=np.zeros(2, np.int32))
        with h5py.File(self.path("foreign.h5"), "w") as file:
            file["state/position"] = np.zeros((3, 3))
        with open(self.path("text.h5"), "w") as file:
            file.write("not HDF5")
        with open(self.path("in.h5"), "rb") as file, open(self.path("cut.h5"), "wb") as cut:
            content = file.read()
            cut.write(content[:len(content) // 2])
        self.expect_refusal("no such file", "none.h5")
        for name in "foreign.h5", "text.h5", "cut.h5", ".":
            self.expect_refusal("not a nanoweft state file", name, "-o", "out.png")
        self.expect_refusal("holds no segments", "empty.h5")
        self.expect_refusal("not finite", "nan.h5")
        self.expect_refusal("group does not match", "short.h5")
        self.expect_refusal("several files", "in.h5", "in.h5", "-o", "out.png")
        self.expect_refusal("2 labels", "in.h5", "--labels", "a", "b")
        self.expect_refusal("--range needs colours on a scale", "in.h5", "--range", "0,1")
        self.expect_refusal("LO is not below HI", "in.h5", "--color", "height", "--range", "1,0")
        self.expect_refusal("not X,Y", "in.h5", "--center", "1")
        self.expect_refusal("cannot write", "in.h5", "-o", "none/out.png", "--size", "100x100")
        self.expect_refusal("cannot write", "in.h5", "-o", "out.xyz", "--size", "100x100")
        self.expect_refusal("no room", *["in.h5"] * 9, "--sheet", "--size", "100x100", "-o",
                            "out.png")
        self.expect_refusal("--sheet makes a picture", "in.h5", "--sheet", "-o", "out.gif")


if __name__ == "__main__":
    nanoweft, scripts = sys.argv[1:3]
    sys.path.insert(0, scripts)
    from nanoweft.pictures import stage  # noqa: E402
    unittest.main(argv=sys.argv[:1])
