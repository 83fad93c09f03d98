#!/usr/bin/python3
"""Random tubes in a plane: python3 make.py FILE [SEED]"""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from nanoweft.published import buckypaper  # noqa: E402

buckypaper.start(sys.argv[1], int((sys.argv[2:] or [1])[0]))
