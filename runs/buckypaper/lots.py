#!/usr/bin/python3
"""Further lots of pressed tubes; their moduli and those of the scene's own lot, mean and standard
error: lots.py FOLDER [--help], where FOLDER is results/buckypaper after scripts/run."""
from __future__ import annotations

import argparse
import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "scripts"))
from nanoweft import runs  # noqa: E402
from nanoweft.arguments import count  # noqa: E402
from nanoweft.problems import RunFailed, command  # noqa: E402
from nanoweft.published import buckypaper  # noqa: E402


def stage(name: str, *words: str) -> None:
    done = runs.run(["-options_file", str(HERE / f"{name}.opts"), *words])
    if done.returncode:
        raise RunFailed(done.stderr.strip() or done.stdout.strip())


def press(lot: pathlib.Path, seed: int) -> None:
    """Leaves the table of the box in the folder of a lot."""
    lot.mkdir(parents=True, exist_ok=True)
    buckypaper.start(lot / "start.h5", seed)
    stage("part", "-scene_file", f"{lot}/start.h5", "-state_output", f"{lot}/parted.h5")
    stage("press", "-scene_file", f"{lot}/parted.h5", "-state_output", f"{lot}/pressed.h5",
          "-box_monitor", f"ascii:{lot}/box.csv", "-energy_monitor", f"ascii:{lot}/energy.csv",
          "-snapshot_file", f"{lot}/press")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--lots", type=count, default=8, metavar="N",
                        help="of all, with the scene's own (default: %(default)s)")
    options = parser.parse_args()
    folder = options.folder.resolve()
    for seed in range(2, options.lots + 1):
        press(folder / "lots" / str(seed), seed)
    subprocess.run([HERE / "after", folder], check=True)


if __name__ == "__main__":
    command(main)
