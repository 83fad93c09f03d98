#!/usr/bin/python3
"""Poisson's ratio of random sheets of thin and thick nanotubes: measure.py FOLDER [--help]

Prints a row for each sheet: share of thick tubes, angle by which the direction of a tube swings,
stiffness of its links over that of a bond, mean length between links, modulus, Poisson's ratio, its
standard error."""
from __future__ import annotations

import argparse
import itertools
import pathlib
import sys
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "scripts"))
from nanoweft import rotations, runs, states, tables  # noqa: E402
from nanoweft.generators import LENGTH  # noqa: E402
from nanoweft.problems import RunFailed, command  # noqa: E402

SIDE, SEGMENTS, THICKNESS = 800.0, 40, 17.1
STRAIN = 0.001
BOND = 67.6, 19781.0, -4032.0, 1470.5     # stiffnesses B1 to B4 of a thin tube's bond
WAVE = 15 * LENGTH          # length of a wave along the tube
Array = NDArray[np.float64]


class Sheet(NamedTuple):
    apart: float        # length of tube between two links that is asked for, A
    share: float        # of thick tubes, in their number
    angle: float
    links: float        # stiffness of a link over that of a thin tube's bond


def tube(random: np.random.Generator, angle: float) -> states.Fibre:
    """A tube in one of two planes whose direction swings by this angle; it starts anywhere."""
    place = LENGTH * np.arange(SEGMENTS) * 2 * np.pi / WAVE + random.uniform(0, 2 * np.pi)
    heading = random.uniform(0, 2 * np.pi) + angle * np.sin(place)
    ways = np.column_stack([np.cos(heading), np.sin(heading), np.zeros(SEGMENTS)])
    # Bonds join the middles of segments: half of each of both.
    chord = 0.5 * (ways[1:] + ways[:-1])
    x = np.zeros((SEGMENTS, 3))
    x[1:] = LENGTH * np.cumsum(chord / np.linalg.norm(chord, axis=1)[:, None], axis=0)
    return (x + [*(SIDE * random.random(2)), LENGTH * random.integers(2)],
            rotations.rotation_about((0, 0, 1), heading))


def crossings(x: Array, tubes: int) -> Array:
    """Fibre and index of the nearest segments [L,2,2] where tubes of the two planes cross."""
    ends = []
    flat = x.reshape(tubes, SEGMENTS, 3)[..., :2]
    for i in range(tubes):
        for j in range(i + 1, tubes):
            if x[SEGMENTS * i, 2] == x[SEGMENTS * j, 2]:
                continue
            way = flat[i][:, None] - flat[j]
            near = np.linalg.norm(way - SIDE * np.round(way / SIDE), axis=2)
            inner = near < LENGTH / np.sqrt(2)
            while inner.any():
                a, b = divmod(int(np.argmin(np.where(inner, near, np.inf))), SEGMENTS)
                ends.append([(i, a), (j, b)])
                inner[max(0, a - 2):a + 3, max(0, b - 2):b + 3] = False
    return np.array(ends)


def sheet(file: pathlib.Path, how: Sheet, seed: int) -> float:
    """Writes tubes tied where they cross; the mean length of tube between two links."""
    random = np.random.default_rng(seed)
    tubes = round(SIDE**2 * np.pi / how.apart / (SEGMENTS * LENGTH))
    fibres = [tube(random, how.angle) for _ in range(tubes)]
    state = states.of_fibres(fibres, [0, 0, -300], [SIDE, SIDE, 300], (1, 1, 0))
    state = states.of_kinds(state, ["cnt", "mw"], np.arange(tubes) < round(how.share * tubes))
    if how.angle:
        state = states.at_rest(state)
    states.write(file, state)
    ends = crossings(state["position"], tubes)
    states.link(file, ends)
    return tubes * SEGMENTS * LENGTH / (2 * len(ends))


def stage(name: str, links: float, *words: str) -> None:
    stiffness = ",".join(f"{links * x:g}" for x in BOND)
    done = runs.run(["-options_file", str(HERE / f"{name}.opts"), "-link_stiffness", stiffness,
                     *words])
    if done.returncode:
        raise RunFailed(done.stderr.strip() or done.stdout.strip())


def pulled(folder: pathlib.Path, axis: str, links: float) -> tuple[float, float]:
    """Stress along the pull and across it, GPa, of the sheet at rest."""
    stage("strain", links, "-scene_file", f"{folder}/sheet.h5", f"-deform_{axis}", "rate",
          f"-deform_{axis}_rate", "1e-4", f"-deform_{axis}_until", str(STRAIN),
          "-state_output", f"{folder}/strained.h5")
    stage("rest", links, "-scene_file", f"{folder}/strained.h5",
          "-box_monitor", f"ascii:{folder}/box.csv", "-state_output", f"{folder}/rest.h5")
    box = tables.read(folder / "box.csv")
    stress = [600 / THICKNESS * float(box[name][-1]) for name in ("xx_GPa", "yy_GPa")]
    return (stress[0], stress[1]) if axis == "x" else (stress[1], stress[0])


def row(folder: pathlib.Path, how: Sheet, seeds: int) -> Array:
    apartness, found = [], []
    for seed in range(1, seeds + 1):
        apartness.append(sheet(folder / "sheet.h5", how, seed))
        along, across = np.mean([pulled(folder, axis, how.links) for axis in "xy"], axis=0)
        ratio = across / along
        found.append((along * (1 - ratio**2) / STRAIN * THICKNESS * 0.1, ratio))
    error = np.std(found, axis=0)[1] / np.sqrt(max(1, seeds - 1))
    return np.array([how.share, how.angle, how.links, np.mean(apartness),
                     *np.mean(found, axis=0), error])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--shares", type=float, nargs="+", default=(0, 0.33, 0.67, 1))
    parser.add_argument("--angles", type=float, nargs="+", default=(0,))
    parser.add_argument("--apart", type=float, nargs="+", default=(40,))
    parser.add_argument("--links", type=float, nargs="+", default=(4,))
    parser.add_argument("--seeds", type=int, default=2)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    print("# share, angle, links, between links A, modulus N/m, Poisson's ratio, its error",
          flush=True)
    for how in itertools.product(options.apart, options.shares, options.angles, options.links):
        found = row(options.folder.resolve(), Sheet(*how), options.seeds)
        print("{:5.2f} {:5.2f} {:6.2f} {:6.1f} {:8.2f} {:7.3f} {:6.3f}".format(*found), flush=True)


if __name__ == "__main__":
    command(main)
