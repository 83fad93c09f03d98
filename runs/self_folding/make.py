#!/usr/bin/python3
"""A folded (10,10) tube: a loop whose ends lie side by side: python3 make.py FILE [SEGMENTS]"""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from nanoweft.published import self_folding  # noqa: E402

self_folding.start(sys.argv[1], int((sys.argv[2:] or [340])[0]))
