"""Tests of scripts/report: python3 report.py NANOWEFT SCRIPTS

The page is opened in Chromium where that is installed (Debian: chromium);
without it those tests are skipped."""
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import h5py
import numpy as np
from PIL import Image
from support import FolderTest, write_state

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
FLAGS = ("--headless --no-sandbox --disable-gpu --use-angle=swiftshader --enable-unsafe-swiftshader"
         " --disable-quic --no-first-run --disable-background-networking --disable-component-update"
         " --disable-sync --hide-scrollbars --virtual-time-budget=4000"
         " --window-size=1200,900").split()
VIEW = (slice(240, 640),
        slice(60, 740))  # rows and columns of the 3-D view without what is written on it
RUN = ("-weave_fibres 4,4 -weave_segments 24 -damping_local 0.4 -tension_rate 2e-5"
       " -tension_ramp 2000 -tension_grip 40 -tension_max_strain 0.45 -break_strain_mean 0.12"
       " -break_strain_std 0.03 -ts_dt 15 -snapshot_interval 250 -monitor_interval 20"
       " -energy_monitor ascii:energy.csv"
       " -stress_monitor ascii:stress.csv")


def straight(y, count=20):
    place = np.zeros((count, 3))
    place[:, 0], place[:, 1] = 13.56 * np.arange(count), y
    return place


