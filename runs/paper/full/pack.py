#!/usr/bin/python3
"""Keeps a fabric of hours in a file of a megabyte: pack.py pack STATE.h5 FILE.npz, and
pack.py unpack FILE.npz STATE.h5.

Packed are the places of the segments, to 0.01 A. Fibres are smooth, so that the second differences
along them are small numbers, which compress well. Axes follow from the places; velocities and twist
are not kept. It is for fabrics near rest of open fibres of one length and kind, straight at rest,
without marks, links or breaks, and refuses others.
"""
import argparse
import pathlib
import sys
import zipfile

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "scripts"))
from nanoweft import generators, rotations, states  # noqa: E402
from nanoweft.problems import Unusable, command  # noqa: E402

STEP = 0.01  # A
NOT_KEPT = ("bond_broken", "kind", "group", "image", "rest_rotation", "rest_extension")


def pack(source: pathlib.Path, target: pathlib.Path) -> None:
    """Writes the places of all fibres of a state."""
    state = states.read(source)
    for row in NOT_KEPT:
        if row in state and np.any(state[row]):
            raise Unusable(f"{source}: has {row}, which would be lost")
    if state.units != "nano":
        raise Unusable(f"{source}: its units are {state.units}, and places are kept in A")
    if len(state.closed) or len(state.links) or state.tilt.any():
        raise Unusable(f"{source}: has closed fibres, links or a tilted box, which would be lost")
    fibre = state["fibre"]
    count = len(np.unique(fibre))
    if len(fibre) % count or (np.diff(fibre.reshape(count, -1), axis=1) != 0).any():
        raise Unusable(f"{source}: its fibres are not all of one length")
    places = np.rint(state["position"] / STEP).astype(np.int64).reshape(count, -1, 3)
    bends = np.diff(places, n=2, axis=1)
    if abs(bends).max() >= 2 ** 15:
        raise Unusable(f"{source}: is not at rest")
    np.savez_compressed(
        target, step=STEP, time=state.time, lower=state.lower, upper=state.upper,
        periodic=state.periodic, first=places[:, :2].astype(np.int32),
        # A plane for each byte of each component: like numbers beside each other.
        bends=np.ascontiguousarray(bends.astype(np.int16).transpose(2, 0, 1)).view(np.uint8)
        .reshape(3, -1, 2).transpose(0, 2, 1).copy())


def unpack(source: pathlib.Path, target: pathlib.Path) -> None:
    """Writes the state file, at rest, with axes along the fibres."""
    packed = np.load(source)
    first, bends = packed["first"].astype(np.int64), packed["bends"]
    bends = np.ascontiguousarray(bends.transpose(0, 2, 1)).view(np.int16)
    bends = bends.reshape(3, len(first), -1).transpose(1, 2, 0).astype(np.int64)
    steps = np.cumsum(np.concatenate([first[:, 1:] - first[:, :1], bends], axis=1), axis=1)
    places = np.concatenate([first[:, :1], first[:, :1] + np.cumsum(steps, axis=1)], axis=1)
    places = places * float(packed["step"])
    axes = np.stack([rotations.matrices(generators.unsheared(x))[:, :, 0] for x in places])
    fibres = list(zip(places, rotations.carried(axes)))
    state = states.of_fibres(fibres, packed["lower"], packed["upper"], packed["periodic"])
    state.time = float(packed["time"])
    states.write(target, state)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    parser.add_argument("what", choices=("pack", "unpack"))
    parser.add_argument("source", type=pathlib.Path)
    parser.add_argument("target", type=pathlib.Path)
    words = parser.parse_args()
    try:
        (pack if words.what == "pack" else unpack)(words.source, words.target)
    except (ValueError, KeyError, zipfile.BadZipFile):
        raise Unusable(f"{words.source}: was not packed by this program") from None


if __name__ == "__main__":
    command(main)
