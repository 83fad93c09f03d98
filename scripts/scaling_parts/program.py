"""Runs of the solver: what a pair, a segment and a list cost, and what real ranks print."""

import pathlib
import re
import subprocess

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
BINARY = ROOT / "build" / "bin" / "nanoweft"
RELAX = "-damping_local 0.4 -progress_interval 0 -ts_limit_interval 0"


def mpirun(ranks, words):
    command = f". {ROOT}/scripts/environment; OMP_NUM_THREADS=1 mpirun -n {ranks} {words}"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"scaling: {words}: {done.stdout[-300:]}{done.stderr[-600:]}")
    return done.stdout


def nanoweft(ranks, fibres, segments, skin, steps, more=""):
    return mpirun(ranks, f"{BINARY} -weave_fibres {fibres},{fibres} -weave_segments {segments} "
                         f"-pair_skin {skin} -ts_max_steps {steps} {RELAX} {more}")


def _event(text, name):
    count, seconds = re.search(rf"^{name}\s+(\d+) [\d.]+ ([\d.e+-]+)", text, re.M).groups()
    return int(count), float(seconds)


def measure(pairs_per_segment, skin, rounds):
    """Costs of the kernels on one rank and of messages between two, medians over the rounds."""
    fibres, segments, steps = 60, 300, 200
    total = 2 * fibres * segments
    seen = []
    for _ in range(rounds):
        text = nanoweft(1, fibres, segments, skin, steps, "-log_view")
        evaluations, bonds = _event(text, "NwBonds")  # the estimate of the stable step has some too
        drifts, motion = _event(text, "NwKickDrift")
        rebuilds, lists = _event(text, "NwRebuild")
        pairs = _event(text, "NwPairs")[1] / evaluations / (total * pairs_per_segment)
        both = _event(text, "NwKick")[1] / drifts + motion / drifts + bonds / evaluations
        net = re.search(r"latency (\S+) ghost (\S+)", mpirun(2, pathlib.Path(__file__).with_name("network.py")))
        seen.append([1e9 * pairs, 1e9 * both / total, 1e9 * lists / rebuilds / total,
                     steps / max(1, rebuilds - 1), float(net[2]), float(net[1])])
    names = ["pair", "segment", "list", "interval", "ghost", "latency"]
    return dict(zip(names, np.median(seen, 0)))


def printed(ranks, fibres, segments, skin, kind, piece):
    """What the summary says of the partition and the time of a step; None where it does not."""
    name, _, length = kind.partition(":")
    options = f"-partition {name}" + (f" -partition_piece {length or piece}" if name == "metis" else "")

    def run(steps):
        return nanoweft(ranks, fibres, segments, skin, steps, options)

    speed = [float(re.search(r"speed: (\S+) segment", run(100))[1]) for _ in range(3)]
    text = run(1)
    found = {"imbalance": float(re.search(r"imbalance ([\d.]+), peak memory", text)[1]) if ranks == 1 else None,
             "ghosts": None, "bonds": None, "ms": 2e3 * fibres * segments / np.median(speed)}
    line = re.search(r"partition: .*imbalance of work ([\d.]+), ([\d.]+) ghosts a segment, (\d+) bonds cut", text)
    if line:
        found |= {"imbalance": float(line[1]), "ghosts": float(line[2]), "bonds": int(line[3])}
    return found
