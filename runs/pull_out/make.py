#!/usr/bin/python3
"""Parallel tubes that touch, the first of which is to be pulled out:
python3 make.py FILE [2|3|7]"""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from nanoweft.published import pull_out  # noqa: E402

pull_out.start(sys.argv[1], int((sys.argv[2:] or [7])[0]))
