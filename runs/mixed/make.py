#!/usr/bin/python3
"""A rope of thick tubes above a film of thin ones, as a state file: make.py FILE"""
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from nanoweft import scenes  # noqa: E402

film = scenes.make("film", film_size=(800, 800), film_segments=40, film_layers=8,
                   film_coverage=1.4, film_persistence=1500, kinds=["thin"])
rope = scenes.make("rope", rope_plies=[7], rope_segments=20, kinds=["thick"],
                   thick_fibre_preset="mwcnt_20_10")
above = (400, 400, film.position[:, 2].max() + 110)
mixed = scenes.join(film, rope.turned((0, 0, 1), math.pi / 6).moved(above),
                    box=((0, 0, -100), (800, 800, 900)))
mixed.write(sys.argv[1])
