"""Tests of scripts/run and of what scenes print at their end: python3 run.py NANOWEFT SCRIPTS"""
from __future__ import annotations

import pathlib
import re
import shutil
import subprocess
import sys
import unittest

from support import FolderTest


class Run(FolderTest):
    """Scenes of an installed tree, whose results belong to the caller's folder."""

    def setUp(self) -> None:
        super().setUp()
        share = pathlib.Path(self.path("share/nanoweft"))
        shutil.copytree(scripts, share / "scripts", ignore=shutil.ignore_patterns("__pycache__"))
        for scene in "cantilever", "capstan", "own_geometry", "wire":
            shutil.copytree(scripts.parent / "runs" / scene, share / "runs" / scene)
        pathlib.Path(self.path("bin")).mkdir()
        pathlib.Path(self.path("bin/nanoweft")).symlink_to(nanoweft)

    def scene(self, *words: str) -> subprocess.CompletedProcess[str]:
        done = self.execute(self.path("share/nanoweft/scripts/run"), "--threads", "1", *words)
        self.assertNotIn("Traceback", done.stderr)
        return done

    def well(self, *words: str) -> str:
        done = self.scene(*words)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return str(done.stdout)

    def test_too_short_a_run_ends_with_a_line_and_a_report(self) -> None:
        done = self.scene("wire", "--", "-ts_max_steps", "100")
        self.assertEqual(done.returncode, 1)
        self.assertIn("after: the run is too short for a rate of decay: viscous.csv\n", done.stderr)
        self.assertIn("report: ", done.stdout)
        done = self.scene("cantilever", "--", "-ts_max_steps", "100")
        self.assertEqual(done.returncode, 1)
        self.assertIn("after: the run is too short for rest", done.stderr)

    def test_closed_forms_are_of_the_run_s_own_options(self) -> None:
        for more in ((), ("-tip_force", "0,0,0.002", "-fibre_young", "500", "-overwrite")):
            found = re.search(r"difference (\S+)", self.well("cantilever", "--", *more))
            assert found
            self.assertLess(abs(float(found[1])), 1e-3)
        found = re.search(r"over it (\S+)", self.well("capstan", "--", "-rod_friction", "0.5"))
        assert found
        self.assertAlmostEqual(float(found[1]), 1, delta=0.02)
        self.assertIn("exp(mu phi R/(R + rf)) 2.4638", self.well("capstan", "--", "-overwrite"))

    def test_known_numbers_are_left_out_where_options_are_others(self) -> None:
        usual = self.well("own_geometry", "--", "-ts_max_steps", "2000")
        self.assertIn("(endless tubes: 17.0716)", usual)
        other = self.well("own_geometry", "--", "-pair_points", "3", "-overwrite")
        self.assertNotIn("17.0716", other)
        self.assertIn("left out here, are for the values of the option files, without -pair_points",
                      other)

    def test_a_copy_names_its_own_results(self) -> None:
        copy = pathlib.Path(self.path("elsewhere/mine"))
        shutil.copytree(scripts.parent / "runs" / "own_geometry", copy)
        done = self.scene(str(copy))
        self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1))
        self.assertFalse(pathlib.Path(self.path("results")).exists())
        found = re.search(r"to change them: (sed .*)", done.stderr)
        assert found
        self.execute("bash", "-c", found[1])
        self.assertIn("distance 17.", self.well(str(copy)))
        self.assertTrue(pathlib.Path(self.path("results/mine/report.html")).exists())


if __name__ == "__main__":
    nanoweft, scripts = pathlib.Path(sys.argv[1]).absolute(), pathlib.Path(sys.argv[2]).absolute()
    unittest.main(argv=sys.argv[:1])
