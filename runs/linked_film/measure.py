#!/usr/bin/python3
"""Modulus and strength of films over the number of links a tube has: measure.py FOLDER

Prints a row for each film: segments of a tube, links a tube (each counts for both its tubes),
modulus and largest stress in GPa of a film as thick as its layers, strain at that stress."""
from __future__ import annotations

import argparse
import pathlib
import sys

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "scripts"))
from nanoweft import runs, states, tables  # noqa: E402
from nanoweft.generators import LENGTH  # noqa: E402
from nanoweft.problems import RunFailed, command  # noqa: E402
from nanoweft.runs import Printed  # noqa: E402

LAYERS, GAP = 8, 17.3436
STRAIN = 0.002
# By the segments of a tube: edge of the film in A, share of a layer that tubes cover, links a tube.
FILMS = {40: (1000, 0.125, (3.5, 4.5, 6)), 80: (1500, 0.11, (5, 8, 11))}
WIDE = 0.002                # strain over which the stress of a pull is averaged
BEGUN = 0.005               # strain up to which inertia of the start is in the stress


def stage(name: str, *words: str) -> str:
    done = runs.run(["-options_file", str(HERE / f"{name}.opts"), *words])
    if done.returncode:
        raise RunFailed(done.stderr.strip() or done.stdout.strip())
    return done.stdout


def strongest(table: str | pathlib.Path) -> tuple[float, float]:
    """The largest stress of a pull once it is under way, GPa, and the strain there."""
    box = tables.read(table)
    rows = max(1, int(np.searchsorted(box["strain_x"], WIDE)))
    stress, strain = (np.convolve(box[name], np.full(rows, 1 / rows), "valid")
                      for name in ("xx_GPa", "strain_x"))
    peak = int(np.argmax(np.where(strain > BEGUN, stress, 0)))
    return float(stress[peak]), float(strain[peak])


def film(folder: pathlib.Path, segments: int, links: float, seed: int) -> tuple[float, ...]:
    """Links a tube, modulus, strength, strain at the largest stress."""
    (side, covered, _), name = FILMS[segments], f"{folder}/{segments}_{links:g}_{seed}"
    text = stage("link", "-film_size", f"{side},{side}", "-film_segments", str(segments),
                 "-film_coverage", str(LAYERS * covered), "-seed", str(seed),
                 "-links_density", str(links / (2 * segments * LENGTH)),
                 "-state_output", f"{name}.h5")
    fibres, made = (Printed(text).number(pattern) for pattern in (r"(\d+) fibres", r"(\d+) links"))
    thickness = ["-deform_thickness", str(LAYERS * GAP)]
    stage("strain", "-scene_file", f"{name}.h5", *thickness, "-state_output", f"{name}_strained.h5")
    stage("rest", "-scene_file", f"{name}_strained.h5", "-box_monitor", f"ascii:{name}_rest.csv",
          "-state_output", f"{name}_rest.h5")
    # A box that is held tells the stress over its own height.
    height = states.read(f"{name}_rest.h5").box[2] / (LAYERS * GAP)
    stress = height * float(tables.read(f"{name}_rest.csv")["xx_GPa"][-1])
    stage("pull", "-scene_file", f"{name}.h5", *thickness, "-box_monitor", f"ascii:{name}.csv",
          "-state_output", f"{name}_pulled.h5")
    return (2 * made / fibres, stress / STRAIN, *strongest(f"{name}.csv"))


def main() -> None:
    parser = argparse.ArgumentParser(prog="measure.py", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="FOLDER", type=pathlib.Path)
    folder = parser.parse_args().folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    print("# segments, links a tube, modulus GPa, strength GPa, strain at it", flush=True)
    for segments, (*_, numbers) in FILMS.items():
        for links in numbers:
            for seed in (1, 2):
                print("{:3d} {:7.2f} {:8.3f} {:8.4f} {:7.4f}".format(
                    segments, *film(folder, segments, links, seed)), flush=True)


if __name__ == "__main__":
    command(main)
