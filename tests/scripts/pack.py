"""Tests of runs/paper/full/pack.py: python3 pack.py RUNS"""
import os
import sys
import unittest

import numpy as np
from support import FolderTest, read_state, write_state


class Pack(FolderTest):
    """Three fibres of one length, coiled as helices are, so that carried axes matter."""

    def write(self, name, fibres=3, segments=40, **more):
        s = 13.56 * np.arange(segments)
        radius, pitch = 60.0, 300.0
        turn = s / np.hypot(radius, pitch / (2 * np.pi))
        x = np.stack([radius * np.cos(turn), radius * np.sin(turn), pitch / (2 * np.pi) * turn], 1)
        write_state(self.path(name), [x + (200.0 * k, 0, 0) for k in range(fibres)], time=500.0,
                    **more)

    def pack(self, *words):
        return self.run_program(os.path.join(runs, "paper/full/pack.py"), *words)

    def test_come_back(self):
        self.write("a.h5")
        for words in (("pack", "a.h5", "a.npz"), ("unpack", "a.npz", "b.h5")):
            done = self.pack(*words)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
        before, after = read_state(self.path("a.h5")), read_state(self.path("b.h5"))
        # Rounded to 0.01 A.
        self.assertLess(np.abs(before["position"] - after["position"]).max(), 0.00501)
        for name in "fibre", "index", "lower", "upper", "periodic", "time":
            self.assertTrue((before[name] == after[name]).all(), name)
        self.check_axes(after["position"].reshape(3, 40, 3), after["orientation"].reshape(3, 40, 4))
        self.assertLess(os.path.getsize(self.path("a.npz")), 0.2 * before["position"].nbytes + 3000)

    def check_axes(self, x, q):
        """Axes of neighbours have the chord between them as their mean; no bond is twisted."""
        w, v = q[..., :1], q[..., 1:]
        axis = np.concatenate([1 - 2 * (v[..., 1:2] ** 2 + v[..., 2:] ** 2),
                               2 * (v[..., :1] * v[..., 1:2] + w * v[..., 2:]),
                               2 * (v[..., :1] * v[..., 2:] - w * v[..., 1:2])], -1)
        chord = np.diff(x, axis=1)
        chord /= np.linalg.norm(chord, axis=-1)[..., None]
        mean = axis[:, 1:] + axis[:, :-1]
        mean /= np.linalg.norm(mean, axis=-1)[..., None]
        self.assertLess(np.abs(mean - chord)[:, 3:-3].max(), 2e-3)
        # The turn from one to the next: the vector part of q2 q1*.
        (w1, v1), (w2, v2) = ((q[:, k, :1], q[:, k, 1:]) for k in (slice(0, -1), slice(1, None)))
        turn = w1 * v2 - w2 * v1 - np.cross(v2, v1)
        along = (turn * mean).sum(axis=-1)
        self.assertLess(np.abs(along).max(), 1e-9)
        self.assertGreater(np.linalg.norm(turn, axis=-1).max(), 0.05)

    def test_refusals(self):
        torn = np.zeros(120, np.int8)
        torn[5] = 1
        self.write("torn.h5", bond_broken=torn)
        self.write("marked.h5", group=np.ones(120, np.int32))
        self.write("ring.h5", fibre_closed=np.array([1]))
        with open(self.path("cut.npz"), "wb") as file:
            file.write(b"PK\x03\x04 and no more")
        there = sorted(os.listdir(self.folder))
        for what, name, words in (("pack", "torn.h5", "torn.h5: has bond_broken, which would be"),
                                  ("pack", "marked.h5", "marked.h5: has group"),
                                  ("pack", "ring.h5", "ring.h5: has closed fibres"),
                                  ("pack", "missing.h5", "missing.h5"),
                                  ("unpack", "cut.npz", "cut.npz: was not packed"),
                                  ("unpack", "missing.npz", "missing.npz"),
                                  ("unpack", "torn.h5", "torn.h5: was not packed")):
            done = self.pack(what, name, "no")
            self.assertEqual(done.returncode, 1)
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
            self.assertIn(words, done.stderr)
            self.assertEqual(sorted(os.listdir(self.folder)), there)


runs = sys.argv.pop(1)
unittest.main()
