"""Tests of yarns of staple fibres: python3 yarn.py BINARY SCRIPTS"""
import sys
import unittest

import numpy as np
from support import FolderTest

OPTIONS = ("-units si -scene file -scene_file start.h5 -fibre_preset nylon_ef -pair contact "
           "-contact_restitution 0.3 -fibre_retardation 1e-10 -tension_rate 2e5 "
           "-tension_ramp 2e-8 -tension_grip 6e-6 -tension_width 1.7e-6 -tension_thickness 1e-6 "
           "-tension_max_strain 0.06 -stress_monitor ascii:stress.csv -progress_interval 0 "
           "-overwrite ")


class Yarns(FolderTest):
    def strength(self, turns, friction):
        """Largest mean stress in 1 % of strain, after the jerk at the start, GPa."""
        count = generators.yarn(self.path("start.h5"), generators.Yarn(turns, 40, 80))
        self.assertGreater(count, 6)
        done = self.run_program(binary, *OPTIONS.split(), "-contact_friction", str(friction))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        table = tables.read(self.path("stress.csv"))
        strain, stress = table["strain"], table["stress_left_GPa"]
        return max(stress[(strain > low) & (strain <= low + 0.01)].mean()
                   for low in (0.01, 0.02, 0.03, 0.04, 0.05))

    def test_twist_and_friction_hold_a_yarn_together_and_neither_does_alone(self):
        both = self.strength(5, 0.4)
        self.assertGreater(both, 5 * abs(self.strength(0, 0.4)))
        self.assertGreater(both, 3 * abs(self.strength(5, 0)))

    def test_strands_neither_overlap_much_nor_stretch(self):
        for turns in 0, 5:
            strands = generators.Yarn(turns).strands()
            chords = np.linalg.norm(np.diff(strands, axis=1), axis=2)
            np.testing.assert_allclose(chords, 2, atol=1e-3)
            for between in False, True:
                least = generators.nearest(strands, between)
                self.assertGreater(least, 1.95)
                self.assertLess(least, 2.1)


if __name__ == "__main__":
    binary, scripts = sys.argv[1:3]
    sys.path.insert(0, scripts)
    from nanoweft import generators, tables  # noqa: E402
    unittest.main(argv=sys.argv[:1])
