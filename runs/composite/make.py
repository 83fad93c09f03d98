#!/usr/bin/python3
"""Two plies of glass fibres, woven through by nanotubes, with strands of nanotubes along them, as
a state file: python3 make.py FILE"""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from nanoweft import generators, states  # noqa: E402

piece = generators.composite(generators.Plies(count=2, warp=3, weft=14, segments=12, strand=7))
# The wefts are crimped: straight ones would spring out of the piece.
states.write(sys.argv[1], states.at_rest(piece))
