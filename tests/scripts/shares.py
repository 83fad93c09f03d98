"""Tests of scripts/shares: python3 shares.py NANOWEFT SCRIPTS"""
import os
import sys
import unittest

import h5py
import numpy as np
from support import FolderTest, write_state

COUNT, T = 31, 13.56


class Shares(FolderTest):
    """A soft and a stiff fibre side by side, pulled to 1 %."""

    def pull(self, *more, test="-tension_rate 2e-6 -tension_max_strain 0.01"):
        x = np.zeros((COUNT, 3))
        x[:, 0] = np.arange(COUNT) * T
        self.write(x)
        options = ("-scene file -scene_file in.h5 -kinds soft,stiff -soft_fibre_young 500 "
                   "-stiff_fibre_young 1500 -pair none -damping_local 0.5 "
                   "-tension_grip 20 -tension_width 100 -tension_thickness 17 "
                   "-snapshot_interval 125 -monitor_interval 125 -stress_monitor ascii:stress.csv "
                   + " ".join((test, *more)))
        return self.simulate(nanoweft, options)

    def write(self, x):
        state = states.of_fibres([(x + [0, y, 0], rotations.along(x)) for y in (0, 100)],
                                 x.min(axis=0) - 200, x.max(axis=0) + 200)
        states.write(self.path("in.h5"), states.of_kinds(state, ("soft", "stiff"), (0, 1)))

    def shares(self, *arguments):
        return self.run_program(os.path.join(scripts, "shares"), *arguments)

    def test_stresses_of_the_kinds_add_up_to_that_of_the_table(self):
        frames = self.pull()
        table = tables.read(self.path("stress.csv"))
        for file in frames[len(frames) // 2:]:
            state = states.read(file)
            pull = shares.Pull(file, state)
            stress = shares.stress_by_kind(pull, state)
            virial = np.interp(pull.strain, table["strain"], table["virial_xx_GPa"])
            # The motion's part is in the table alone.
            self.assertAlmostEqual(stress.sum() / virial, 1, delta=2e-3)
            self.assertAlmostEqual(stress[1] / stress.sum(), 0.75, delta=0.05)

    def test_what_has_flowed_is_at_rest_longer(self):
        last = self.pull("-soft_fibre_yield_strain 0.004", "-tension_max_strain 0.02")[-1]
        stress = shares.stress_by_kind(shares.Pull(last, states.read(last)), states.read(last))
        section = 2 * np.pi * 3.35 * 6.78
        self.assertAlmostEqual(stress[0] / (500 * 0.004 * section / 1700), 1, delta=0.02)

    def test_a_piece_that_is_let_back_has_its_snapshots_in_order_of_time(self):
        frames = self.pull(test="-tension_program 0.006,2e-6,0.002,2e-6")
        done = self.shares(*reversed(frames), "-o", "out.png")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        strains = [float(line.split()[0]) for line in done.stdout.splitlines()[1:-1]]
        pulled = [shares.Pull(name, states.read(name)).strain for name in frames]
        self.assertEqual(strains, [float(f"{100 * strain:.3f}") for strain in pulled])
        self.assertLess(strains[-1], max(strains))

    def test_the_stages_of_a_test_follow_each_other(self):
        first = self.pull("-state_output end.h5")
        for name in first:
            os.rename(name, name.replace("frame_", "first_"))
        second = self.pull("-scene_file end.h5", "-overwrite",
                           test="-tension_rate 2e-6 -tension_max_strain 0.02")
        both = [name.replace("frame_", "first_") for name in first] + second
        done = self.shares(*reversed(both))
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        strains = [float(line.split()[0]) for line in done.stdout.splitlines()[1:]]
        self.assertEqual(len(strains), len(both))
        self.assertEqual(strains, sorted(strains))
        self.assertGreater(strains[-1], 1.5)

    def test_a_broken_kind_carries_nothing(self):
        last = self.pull("-soft_break_strain_mean 0.004 -soft_break_strain_std 0",
                         "-tension_max_strain 0.03")[-1]
        stress = shares.stress_by_kind(shares.Pull(last, states.read(last)), states.read(last))
        self.assertLess(abs(stress[0]), 0.02 * stress[1])

    def test_the_printed_table_has_a_line_for_each_snapshot_and_the_picture_is_there(self):
        frames = self.pull()
        done = self.shares(*reversed(frames), "-o", "out.png")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        lines = done.stdout.splitlines()
        self.assertIn("soft, GPa", lines[0])
        self.assertIn("stiff, GPa", lines[0])
        strains = [float(line.split()[0]) for line in lines[1:-1]]
        self.assertEqual(len(strains), len(frames))
        self.assertEqual(strains, sorted(strains))
        self.assertTrue(os.path.exists(self.path("out.png")))

    def test_a_soft_piece_has_its_digits(self):
        last = self.pull("-soft_fibre_young 1e-3", "-stiff_fibre_young 3e-3")[-1]
        stress = shares.stress_by_kind(shares.Pull(last, states.read(last)), states.read(last))
        self.assertLess(np.abs(stress).max(), 5e-5)
        words = self.shares(last).stdout.splitlines()[1].split()
        self.assertEqual([words[1], words[3]], [f"{part:.4g}" for part in stress])

    def test_links_are_named_as_left_out(self):
        last = self.pull()[-1]
        with h5py.File(self.path(last), "r+") as file:
            file["link/segments"] = [[[0, 15], [1, 15]]]
        done = self.shares(last)
        self.assertEqual((done.returncode, done.stderr),
                         (0, "shares: warning: what links carry is not in it\n"))
        self.assertIn("links", self.shares("--help").stdout)

    def test_what_is_no_tension_test_is_refused_in_one_line(self):
        write_state(self.path("still.h5"), [np.eye(3)])
        for file, text in (("still.h5", "not a snapshot of a tension test"),
                           ("none.h5", "no such file")):
            done = self.shares(file)
            self.assertNotEqual(done.returncode, 0)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
            self.assertIn(text, done.stderr)


if __name__ == "__main__":
    nanoweft, scripts = sys.argv[1:3]
    sys.path.insert(0, scripts)
    from nanoweft import rotations, states, tables  # noqa: E402
    from nanoweft.analysis import shares  # noqa: E402
    unittest.main(argv=sys.argv[:1])
