"""Tests of scripts/plot: python3 plot.py NANOWEFT SCRIPTS"""
import os
import sys
import unittest

import numpy as np
from PIL import Image
from support import FolderTest


def write_table(name, columns, *comments):
    with open(name, "w") as file:
        file.writelines(f"# {line}\n" for line in comments)
        file.write(",".join(columns) + "\n")
        for row in zip(*columns.values()):
            file.write(",".join(f"{value:.17g}" for value in row) + "\n")


def energies(time, elastic):
    zero = np.zeros(len(time))
    return {"step": time / 20, "time_fs": time, "stretch": zero, "shear": zero, "bending": elastic,
            "torsion": zero,
            "pair": zero, "kinetic": zero, "rotational": zero, "total": elastic,
            "damped": elastic[0] - elastic,
            "external": zero, "broken": zero}


def stresses(**more):
    strain = np.linspace(0, 0.4, 80)
    stress = 12 * strain * np.exp(-(strain / 0.25) ** 3)
    return {"step": np.arange(80.0), "time_fs": np.arange(80.0), "strain": strain,
            "stress_left_GPa": stress,
            "stress_right_GPa": stress, "broken_bonds": np.arange(80) // 20, **more}


def near(picture, colour):
    return (np.abs(picture - np.array(colour)) < 40).all(axis=2)


BLUE, VERMILION, GREEN = (0, 0x72, 0xB2), (0xD5, 0x5E, 0), (0, 0x9E, 0x73)


class Plot(FolderTest):
    def plot(self, *arguments):
        return self.run_program(os.path.join(scripts, "plot"), *arguments)

    def draw(self, *arguments):
        done = self.plot(*arguments, "-o", "out.png")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        with Image.open(self.path("out.png")) as picture:
            return np.asarray(picture.convert("RGB")).astype(int)

    def expect_refusal(self, text, *arguments):
        before = sorted(os.listdir(self.folder))
        done = self.plot(*arguments)
        self.assertNotEqual(done.returncode, 0)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        self.assertIn(text, done.stderr)
        self.assertEqual(sorted(os.listdir(self.folder)), before)

    def test_decay_is_found(self):
        sys.path.insert(0, scripts)
        from nanoweft.analysis.decay import fit_decay
        time = np.arange(0, 400.0)
        for tau in 12.0, 90.0:
            # A fast first part, gone long before half of the fall is done, does not disturb.
            energy = 30 + 200 * np.exp(-time / tau) + 5 * np.exp(-time / 0.5)
            plateau, height, constant, begin = fit_decay(time, energy)
            # Time constants are tried in steps of 1.5 %; the best is at most half a step away.
            self.assertAlmostEqual(constant / tau, 1, delta=0.01)
            self.assertAlmostEqual(plateau, 30, delta=0.01 * 200)
            self.assertAlmostEqual(height, 200 * np.exp(-begin / tau), delta=0.01 * 200)
        self.assertIsNone(fit_decay(time, 1000 - time))  # no plateau in sight
        self.assertIsNone(fit_decay(time, np.full(400, 7.0)))
        self.assertIsNone(fit_decay(time[:4], energy[:4]))

    def test_convergence_of_an_exponential_is_a_straight_line(self):
        time = np.arange(0, 4000.0, 10)
        write_table(self.path("a.csv"), energies(time, 30 + 200 * np.exp(-time / 500)))
        picture = self.draw("convergence", "a.csv")
        curve = near(picture, BLUE)[len(picture) // 2:]
        columns = np.flatnonzero(curve.any(axis=0))
        # Between where it starts and where the rounded plateau bends it.
        columns = columns[:len(columns) * 6 // 10]
        height = np.array([np.flatnonzero(curve[:, x]).mean() for x in columns])
        fit = np.polyval(np.polyfit(columns, height, 1), columns)
        self.assertGreater(np.ptp(height), 100)
        self.assertLess(np.abs(height - fit).max(), 0.05 * np.ptp(height))

    def test_fire_is_drawn_over_steps(self):
        time = np.arange(0, 4000.0, 10)
        columns = energies(time, 30 + 200 * np.exp(-time / 500))
        write_table(self.path("motion.csv"), columns, "nanoweft 0.1.0", "-ts_dt 20")
        write_table(self.path("fire.csv"), columns, "nanoweft 0.1.0", "-relax_method fire")
        motion, fire = (tables.read(self.path(f"{name}.csv")) for name in ("motion", "fire"))
        for one, over, constant in (([motion], "time, ps", "time constant 0.502 ps,"),
                                    ([fire], "step", "constant 25 steps,"),
                                    ([motion, fire], "step", "constant 25 steps,")):
            for kind in "energy", "convergence":
                bottom = plots.draw(kind, one, ["one", "two"][:len(one)]).axes[-1]
                self.assertEqual(bottom.get_xlabel(), over)
            for line in bottom.get_legend().get_texts():
                self.assertIn(constant, line.get_text())
            self.assertNotIn("time constant" if over == "step" else "steps", line.get_text())

    def test_every_run_has_its_colour(self):
        time = np.arange(0, 4000.0, 10)
        write_table(self.path("a.csv"), energies(time, 30 + 200 * np.exp(-time / 500)))
        write_table(self.path("b.csv"), energies(time, 60 + 300 * np.exp(-time / 800)))
        for kind in "energy", "convergence":
            both = self.draw(kind, "a.csv", "b.csv", "--labels", "one", "two")
            self.assertGreater(near(both, VERMILION).sum(), 500)
            self.assertEqual(near(both, GREEN).sum(), 0)
            longer = self.draw(kind, "a.csv", "b.csv", "--labels", "one and a long name", "two")
            self.assertGreater((longer.max(axis=2) < 100).sum(),
                               (both.max(axis=2) < 100).sum() + 100)

    def test_virial_stress_where_there_is_one(self):
        write_table(self.path("plain.csv"), stresses())
        one = np.linspace(0, 1, 80)
        write_table(self.path("virial.csv"),
                    stresses(virial_xx_GPa=0.1 * one, virial_yy_GPa=0.5 * one,
                                                      virial_xy_GPa=2 * one))
        self.assertEqual(near(self.draw("stress", "plain.csv"), VERMILION).sum(), 0)
        picture = self.draw("stress", "virial.csv")
        rows, columns = np.nonzero(near(picture, VERMILION))
        self.assertGreater(len(rows), 500)
        # yy is nearer to the grips than xx, and shear does not count: it ends at a third of the
        # strength.
        strength = np.flatnonzero(near(picture, BLUE).sum(axis=1) > 3)
        self.assertGreater(rows[columns > 0.85 * picture.shape[1]].min(), strength.min())
        self.draw("stress", "plain.csv", "virial.csv")

    def test_the_virial_stress_is_that_along_the_pull(self):
        grips = stresses()["stress_left_GPa"]
        # What changes most, and what is nearest to the grips, is across the pull.
        for axis, *options in ("x",), ("y", "-tension_axis y"), ("z", "-tension_axis z"):
            normal = {f"virial_{d}{d}_GPa": grips for d in "xyz"}
            normal[f"virial_{axis}{axis}_GPa"] = 0.5 * grips
            write_table(self.path("a.csv"), stresses(**normal), "nanoweft 1.0", "-seed 1", *options)
            np.testing.assert_allclose(plots.virial_of(tables.read(self.path("a.csv"))),
                                       0.5 * grips)

    def test_where_the_table_does_not_tell_the_axis_the_grips_do(self):
        grips = stresses()["stress_left_GPa"]
        more = {"virial_xx_GPa": 0 * grips, "virial_yy_GPa": 0.9 * grips,
                "virial_zz_GPa": 4 * grips}
        # A test that goes on has the axis of its first stage.
        for comments in (), ("nanoweft 1.0", "-scene file"):
            write_table(self.path("a.csv"), stresses(**more), *comments)
            np.testing.assert_allclose(plots.virial_of(tables.read(self.path("a.csv"))),
                                       0.9 * grips)
        write_table(self.path("a.csv"), stresses())
        self.assertIsNone(plots.virial_of(tables.read(self.path("a.csv"))))

    def test_a_test_that_presses_has_its_largest_pressure_marked(self):
        pulled = stresses()
        pressed = {name: -values if name[:6] in ("strain", "stress") else values
                   for name, values in pulled.items()}
        largest = pulled["stress_left_GPa"].max()
        for columns, sign in (pulled, 1), (pressed, -1):
            write_table(self.path("s.csv"), columns)
            self.draw("stress", "s.csv")
            figure = plots.plot_stress([tables.read(self.path("s.csv"))], ["s"])
            self.assertEqual([text.get_text().split(" GPa")[0] for text in figure.axes[0].texts],
                             [f"{sign * largest:.3g}"])

    def test_tables_of_the_program(self):
        done = self.run_program(nanoweft, *"-weave_fibres 4,4 -weave_segments 24 -damping_local 0.4"
                                " -ts_max_steps 60 -monitor_interval 5"
                                " -energy_monitor ascii:energy.csv -tension_rate 1e-6"
                                " -stress_monitor ascii:stress.csv -progress_interval 0".split())
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        for kind, name in (("energy", "energy.csv"), ("convergence", "energy.csv"),
                           ("stress", "stress.csv")):
            self.assertGreater(np.ptp(self.draw(kind, name)), 200)

    def test_a_line_that_is_not_whole_is_left_out(self):
        for end in ("", "-3.25", "-3.25e", "-3.25e-1"):
            with open(self.path("torn.csv"), "w") as file:
                file.write("# nanoweft 0.1.0\nstep,time_fs,stretch\n0,0,1\n1,10,2\n"
                           + (end and "2,20," + end))
            self.assertEqual(list(tables.read(self.path("torn.csv"))["stretch"]), [1, 2])

    def test_pictures_of_two_kinds_have_two_names(self):
        with open(self.path("energy.csv"), "w") as file:
            file.write("step,time_fs,stretch,shear,bending,torsion,pair,kinetic,rotational,total,"
                       "damped,external,broken\n")
            file.writelines(f"{k},{20 * k},{100 * 0.9**k},0,0,0,-1,1,1,{1 + 100 * 0.9**k},0,0,0\n"
                            for k in range(60))
        for kind, name in (("energy", "energy.png"), ("convergence", "energy_convergence.png")):
            done = self.run_program(os.path.join(scripts, "plot"), kind, "energy.csv")
            self.assertEqual((done.returncode, done.stdout.strip()), (0, name), done.stderr)
            self.assertTrue(os.path.exists(self.path(name)))

    def test_refusals(self):
        write_table(self.path("stress.csv"), stresses())
        with open(self.path("short.csv"), "w") as file:
            file.write("step,time_fs,strain,stress_left_GPa,stress_right_GPa,broken_bonds\n"
                       "0,0,0,0,0,0\n")
        with open(self.path("words.csv"), "w") as file:
            file.write("step,time_fs,strain,stress_left_GPa,stress_right_GPa,broken_bonds\n"
                       + "a,b,c,d,e,f\n" * 3)
        with open(self.path("empty.csv"), "w"):
            pass
        with open(self.path("binary.csv"), "wb") as file:
            file.write(bytes(range(256)))
        self.expect_refusal("No such file", "stress", "none.csv")
        self.expect_refusal("no column", "convergence", "stress.csv")
        self.expect_refusal("no column", "stress", "empty.csv")
        self.expect_refusal("fewer than two rows", "stress", "short.csv")
        self.expect_refusal("a line without", "stress", "words.csv")
        self.expect_refusal("not a CSV file", "stress", "binary.csv")
        self.expect_refusal("1 labels", "stress", "stress.csv", "stress.csv", "--labels", "a")
        self.expect_refusal("cannot write", "stress", "stress.csv", "-o", "none/out.png")


if __name__ == "__main__":
    nanoweft, scripts = sys.argv[1:3]
    sys.path.insert(0, scripts)
    from nanoweft import tables  # noqa: E402
    from nanoweft.pictures import plots  # noqa: E402
    unittest.main(argv=sys.argv[:1])
