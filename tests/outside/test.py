"""An installed nanoweft serves other projects and users: python3 test.py BUILD MPIEXEC MAN

Installs BUILD into a folder, builds the CMake project beside this file against it, and compares
what it prints with a run of the installed program."""
import csv
import json
import os
import pathlib
import subprocess
import sys
import unittest

import h5py

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "scripts"))
from support import FolderTest  # noqa: E402

PROJECT = pathlib.Path(__file__).resolve().parent
FLOOR = ("-scene fibre -fibre_segments 8 -pair none -walls floor -floor_point 0,0,-6.5 -floor_axis"
         " 0,0,1 -floor_modulus 20 -ts_max_steps 10 -progress_interval 0")
SCENE = ("-scene weave -weave_fibres 4,4 -weave_segments 20 -damping_local 0.4"
         " -ts_max_steps 50 -progress_interval 0")


class Installed(FolderTest):
    def call(self, *words, status=0):
        done = self.execute(*map(str, words))
        self.assertEqual(done.returncode, status, f"{words}\n{done.stdout}{done.stderr}")
        return done.stdout

    def setUp(self):
        super().setUp()
        self.prefix = pathlib.Path(self.path("prefix"))
        self.call("cmake", "--install", BUILD, "--prefix", self.prefix)

    def build_outside(self):
        """The executable, compiled with no flag that nanoweft alone needs."""
        self.call("cmake", "-S", PROJECT, "-B", "outside", f"-DCMAKE_PREFIX_PATH={self.prefix}",
                  "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON")
        with open(self.path("outside/compile_commands.json")) as file:
            command = json.load(file)[0]["command"]
        for flag in ("-march", "-Wall", "-ffp-contract", "petsc", "hdf5"):
            self.assertNotIn(flag, command)
        self.call("cmake", "--build", "outside")
        return self.path("outside/outside")

    def test_another_project_runs_the_same_scene_as_the_program(self):
        outside = self.build_outside()
        printed = self.call(MPIEXEC, "-n", "2", outside) + self.call(outside, "alone")
        results = [line.split()[1:] for line in printed.splitlines() if line.startswith("result")]
        self.assertEqual(len(results), 3)
        self.call(self.prefix / "bin/nanoweft", *SCENE.split(),
                  "-energy_monitor", "ascii:energy.csv", "-state_output", "final.h5")
        for done, step, segments, _, elastic in results:
            self.assertEqual((done, step, segments, elastic), ("1", "50", "160", results[0][4]))
        with open(self.path("energy.csv")) as file:
            last = list(csv.DictReader(line for line in file if not line.startswith("#")))[-1]
        expected = sum(float(last[name]) for name in ("stretch", "shear", "bending", "torsion"))
        self.assertGreater(expected, 0)
        self.assertAlmostEqual(float(results[0][4]) / expected, 1, delta=1e-9)
        with h5py.File(self.path("final.h5")) as file:
            expected = file["state/position"][:, 2].sum()
        for *_, heights, _ in results:
            self.assertAlmostEqual(float(heights), expected, delta=1e-6)
        self.call(self.prefix / "bin/nanoweft", *FLOOR.split(), "-energy_monitor",
                  "ascii:floor.csv")
        with open(self.path("floor.csv")) as file:
            last = list(csv.DictReader(line for line in file if not line.startswith("#")))[-1]
        total, walls = next(line.split()[1:] for line in printed.splitlines()
                            if line.startswith("floor"))
        self.assertGreater(float(walls), 0)
        self.assertAlmostEqual(float(walls) / float(last["walls"]), 1, delta=1e-9)
        self.assertAlmostEqual(float(total) / float(last["total"]), 1, delta=1e-9)
        self.assertNotIn("energies before the run", printed)
        self.assertIn("refused", printed)
        self.assertIn("-weave_fibers", printed)
        self.assertIn("-weave_fibres", printed)

    def test_commands_find_their_parts_where_they_are_installed(self):
        for command in ("run", "report", "plot", "render", "export", "analyse", "bundles",
                        "breaks", "shares"):
            self.assertIn("usage", self.call(self.prefix / f"bin/nanoweft-{command}", "--help"))
        self.call(self.prefix / "bin/nanoweft-run", "--threads", "1", "own_geometry",
                  "--", "-ts_max_steps", "100")
        for file in ("final.h5", "energy.csv"):
            self.assertTrue(os.path.exists(self.path(f"results/own_geometry/{file}")), file)
        self.assertFalse(list(self.prefix.rglob("results")))
        made = self.call("/usr/bin/python3", "-c", f"""
import sys
sys.path.insert(0, "{self.prefix}/share/nanoweft/scripts")
from nanoweft import runs, scenes
print(runs.PROGRAM, len(scenes.make("fibre", fibre_segments=7)))""")
        self.assertEqual(made.split(), [str(self.prefix / "bin/nanoweft"), "7"])

    def test_the_man_page_is_well_formed(self):
        if not os.path.exists(MAN):
            self.skipTest("there is no man")
        page = self.prefix / "share/man/man1/nanoweft.1"
        done = self.execute(MAN, "--warnings", "-l", page)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        for part in ("-weave_fibres", "EXIT STATUS"):
            self.assertIn(part, done.stdout)


if __name__ == "__main__":
    BUILD, MPIEXEC, MAN = sys.argv[1:4]
    unittest.main(argv=sys.argv[:1])
