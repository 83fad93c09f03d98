#!/usr/bin/python3
"""What settings cost in a dense bundle: user time a step, runs interleaved, one thread.

    tests/bench/dense.py [ROUNDS]     the bundle of the bench page, two minutes for 4 rounds
"""
from __future__ import annotations

import pathlib
import resource
import statistics
import sys
import tempfile

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from nanoweft import generators, runs  # noqa: E402
from nanoweft.problems import RunFailed, command  # noqa: E402

USUAL = "-pair_switch 40.68 -pair_cutoff 54.24"
SETTINGS = {
    "default": "",
    "-pair_accuracy 0.1, usual range": f"-pair_accuracy 0.1 {USUAL}",
    "-pair_accuracy 0.1": "-pair_accuracy 0.1",
    "-pair_accuracy 0.05": "-pair_accuracy 0.05",
    "five points, one beyond 26.5 A": "-pair_points 5 -pair_far_points 1 -pair_far_from 26.5"
                                      " -pair_switch 27.12 -pair_cutoff 33.9"
                                      " -pair_precision single"}
START, STEPS = 20, 300  # steps before, and those that count


def bundle(file: pathlib.Path) -> None:
    """127 endless tubes of 100 segments, slightly disordered."""
    random = np.random.default_rng(1)
    places = generators.hexagon(17.07, 6)
    places = places + 0.05 * random.standard_normal((len(places), 2))
    generators.endless_tubes(file, places, generators.LENGTH * random.random(len(places)),
                             generators.Endless(generators.LENGTH, 100, 0.02))


def user_seconds(file: pathlib.Path, setting: str, steps: int) -> float:
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = runs.run(["-scene", "file", "-scene_file", str(file), *setting.split(),
                     "-monitor_interval", "1000000",
                     "-ts_max_steps", str(steps)])
    if done.returncode:
        raise RunFailed(done.stderr.strip())
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def main() -> None:
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 4
    found: dict[str, list[float]] = {name: [] for name in SETTINGS}
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "bundle.h5"
        bundle(file)
        for _ in range(rounds):
            for name, setting in SETTINGS.items():
                seconds = (user_seconds(file, setting, START + STEPS)
                           - user_seconds(file, setting, START))
                found[name].append(1e3 * seconds / STEPS)
    print("| | ms a step | to default |\n|---|---|---|")
    for name, times in found.items():
        ratio = statistics.median(t / d for t, d in zip(times, found["default"]))
        print(f"| {name} | {statistics.median(times):.1f} | {ratio:.2f} |")


command(main)
