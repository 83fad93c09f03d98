#!/usr/bin/python3
"""Stiffness of pieces between grips, periodic across, beside that of the periodic box, for growing
sizes: sizes.py [PICTURE]"""
import argparse
import pathlib
import sys
import tempfile

import h5py
import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "scripts"))
from nanoweft import problems, runs, tables  # noqa: E402
from nanoweft.pictures import curve  # noqa: E402

SIZES = (6, 8, 12, 16, 24)  # tubes in each direction
SEGMENTS = 7                    # of a pitch
PITCH = SEGMENTS * 13.56        # A, before it comes to rest


def run(*options: str) -> None:
    done = runs.run(options)
    if done.returncode:
        raise problems.RunFailed(done.stderr)


def slope(strain: np.ndarray, stress: np.ndarray) -> float:
    """At 0.5 %, of a parabola from 0.2 to 0.8 %: the jerk at the start is over then."""
    late = (strain > 0.002) & (strain < 0.008)
    return float(np.polyval(np.polyder(np.polyfit(strain[late], stress[late], 2)), 0.005))


def at_rest(folder: str, size: int) -> None:
    run("-options_file", str(HERE / "weave.opts"), "-weave_fibres", f"{size},{size}",
        "-weave_segments", str(SEGMENTS * size), "-box_monitor", f"ascii:{folder}/rest.csv",
        "-state_output", f"{folder}/rest.h5")


def periodic(folder: str) -> float:
    run("-options_file", str(HERE / "pull.opts"), "-scene_file", f"{folder}/rest.h5", "-deform_y",
        "held", "-box_monitor", f"ascii:{folder}/box.csv", "-energy_monitor",
        f"ascii:{folder}/energy.csv", "-state_output", f"{folder}/pulled.h5")
    box = tables.read(f"{folder}/box.csv")
    return slope(box["strain_x"] - box["strain_x"][0], box["xx_GPa"])


def between_grips(folder: str, size: int) -> float:
    """The same piece, its fibres along x cut at the boundary."""
    with h5py.File(f"{folder}/rest.h5", "r+") as file:
        state = file["state"]
        width = float(state.attrs["upper"][1] - state.attrs["lower"][1])
        # The first half of the fibres runs along x.
        closed = state["fibre_closed"][()]
        del state["fibre_closed"]
        state["fibre_closed"] = closed[closed >= size]
    run("-options_file", str(HERE / "grips.opts"), "-scene_file", f"{folder}/rest.h5",
        "-scene_file_edited", "-domain_periodic", "0,1,0", "-tension_width", str(width),
        "-stress_monitor", f"ascii:{folder}/grips.csv", "-state_output", f"{folder}/torn.h5")
    table = tables.read(f"{folder}/grips.csv")
    return slope(table["strain"], 0.5 * (table["stress_left_GPa"] + table["stress_right_GPa"]))


def main() -> None:
    parser = argparse.ArgumentParser(prog="sizes.py", description=__doc__)
    parser.add_argument("picture", metavar="PICTURE", nargs="?")
    picture = parser.parse_args().picture
    rows = []
    print("| tubes | periodic, GPa | between grips, GPa | over it |\n|---|---|---|---|", flush=True)
    for size in SIZES:
        with tempfile.TemporaryDirectory() as folder:
            at_rest(folder, size)
            rows.append((periodic(folder), between_grips(folder, size)))
        box, grips = rows[-1]
        print(f"| {size} x {size} | {box:.2f} | {grips:.2f} | {grips / box:.4f} |", flush=True)
    share, inverse = np.array(rows)[:, 1] / np.array(rows)[:, 0], 1 / (np.array(SIZES) - 2)
    fit = np.polyfit(inverse[1:], share[1:], 1)
    print(f"share of the periodic modulus in the limit of size: {fit[1]:.4f}")
    if picture:
        line = np.linspace(0, inverse[0], 20)
        curve.draw(picture, ("1/(tubes - 2), the pitches between the grips",
                             "modulus between grips over that of the box"),
                   [curve.Curve("pieces", (line, np.polyval(fit, line)), (inverse, share), "fit")])


problems.command(main)
