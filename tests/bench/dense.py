#!/usr/bin/python3
"""What settings cost in a dense bundle, how two cores share it, and the paper's weave just let go.

    tests/bench/dense.py              the tables of the bench page, five minutes for 3 rounds
    tests/bench/dense.py --beside OLD/build/bin/nanoweft    another program in them

Runs are interleaved; medians, and medians of the rounds' ratios to the default."""
from __future__ import annotations

import argparse
import pathlib
import resource
import statistics
import sys
import tempfile
from collections.abc import Callable
from functools import partial

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from nanoweft import generators  # noqa: E402
from nanoweft.problems import RunFailed, command  # noqa: E402
from nanoweft.runs import PROGRAM, Launch, Printed  # noqa: E402

USUAL = "-pair_switch 40.68 -pair_cutoff 54.24"
DEFAULT, BESIDE = "default", "the other program"
SETTINGS = {
    DEFAULT: "",
    "-pair_accuracy 0.1, usual range": f"-pair_accuracy 0.1 {USUAL}",
    "-pair_accuracy 0.1": "-pair_accuracy 0.1",
    "-pair_accuracy 0.05": "-pair_accuracy 0.05",
    "five points, one beyond 26.5 A, to 35 A":
        "-pair_points 5 -pair_far_points 1 -pair_far_from 26.5 -pair_switch 27.12 -pair_cutoff 35"
        " -pair_precision single"}
WEAVE = "-weave_fibres 200,200 -weave_segments 1000 -damping_local 0.4"
SHARED = {"1 rank x 1 thread": Launch(None, 1), "1 rank x 2 threads": Launch(None, 2),
          "2 ranks x 1 thread": Launch(2, 1, ["--bind-to", "none"])}
START, STEPS, WEAVE_STEPS = 20, 300, 100  # first steps do not count
Measure = Callable[[], float]


def bundle(file: pathlib.Path) -> None:
    """127 endless tubes of 100 segments, slightly disordered."""
    random = np.random.default_rng(1)
    places = generators.hexagon(17.07, 6)
    places = places + 0.05 * random.standard_normal((len(places), 2))
    generators.endless_tubes(file, places, generators.LENGTH * random.random(len(places)),
                             generators.Endless(generators.LENGTH, 100, 0.02))


def run(program: pathlib.Path, options: str, steps: int, launch: Launch) -> str:
    """What a run prints."""
    done = launch([program, *options.split(), "-monitor_interval", "1000000", "-ts_max_steps",
                   str(steps), "-progress_interval", "0"])
    if done.returncode:
        raise RunFailed(done.stderr.strip())
    return done.stdout


def user_time(program: pathlib.Path, options: str) -> float:
    """Milliseconds of processor time a step, on one thread."""
    def seconds(steps: int) -> float:
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        run(program, options, steps, Launch())
        return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    return 1e3 * (seconds(START + STEPS) - seconds(START)) / STEPS


def wall_time(program: pathlib.Path, options: str, steps: int, launch: Launch) -> float:
    """Milliseconds a step, by what the run says of its speed."""
    said = Printed(run(program, options, steps, launch))
    return 1e3 * said.segments / said.segment_steps


def table(title: str, measures: dict[str, Measure], rounds: int, to: str) -> None:
    """Prints the medians of each measure, and of its ratios to that named `to`."""
    found: dict[str, list[float]] = {name: [] for name in measures}
    for _ in range(rounds):
        for name, measure in measures.items():
            found[name].append(measure())
    print(f"\n| {title} | ms a step | to {to} |\n|---|---|---|")
    for name, times in found.items():
        ratio = statistics.median(t / d for t, d in zip(times, found[to]))
        print(f"| {name} | {statistics.median(times):.1f} | {ratio:.2f} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(prog="dense.py", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--beside", type=pathlib.Path, metavar="PROGRAM",
                        help="another program, which runs with what it takes for its default")
    arguments = parser.parse_args()
    programs = {BESIDE: arguments.beside.resolve()} if arguments.beside else {}

    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "bundle.h5"
        bundle(file)
        scene = f"-scene file -scene_file {file}"
        one: dict[str, Measure] = {name: partial(user_time, PROGRAM, f"{scene} {options}")
                                   for name, options in SETTINGS.items()}
        one |= {name: partial(user_time, program, scene) for name, program in programs.items()}
        table("bundle, one core, processor time", one, arguments.rounds, DEFAULT)
        table("bundle, default, wall time",
              {name: partial(wall_time, PROGRAM, scene, START + STEPS, launch)
               for name, launch in SHARED.items()}, arguments.rounds, next(iter(SHARED)))

    two = Launch(None, 2)
    weave: dict[str, Measure] = {
        name: partial(wall_time, PROGRAM, f"{WEAVE} {options}", WEAVE_STEPS, two)
        for name, options in ((DEFAULT, ""), ("-pair_accuracy 0.1", "-pair_accuracy 0.1"))}
    weave |= {name: partial(wall_time, program, WEAVE, WEAVE_STEPS, two)
              for name, program in programs.items()}
    table("weave just let go, two threads, wall time", weave, arguments.rounds, DEFAULT)


command(main)
