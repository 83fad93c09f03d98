"""Tests of scripts/breaks: python3 breaks.py SCRIPTS"""
import os
import sys
import unittest

import h5py
import numpy as np
from support import FolderTest, write_state

SPACING, COUNT, TUBES = 10.0, 41, 5
LEFT, RIGHT = 1 << 28, 1 << 29


class Breaks(FolderTest):
    """Five tubes along x at y = 0, 100, ..., 400, gripped up to x = 50 and from x = 350."""

    def write(self, name, step, broken=(), axis=0, stretch=1.0, held=True, tubes=TUBES):
        x = SPACING * np.arange(COUNT)
        fibres = [np.roll(np.stack([stretch * x, np.full(COUNT, 100.0 * k), 0 * x], axis=1), axis,
                          axis=1)
                  for k in range(tubes)]
        group = np.where(x <= 50, LEFT, np.where(x >= 350, RIGHT, 0)) * held
        torn = np.zeros((tubes, COUNT), np.int8)
        for fibre, index in broken:
            torn[fibre, index] = 1
        write_state(self.path(name), fibres, step=step, time=1000.0 * step,
                    bond_broken=torn.ravel(),
                    group=np.tile(group, tubes).astype(np.int32))

    def breaks(self, *names):
        return self.run_program(os.path.join(scripts, "breaks"), *names)

    def test_places_and_times(self):
        for axis in 0, 1:
            self.write("a.h5", 0, axis=axis)
            self.write("b.h5", 10, [(0, 19)], axis=axis, stretch=1.3)
            self.write("c.h5", 20, [(0, 19), (3, 7), (2, 38)], axis=axis, stretch=1.6)
            done = self.breaks("c.h5", "a.h5", "b.h5")
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            lines = done.stdout.splitlines()
            self.assertIn(f"along {'xy'[axis]}, gage 300, width 400", lines[0])
            # Bonds from x = 190, 70 and 380 on, so their middles are at 195, 75
            # and, in the grip, 385.
            self.assertEqual([line.split(maxsplit=5) for line in lines[2:5]],
                             [["0", "19", "both", f"{145 / 300:.3f}", "0.000", "0 fs to 10 ps"],
                              ["2", "38", "both", f"{335 / 300:.3f}", "0.500", "10 ps to 20 ps"],
                              ["3", "7", "both", f"{25 / 300:.3f}", "0.250", "10 ps to 20 ps"]])
            self.assertEqual(lines[5], "broken bonds: 3 in 3 fibres")
            # The one in the grip, of which both ends are held, is not counted.
            self.assertEqual(lines[7].split()[-5:], ["1", "0", "1", "0", "0"])
            # Of the five tubes two are at the edge, two half way to the middle, one in the middle.
            self.assertEqual(lines[8].split()[-5:], ["40.0", "0.0", "40.0", "0.0", "20.0"])
            self.assertEqual(lines[9].split()[-5:], ["1", "0", "0", "0", "1"])
            self.assertEqual(lines[10].split()[-5:], ["20.0"] * 5)

    def test_broken_links_are_counted_beside_the_bonds(self):
        for torn, broken, told in (([], (), "0 in 0 fibres"),
                                   ([(0, 19)], (0,), "1 in 1 fibres, and 1 link"),
                                   ([(0, 19)], (0, 2), "1 in 1 fibres, and 2 links")):
            self.write("a.h5", 0)
            self.write("b.h5", 10, torn)
            for name, which in ("a.h5", ()), ("b.h5", broken):
                with h5py.File(self.path(name), "r+") as file:
                    file["link/segments"] = [[[k, 20], [k + 1, 20]] for k in range(4)]
                    file["link/broken"] = np.isin(np.arange(4), which).astype(np.int8)
            done = self.breaks("b.h5", "a.h5")
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertIn(f"broken bonds: {told}\n", done.stdout)

    def test_stages_follow_each_other_and_are_named(self):
        self.write("a.h5", 0)
        self.write("b.h5", 10, [(0, 19)])
        self.write("c.h5", 0, [(0, 19)])
        self.write("d.h5", 5, [(0, 19), (3, 7)])
        for name in "c.h5", "d.h5":
            with h5py.File(self.path(name), "r+") as file:
                file.create_group("run").attrs["stage"] = [1]
        done = self.breaks("d.h5", "c.h5", "b.h5", "a.h5")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual([line.split(maxsplit=5)[5] for line in done.stdout.splitlines()[2:4]],
                         ["0 fs of stage 1 to 10 ps of stage 1",
                          "0 fs of stage 2 to 5 ps of stage 2"])

    def test_a_piece_that_is_periodic_across_has_no_free_edge(self):
        for name, broken in ("a.h5", []), ("b.h5", [(0, 19), (3, 7)]):
            self.write(name, len(broken), broken)
            with h5py.File(self.path(name), "r+") as file:
                file["state"].attrs.update(periodic=[0, 1, 0], lower=[-1e5, -50, -1e5],
                                           upper=[1e5, 250, 1e5])
        done = self.breaks("a.h5", "b.h5")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        lines = done.stdout.splitlines()
        self.assertIn("width 300 along y", lines[0])
        self.assertEqual([line.split()[4] for line in lines[2:4]], ["-", "-"])
        self.assertEqual(done.stdout.count("free edge"), 1)
        self.assertIn("from nearer grip, broken", done.stdout)
        done = self.breaks("a.h5", "b.h5", "--edges=0,400")
        self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1))
        self.assertIn("no free edges", done.stderr)

    def test_the_gage_is_that_of_the_program(self):
        # Grips of 52 hold the segments up to 50 and from 350 on.
        self.write("a.h5", 0)
        self.write("b.h5", 1, [(0, 19)])
        for strain, gage in (0.0, 296), (0.1, 325.6):
            for name in "a.h5", "b.h5":
                with h5py.File(self.path(name), "r+") as file:
                    file.require_group("run").attrs.update(
                        tension=[0, 296, 400], tension_axis=[0], tension_ends=[0.0, 400.0],
                        tension_grip=[52.0], tension_strain=[0.0, strain])
            done = self.breaks("a.h5", "b.h5")
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertIn(f"gage {gage}, width", done.stdout)
            self.assertEqual(done.stdout.splitlines()[2].split()[3],
                             f"{0.5 - 5 / gage:.3f}")

    def test_bonds_that_pass_a_face_are_of_both_rows(self):
        # Faces at 58 and 342, behind the middles of the bonds from 50 to 60 and from 340 to 350.
        torn = [(0, 5), (1, 34)]
        self.write("a.h5", 0)
        self.write("b.h5", 1, torn)
        for name in "a.h5", "b.h5":
            with h5py.File(self.path(name), "r+") as file:
                file.require_group("run").attrs.update(
                    tension=[0, 284, 400], tension_axis=[0], tension_ends=[0.0, 400.0],
                    tension_grip=[58.0], tension_strain=[0.0, 0.0])
        done = self.breaks("a.h5", "b.h5")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        broken, of_all = (line.split()[-5:] for line in done.stdout.splitlines()[-2:])
        self.assertEqual(broken, ["2", "0", "0", "0", "0"])
        # Of 15 in each half four lie within 28.4 of the face or behind it.
        self.assertEqual(of_all, ["26.7", "13.3", "20.0", "20.0", "20.0"])

    def test_edges_given(self):
        self.write("a.h5", 0)
        self.write("b.h5", 10, [(0, 19), (1, 19), (3, 7)])
        done = self.breaks("a.h5", "b.h5", "--edges=50,350")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        # The outermost tubes lie outside, the next at 50 of 300.
        self.assertEqual([line.split()[4] for line in done.stdout.splitlines()[2:5]],
                         ["0.000", "0.167", "0.167"])
        for text in "1", "5,2", "a,b", "0,inf":
            done = self.breaks("a.h5", "--edges", text)
            self.assertEqual(done.returncode, 2)
            self.assertIn("invalid", done.stderr.splitlines()[-1])

    def test_nothing_broken(self):
        self.write("a.h5", 0)
        done = self.breaks("a.h5")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("broken bonds: 0", done.stdout)

    def test_refusals(self):
        self.write("a.h5", 0)
        self.write("free.h5", 0, held=False)
        self.write("other.h5", 5, tubes=3)
        with open(self.path("text.h5"), "w") as file:
            file.write("no HDF5")
        for text, *names in (("no such file", "none.h5"), ("damaged", "text.h5"),
                             ("two grips", "free.h5"),
                             ("other fibres", "a.h5", "other.h5")):
            done = self.breaks(*names)
            self.assertNotEqual(done.returncode, 0)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
            self.assertIn(text, done.stderr)


if __name__ == "__main__":
    scripts = sys.argv[1]
    unittest.main(argv=sys.argv[:1])
