#!/usr/bin/python3
"""Rods of five diameters at random places in random directions: python3 make.py FILE"""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from nanoweft.published import rods  # noqa: E402

rods.start(sys.argv[1], rods.Rods())
