#!/usr/bin/python3
"""A random network of 500 nanotubes, sheared a little, as a state file: python3 make.py FILE"""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from nanoweft import generators  # noqa: E402

generators.network(sys.argv[1], generators.Network(fibres=500, across=120), shear=1e-6)
