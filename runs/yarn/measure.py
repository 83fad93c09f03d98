#!/usr/bin/python3
"""Strength of yarns against their twist: measure.py [PICTURE]"""
import argparse
import pathlib
import sys
import tempfile

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "scripts"))
from nanoweft import generators, problems, runs, tables  # noqa: E402
from nanoweft.pictures import curve  # noqa: E402

TURNS = (0, 3, 4, 5, 5.5, 6, 7, 8)


def pulled(turns: float, folder: str) -> tuple[float, float, float]:
    """Mean angle of the fibres with the yarn, rad; strength, MPa; broken bonds."""
    yarn = generators.Yarn(turns)
    generators.yarn(f"{folder}/start.h5", yarn)
    done = runs.run(["-options_file", str(HERE / "twisted.opts"), "-scene_file",
                     f"{folder}/start.h5", "-stress_monitor", f"ascii:{folder}/stress.csv",
                     "-state_output", f"{folder}/out.h5"])
    if done.returncode:
        raise problems.RunFailed(done.stderr)
    # The jerk at the start is over at 1 % of strain; means over 0.5 % leave out waves.
    table = tables.read(f"{folder}/stress.csv")
    bins = np.arange(0.01, table["strain"][-1] - 0.004, 0.005)
    stress = [table["stress_left_GPa"][np.abs(table["strain"] - a - 0.0025) < 0.0025].mean()
              for a in bins]
    chords = np.diff(yarn.strands(), axis=1)
    return (float(np.arccos(np.abs(chords[..., 0]) / 2).mean()), 1e3 * max(stress),
            table["broken_bonds"][-1])


def main() -> None:
    parser = argparse.ArgumentParser(prog="measure.py", description=__doc__)
    parser.add_argument("picture", metavar="PICTURE", nargs="?")
    picture = parser.parse_args().picture
    with tempfile.TemporaryDirectory() as folder:
        rows = np.array([pulled(turns, folder) for turns in TURNS])
    print("| turns | angle, degrees | strength, MPa | broken bonds |\n|---|---|---|---|")
    for turns, (angle, strength, broken) in zip(TURNS, rows):
        print(f"| {turns} | {np.degrees(angle):.1f} | {strength:.3g} | {broken:g} |")
    square, slides = rows[:, 0]**2, (rows[:, 2] == 0) & (rows[:, 0] > 0)
    fit = np.polyfit(square[slides], np.log(rows[slides, 1]), 1)
    print(f"where fibres slide and none breaks: strength ~ exp({fit[0]:.3g} angle^2)")
    if picture:
        line = np.linspace(0, square[slides].max(), 50)
        curve.draw(picture, ("mean angle of the fibres squared, rad^2", "strength, MPa"),
                   [curve.Curve("yarn", (line, np.exp(np.polyval(fit, line))),
                                (square, rows[:, 1]), "exponential")], yscale="log")


problems.command(main)
