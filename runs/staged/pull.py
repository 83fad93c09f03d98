#!/usr/bin/python3
"""Pulls the weave in stages, each stretched a little further and brought to rest by FIRE between
two held ends; called by scripts/run with the results folder."""
import argparse
import pathlib
import shutil
import sys

import h5py
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from nanoweft import options, problems, runs, states, tables  # noqa: E402
from nanoweft.pictures import curve  # noqa: E402

GRIP, STEP, STAGES = 40.0, 0.005, 16  # A; strain of a stage
LEFT, RIGHT = 1, 2  # bits 0 and 1 of /state/group
OPTIONS = ["-bc", "left,right", "-left_group", "0", "-right_group", "1", "-left_fix", "1,1,1",
           "-right_fix", "1,1,1", "-relax_method", "fire", "-relax_force", "1e-3",
           "-ts_max_steps", "40000"]


def mark_ends(file: pathlib.Path) -> float:
    """Makes groups of the piece's two ends; their distance, A."""
    with h5py.File(file, "r+") as opened:
        x = opened["state/position"][:, 0]
        left, right = x < x.min() + GRIP, x > x.max() - GRIP
        opened["state/group"][...] = LEFT * left + RIGHT * right
        return float(x[right].min() - x[left].max())


def stretch(file: pathlib.Path, way: float) -> None:
    """Moves the right end by `way`, A, and what lies between the ends in proportion."""
    with h5py.File(file, "r+") as opened:
        x, group = opened["state/position"][:, 0], opened["state/group"][()]
        begin, end = x[group == LEFT].max(), x[group == RIGHT].min()
        opened["state/position"][:, 0] = x + way * np.clip((x - begin) / (end - begin), 0, 1)


def pulled(results: pathlib.Path) -> tuple[float, np.ndarray]:
    """First distance of the ends, A; force, eV/A, energy, eV, and steps of each stage."""
    start, rest, rows = results / "start.h5", results / "rest.h5", []
    shutil.copy(results / "relaxed.h5", start)
    # The fibres and links are those that were tied.
    given = options.parse(str(states.read(start).run.get("options", "")))
    more = options.words({name: value for name, value in given.items() if not name.startswith(
        ("scene", "weave_", "links_", "relax_", "ts_", "bc", "left_", "right_"))})
    length = mark_ends(start)
    for stage in range(STAGES + 1):
        if stage:
            shutil.copy(rest, start)
            stretch(start, STEP * length)
        done = runs.run(["-scene", "file", "-scene_file", str(start), "-scene_file_edited",
                         *more, *OPTIONS, "-group_monitor", f"ascii:{results}/groups.csv",
                         "-energy_monitor", f"ascii:{results}/stage.csv",
                         "-state_output", str(rest)])
        if done.returncode:
            raise problems.RunFailed(done.stderr)
        groups, energy = tables.read(results / "groups.csv"), tables.read(results / "stage.csv")
        rows.append((groups["right_force_x"][-1], energy["total"][-1], energy["step"][-1]))
    return length, np.array(rows)


def main(results: pathlib.Path) -> None:
    length, rows = pulled(results)
    strain = STEP * np.arange(STAGES + 1)
    print("| strain | force, eV/A | energy gained, eV | steps to rest |\n|---|---|---|---|")
    for e, (force, energy, steps) in zip(strain, rows):
        print(f"| {e:.3f} | {force:.2f} | {energy - rows[0, 1]:.1f} | {steps:.0f} |")
    slope = np.diff(rows[:, 1]) / (STEP * length)
    mean = (rows[1:, 0] + rows[:-1, 0]) / 2
    print("mean force of two stages over the slope of the energy, "
          f"worst: {max(abs(mean / slope - 1)):.1e}")
    curve.draw(str(results / "force.png"), ("strain", "force on an end, eV/A"),
               [curve.Curve("at rest", ((strain[1:] + strain[:-1]) / 2, slope),
                            (strain, rows[:, 0]), "slope of the energy")])


def folder() -> pathlib.Path:
    parser = argparse.ArgumentParser(prog="pull.py", description=__doc__)
    parser.add_argument("results", metavar="FOLDER", type=pathlib.Path)
    return parser.parse_args().results


problems.command(lambda: main(folder()))
