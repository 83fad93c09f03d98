#!/usr/bin/python3
"""A fibril across a gap, and fibrils to be pulled: python3 make.py BEAM FIBRILS"""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from nanoweft.published import insulin  # noqa: E402

insulin.beam(sys.argv[1])
insulin.fibrils(sys.argv[2])
