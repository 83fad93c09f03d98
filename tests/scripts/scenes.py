"""Tests of scenes made and mixed from Python: python3 scenes.py NANOWEFT SCRIPTS"""
from __future__ import annotations

import functools
import math
import os
import sys
import unittest

import numpy as np
from support import FolderTest

FILM = {"film_size": (500, 500), "film_segments": 20, "film_layers": 4, "film_coverage": 0.5}


@functools.cache
def film(wide: int = 500, **options: scenes.Option) -> scenes.Scene:
    return scenes.make("film", **{**FILM, "film_size": (500, wide), **options})


@functools.cache
def straight_rope(**options: scenes.Option) -> scenes.Scene:
    return scenes.make("rope", **{"rope_plies": [3], "rope_segments": 30, **options})


def rope(**options: scenes.Option) -> scenes.Scene:
    """Across the film, above it."""
    turned = straight_rope(**options).turned((0, 0, 1), math.pi / 2)
    return turned.moved((250, 250, 120))


class Scenes(FolderTest):
    def setUp(self) -> None:
        super().setUp()
        here = os.getcwd()
        self.addCleanup(os.chdir, here)
        os.chdir(self.folder)

    def test_a_film_is_what_the_program_writes(self) -> None:
        made = film(seed=7)
        done = self.run_program(nanoweft, "-scene", "film", "-film_size", "500,500",
                                "-film_segments", "20", "-film_layers", "4", "-film_coverage",
                                "0.5", "-seed", "7", "-ts_max_steps", "0", "-state_output",
                                "film.h5")
        self.assertEqual(done.returncode, 0, done.stderr)
        state = states.read("film.h5")
        for name in ("position", "orientation", "fibre", "index"):
            self.assertEqual(made[name].tobytes(), state[name].tobytes(), name)
        self.assertEqual(made.lower.tolist(), state.lower.tolist())
        self.assertEqual(made.periodic.tolist(), [True, True, False])

    def test_a_mixture_runs_on_two_ranks(self) -> None:
        flat = film(kinds="thin")
        above = rope(kinds="thick", fibre_preset="mwcnt_20_10", rope_segments=10)
        mixed = scenes.join(flat, above)
        mixed.write("mixed.h5")
        self.assertEqual(mixed.kinds.names, ("thin", "thick"))
        np.testing.assert_array_equal(np.unique(mixed.fibre), np.arange(flat.fibre.max() + 4))
        np.testing.assert_array_equal(mixed.kind, np.repeat([0, 1], [len(flat), len(above)]))
        np.testing.assert_array_equal(mixed.position[len(flat):], above.position)
        done = runs.run(["-scene", "file", "-scene_file", "mixed.h5", "-kinds", "thin,thick",
                         "-thick_fibre_preset", "mwcnt_20_10", "-ts_max_steps", "10",
                         "-state_output", "out.h5"], runs.Launch(2, folder=self.folder))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual(scenes.read("out.h5").kinds.names, ("thin", "thick"))

    def test_a_scene_turns_as_a_rigid_body(self) -> None:
        straight = straight_rope()
        straight.rows["force"] = np.tile([1.0, 2.0, 3.0], (len(straight.position), 1))
        turned = straight.turned((1, 2, 3), 0.7, (5, 6, 7))
        self.assertAlmostEqual(np.ptp(np.linalg.norm(turned.position - (5, 6, 7), axis=1)
                                      - np.linalg.norm(straight.position - (5, 6, 7), axis=1)), 0)
        chord, axis = ([scene.position[1] - scene.position[0],
                        rotations.matrices(scene.orientation)[0, :, 0]] for scene in
                       (straight, turned))
        self.assertAlmostEqual(chord[0] @ chord[1], axis[0] @ axis[1])
        # Along the axis of the turn.
        np.testing.assert_allclose(turned["force"], straight["force"], atol=1e-12)
        across = straight.turned((0, 0, 1), math.pi / 2)
        np.testing.assert_allclose(across["force"][0], (-2, 1, 3), atol=1e-12)
        self.assertTrue((turned.position > turned.lower).all())
        back = turned.turned((1, 2, 3), -0.7, (5, 6, 7))
        np.testing.assert_allclose(back.position, straight.position, atol=1e-9)
        np.testing.assert_allclose(back.orientation, straight.orientation, atol=1e-12)

    def test_rest_shapes_and_rings_are_kept(self) -> None:
        spring = scenes.make("helix", helix_segments=40, helix_rest="shaped")
        ring = scenes.make("ring", ring_segments=60, ring_windings=1).moved((0, 0, 500))
        mixed = scenes.join(spring, ring)
        self.assertEqual(mixed.closed.tolist(), [1])
        np.testing.assert_array_equal(mixed["rest_rotation"][:40], spring["rest_rotation"])
        self.assertFalse(mixed["rest_rotation"][40:].any())
        curved = scenes.make("bundle", fibre_rest_curvature=(0.001, 0), kinds="curved")
        with self.assertRaisesRegex(Unusable, "curved at rest"):
            scenes.join(scenes.make("helix", helix_rest="shaped", kinds="straight"), curved)

    def refused(self, text: str, *mixed: scenes.Scene) -> None:
        with self.assertRaisesRegex(Unusable, text):
            scenes.join(*mixed)

    def test_what_cannot_be_joined_is_refused(self) -> None:
        self.refused("periodic along y need the same box there: 0 to 500 and 0 to 600",
                     film(), film(600))
        thick = rope(kinds="a", fibre_preset="mwcnt_20_10")
        self.refused("the kind 'a' is not the same in all scenes", rope(kinds="a"), thick)
        self.refused("name their kinds and others do not", film(), thick)
        self.refused("name their kinds", film(), rope(fibre_preset="mwcnt_20_10"))
        with self.assertRaisesRegex(Unusable, "periodic box cannot be turned"):
            film().turned((0, 0, 1), 0.1)

    def test_options_are_read_as_the_program_reads_them(self) -> None:
        text = "-a 1 # one\n#-b 2\n-c\n-d run#2/out.h5\n-e 'a b#1.h5'\n-f 1,2  3\n"
        self.assertEqual(options.parse(text), {"a": "1", "c": None, "d": "run#2/out.h5",
                                               "e": "a b#1.h5", "f": "1,2 3"})

    def test_the_bond_that_closes_a_ring_through_the_box_has_its_rest_shape(self) -> None:
        turn = 0.1 * np.sin(2 * np.pi * (np.arange(16) + 0.5) / 16)
        place = np.column_stack([10.0 * np.arange(16), np.zeros(16), np.zeros(16)])
        fibre = place, rotations.rotation_about((0, 0, 1), turn)
        state = states.of_fibres([fibre], (0, -50, -50), (160, 50, 50), (1, 0, 0), closed=True)
        rest = states.at_rest(state)["rest_rotation"]
        np.testing.assert_allclose(rest[:, 2], np.roll(turn, -1) - turn, atol=1e-12)

    def test_the_box_is_the_one_asked_for(self) -> None:
        low, high = (-200, -300, -400), (800, 900, 1000)
        mixed = scenes.join(rope(), box=(low, high), periodic=(0, 1, 0))
        self.assertEqual((mixed.lower.tolist(), mixed.upper.tolist()), (list(low), list(high)))
        self.assertEqual(mixed.periodic.tolist(), [False, True, False])
        mixed = scenes.join(film(), rope())
        self.assertEqual(mixed.lower.tolist()[:2], [0, 0])
        self.assertEqual(mixed.upper.tolist(), [500, 500, rope().upper[2]])

    def test_a_refusal_of_the_program_is_an_exception_with_its_line(self) -> None:
        with self.assertRaises(Unusable) as caught:
            scenes.make("film", film_sise=(500, 500))
        self.assertEqual(str(caught.exception),
                         "unknown option -film_sise; the nearest known one is -film_size")
        with self.assertRaisesRegex(Unusable, "-text_file nowhere.txt"):
            scenes.make("text", text_file="nowhere.txt")

    def test_files_are_looked_for_where_the_caller_is(self) -> None:
        with open("line.txt", "w") as file:
            file.write("0 0 0\n20 0 0\n")
        line = scenes.make("text", text_file="line.txt", text_scale=10)
        self.assertEqual(len(line), 15)  # 200/T

    def test_overlaps_are_refused_by_the_run(self) -> None:
        scenes.join(rope(), rope().moved((0, 0, 1))).write("twice.h5")
        done = self.run_program(nanoweft, "-scene", "file", "-scene_file", "twice.h5",
                                "-ts_max_steps", "1")
        self.assertIn("fibres overlap", done.stderr)


if __name__ == "__main__":
    nanoweft, scripts = sys.argv[1:3]
    os.environ["NANOWEFT_PROGRAM"] = nanoweft
    sys.path.insert(0, scripts)
    from nanoweft import options, rotations, runs, scenes, states
    from nanoweft.problems import Unusable
    unittest.main(argv=sys.argv[:1])