class Report(FolderTest):
    def report(self, *arguments):
        return self.run_program(os.path.join(scripts, "report"), *arguments)

    def make(self, *arguments):
        """The page of this test's folder."""
        done = self.report(self.folder, *arguments)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        name = done.stdout.strip()
        self.assertLess(os.path.getsize(name), 30e6)
        with open(name, encoding="utf-8") as file:
            return name, file.read()

    def data(self, page):
        found = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.S)
        return json.loads(found[1])

    def open(self, name, fragment):
        """What the browser has of the page: attributes of <html>, and the picture."""
        if not CHROMIUM:
            self.skipTest("no chromium")
        shot = self.path("shot.png")
        with tempfile.TemporaryDirectory(prefix="nanoweft-chromium-") as profile:
            done = subprocess.run(
                [CHROMIUM, *FLAGS, f"--user-data-dir={profile}", "--dump-dom",
                 f"--screenshot={shot}", f"file://{name}#{fragment}"],
                capture_output=True, text=True, cwd=self.folder)
        html = re.search(r"<html[^>]*>", done.stdout)
        self.assertIsNotNone(html, done.stderr[-2000:])
        self.assertNotIn("data-error", html[0])
        self.assertIn('data-ready="yes"', html[0])
        with Image.open(shot) as picture:
            return (dict(re.findall(r'data-(\w+)="([^"]*)"', html[0])), done.stdout,
                    np.asarray(picture.convert("RGB")).astype(int))

    def test_fibres_are_seen_and_the_slider_moves_them(self):
        self.simulate(nanoweft, RUN)
        name, page = self.make()
        series, = self.data(page)["series"]
        self.assertEqual((series["name"], series["total"], len(series["runs"])), ("frame", 192, 8))
        self.assertGreater(len(series["frames"][-1]["torn"]), 0)
        self.assertEqual(series["frames"][0]["torn"], [])
        self.assertEqual({field["name"] for field in series["fields"]},
                         {"strain", "stretch_energy", "shear_energy", "bending_energy",
                          "torsion_energy", "pair_energy", "velocity"})
        self.assertEqual(series["curve"]["titles"][:3],
                         ["stress over strain", "strain, %", "stress, GPa"])
        last = len(series["frames"]) - 1
        first_facts, first_dom, first = self.open(name, "frame=0&theme=light")
        last_facts, last_dom, second = self.open(name, f"frame={last}&theme=light")
        self.assertEqual((first_facts["frame"], last_facts["frame"]), ("0", str(last)))
        # Broken bonds leave gaps.
        torn = len(series["frames"][-1]["torn"])
        self.assertEqual((first_facts["tubes"], last_facts["tubes"]),
                         (str(8 * 23), str(8 * 23 - torn)))
        for picture in first, second:
            # The ground is nearly grey; the fibres are not.
            self.assertGreater((np.ptp(picture[VIEW], axis=2) > 40).sum(), 3000)
        self.assertGreater((np.abs(first - second)[VIEW].max(axis=2) > 40).sum(), 3000)
        marks = [float(re.search(r'id="mark"[^>]*cx="([\d.]+)"', dom)[1])
                 for dom in (first_dom, last_dom)]
        self.assertGreater(marks[1], marks[0] + 100)

    def test_colours_and_dark(self):
        self.simulate(nanoweft, RUN)
        name, _ = self.make()
        _, dom, dark = self.open(name, "frame=30&theme=dark&colour=broken")
        self.assertIn("broken fibres", dom)
        self.assertLess(np.median(dark), 60)
        red = (dark[..., 0] > dark[..., 1] + 80) & (dark[..., 0] > dark[..., 2] + 80)
        self.assertGreater(red[VIEW].sum(), 30)
        _, dom, _ = self.open(name, "frame=5&colour=strain")
        self.assertIn("strain of the bonds, %", dom)

    def test_nothing_is_loaded_from_elsewhere(self):
        write_state(self.path("final.h5"), [straight(0), straight(100)])
        _, page = self.make()
        own = re.sub(r"<script>/\* three.*?</script>", "", page, flags=re.S)
        for tag in re.findall(r"<(?:script|link|img|iframe|source)\b[^>]*>", own):
            self.assertNotRegex(tag, r"(?:src|href)=\"(?!data:)")
        self.assertNotRegex(own, r"@import|url\((?!#)")

    def test_a_folder_of_pictures_and_tables_alone(self):
        Image.new("RGB", (40, 30), "#123456").save(self.path("seen.png"))
        with open(self.path("stress.csv"), "w") as file:
            file.write("# nanoweft 1.0\n# -pair none\n# -seed 3\n"
                       "step,time_fs,strain,stress_left_GPa,stress_right_GPa,broken_bonds\n")
            file.writelines(f"{k},{20 * k},{0.01 * k},{k},{k},0\n" for k in range(20))
        name, page = self.make()
        self.assertIn("data:image/png;base64", page)
        for text in "Stress over strain", "nanoweft 1.0", "-pair", "-seed":
            self.assertIn(text, page)
        facts, _, _ = self.open(name, "")
        self.assertEqual(facts["ready"], "yes")

    def test_large_scenes_are_thinned_and_it_is_said(self):
        fibres = [straight(20.0 * k, 300) for k in range(60)]
        for step in range(30):
            write_state(self.path(f"s_{step:010}.h5"), fibres, step=step, time=1000.0 * step,
                        field={"strain": np.linspace(-1, 1, 18000)})
        _, page = self.make("--largest", "2.2")
        self.assertLess(len(page), 2.2e6)
        series, = self.data(page)["series"]
        self.assertLess(series["count"], 18000)
        self.assertGreaterEqual(len(series["frames"]), 2)
        self.assertEqual(sum(series["runs"]), series["count"])
        self.assertEqual(series["frames"][-1]["step"], 29)
        self.assertIn("every", series["note"])
        self.assertIn(series["note"], page)

    def test_units_stand_beside_the_numbers(self):
        for units, energy, speed in (("nano", "eV", "Å/fs"), ("si", "J", "m/s")):
            columns = [np.array([0.0, 1.0])]
            self.assertEqual(scene.describe("pair_energy", columns, units)["title"],
                             f"pair energy, {energy}")
            self.assertEqual(scene.describe("velocity", columns, units)["title"], f"speed, {speed}")

    def test_the_strength_stays_in_a_table_that_is_thinned(self):
        stress = np.random.default_rng(1).normal(5, 1, 20000)
        columns = {"stress_left_GPa": stress, "stress_right_GPa": stress}
        thin = page.thinned(tables.Table("stress.csv", columns, []))
        self.assertLess(len(thin), 3002)
        self.assertEqual(thin["stress_left_GPa"].max(), stress.max())

    def test_radius(self):
        write_state(self.path("final.h5"), [straight(0)])
        self.assertEqual(self.data(self.make()[1])["series"][0]["radii"], [6.78])
        self.assertEqual(self.data(self.make("--radius", "3")[1])["series"][0]["radii"], [3])

    def test_nothing_but_an_earlier_page_is_replaced(self):
        write_state(self.path("final.h5"), [straight(0)])
        table = self.path("mine.csv")
        with open(table, "w") as file:
            file.write("kept\n")
        done = self.report(self.folder, "-o", table)
        self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1))
        self.assertIn("no page", done.stderr)
        with open(table) as file:
            self.assertEqual(file.read(), "kept\n")
        self.make("-o", self.path("page.html"))
        self.make("-o", self.path("page.html"))

    def test_broken_bonds_of_thinned_pages_are_all_counted(self):
        first = [straight(20.0 * k, 300) for k in range(60)]
        broken = np.zeros(18000, int)
        broken[[3, 4, 5, 6]] = 1
        for step in range(30):
            name = self.path(f"s_{step:010}.h5")
            write_state(name, first, step=step, time=1000.0 * step, bond_broken=broken)
        frame = self.data(self.make("--largest", "2.2")[1])["series"][0]["frames"][-1]
        self.assertEqual(frame["broken"], 4)
        self.assertLess(len(frame["torn"]), 4)

    def test_broken_links_are_broken_bonds(self):
        fibres = [straight(20.0 * k) for k in range(3)]
        for step, bonds, links in (0, [], []), (10, [3, 25], [0]), (20, [3, 25], [0, 2, 3]):
            name = self.path(f"s_{step:010}.h5")
            write_state(name, fibres, step=step, time=1.0 * step,
                        bond_broken=np.isin(np.arange(60), bonds).astype(np.int8))
            with h5py.File(name, "r+") as file:
                file["link/segments"] = [[[0, k], [1, k]] for k in range(4)]
                file["link/broken"] = np.isin(np.arange(4), links).astype(np.int8)
        series, = self.data(self.make()[1])["series"]
        self.assertEqual([frame["broken"] for frame in series["frames"]], [0, 3, 5])

    def test_numbered_checkpoints_are_no_series(self):
        for step in 10, 20:
            write_state(self.path(f"s_{step:010}.h5"), [straight(0)], step=step, time=1.0 * step)
        write_state(self.path("checkpoint_0000000020.h5"), [straight(0)], step=20, time=20.0)
        self.assertEqual([one["name"] for one in self.data(self.make()[1])["series"]], ["s"])

    def test_the_box_is_that_of_each_snapshot(self):
        for step, wide, tilt in (0, 300.0, 0.0), (10, 400.0, 120.0):
            name = self.path(f"s_{step:010}.h5")
            write_state(name, [straight(0)], step=step, time=1.0 * step,
                        box=([-10.0, -50.0, -5.0], [wide - 10, 50.0, 5.0]))
            with h5py.File(name, "r+") as file:
                file["state"].attrs["tilt"] = [tilt, 0, 0]
        name, page = self.make()
        series, = self.data(page)["series"]
        self.assertEqual(series["periodic"], [1, 0, 0])
        # The lower corner and the ways along the three edges.
        self.assertEqual([frame["box"] for frame in series["frames"]],
                         [[[-10, -50, -5], [wide, 0, 0], [tilt, 100, 0], [0, 0, 10]]
                          for wide, tilt in ((300, 0), (400, 120))])
        self.assertEqual(self.open(name, "frame=1")[0]["frame"], "1")

    def test_what_another_run_left_in_a_series_is_no_part_of_it(self):
        """-overwrite replaces snapshots of the same steps alone; a restart goes on with others'."""
        base = (" -weave_fibres 2,2 -weave_segments 12 -snapshot_interval 10 -checkpoint_file c.h5"
                " -damping_local 0.%d -ts_dt 10 -ts_max_steps %d")
        self.simulate(nanoweft, base % (3, 60))
        files = self.simulate(nanoweft, base % (1, 30) + " -overwrite")
        self.assertEqual(len(files), 7)
        index = self.path("frame.xdmf")
        for copied in False, True:
            if copied:  # all dates lost but not the index
                for file in reversed(files):
                    os.utime(file, (1e9, 1e9))
            else:
                os.rename(index, index + "_")
            series, = self.data(self.make()[1])["series"]
            self.assertEqual([frame["step"] for frame in series["frames"]], [0, 10, 20, 30])
            self.assertIn("frame_0000000040.h5 to frame_0000000060.h5: 3 snapshots of another run",
                          self.make()[1])
            if not copied:
                os.rename(index + "_", index)
        for script, *arguments in (("analyse", "--what", "crimp"), ("bundles",), ("breaks",),
                                   ("shares",), ("render", "-o", self.path("m.gif")),
                                   ("export", "-o", self.path("m.xyz"))):
            done = self.run_program(os.path.join(scripts, script), *files, *arguments)
            self.assertIn(f"{script}: warning: {files[4]} to frame_0000000060.h5: 3 snapshots of"
                          " another run than those beside them", done.stderr)
        self.simulate(nanoweft, base % (1, 60) + " -overwrite -restart c.h5 -ts_dt 5")
        series, = self.data(self.make()[1])["series"]
        self.assertEqual(len(series["frames"]), 7)
        self.assertNotIn("another run", self.make()[1])

    def test_times_of_curves_are_those_of_the_table(self):
        time = np.array([0.0, 1234567.8])
        given = scene.points(time, time, time, None, ("", "", "", ""))
        self.assertEqual(given["time"], time.tolist())

    def test_files_that_cannot_be_read_are_named(self):
        write_state(self.path("final.h5"), [straight(0)])
        with open(self.path("broken.h5"), "w") as file:
            file.write("no HDF5")
        self.assertIn("broken.h5: damaged", self.make()[1])

    def test_refusals(self):
        for text, *arguments in (("no such folder", self.path("none")),
                                 ("no state, table or picture", self.folder)):
            done = self.report(*arguments)
            self.assertNotEqual(done.returncode, 0)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
            self.assertIn(text, done.stderr)
        write_state(self.path("final.h5"), [straight(0)])
        done = self.report(self.folder, "-o", self.path("none/out.html"))
        self.assertIn("cannot write", done.stderr)


if __name__ == "__main__":
    nanoweft, scripts = sys.argv[1:3]
    sys.path.insert(0, scripts)
    from nanoweft import tables  # noqa: E402
    from nanoweft.report import page, scene  # noqa: E402
    done = unittest.main(argv=sys.argv[:1], exit=False).result
    # CTest takes 77 for a test that was skipped.
    sys.exit(1 if not done.wasSuccessful() else 0 if CHROMIUM else 77)
