#!/usr/bin/python3
"""The persistence length of (10,10) tubes from the angles of their bonds: tube.py FOLDER, with the
snapshots of tube.opts."""
import argparse
import math
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from nanoweft import snapshots, states  # noqa: E402
from nanoweft.beams import TUBE  # noqa: E402
from nanoweft.problems import Unusable, command  # noqa: E402
from nanoweft.rotations import matrices  # noqa: E402

KT = 8.617333262e-5 * 300
BEGIN = 10  # snapshots until the straight start is forgotten

BLOCKS = 6  # of snapshots, for the doubt


def main() -> None:
    parser = argparse.ArgumentParser(prog="tube.py", description=__doc__)
    parser.add_argument("folder", metavar="FOLDER", type=pathlib.Path)
    folder = parser.parse_args().folder
    squares = []
    for file in snapshots.of_run(folder, "tube")[BEGIN:]:
        state = states.read(file)
        axes = matrices(state["orientation"])[:, :, 0]
        same = np.diff(state["fibre"]) == 0
        squares.append((np.diff(axes, axis=0)[same]**2).sum(1).mean())
    if len(squares) < BLOCKS:
        raise Unusable(f"{folder}: {BEGIN + BLOCKS} snapshots tube_*.h5 are needed")
    blocks = np.array([np.mean(block) for block in np.array_split(squares, BLOCKS)])
    found = 2 * TUBE.T / np.mean(squares)
    doubt = found * blocks.std(ddof=1) / math.sqrt(len(blocks)) / blocks.mean()
    print(f"persistence length: {found / 1e4:.1f} +- {doubt / 1e4:.1f} um, "
          f"EJ/kT = {TUBE.EJ / KT / 1e4:.1f} um")


command(main)
