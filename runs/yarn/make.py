#!/usr/bin/python3
"""A two-ply yarn of staple fibres: python3 make.py FILE [TURNS OF A PLY]"""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from nanoweft import generators  # noqa: E402

generators.yarn(sys.argv[1], generators.Yarn(float((sys.argv[2:] or [6])[0])))
