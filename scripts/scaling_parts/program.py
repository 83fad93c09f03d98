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


def _events(text):
    """Seconds of the solver's own log events, and rebuilds of the lists."""
    rows = re.findall(r"^(Nw\w+)\s+(\d+) [\d.]+ ([\d.e+-]+)", text, re.M)
    return {name: float(seconds) for name, _, seconds in rows}, {name: int(count) for name, count, _ in rows}["NwRebuild"]


def measure(pairs_per_segment, skin, rounds):
    """Costs of the kernels on one rank and of messages between two, medians over the rounds."""
    fibres, segments, few, steps = 60, 300, 20, 200
    total = 2 * fibres * segments
    seen = []
    for _ in range(rounds):
        # What a start costs is in both.
        (begin, begun), (all_steps, rebuilds) = (
            _events(nanoweft(1, fibres, segments, skin, n, "-log_view")) for n in (few, steps))
        a_step = {name: (all_steps[name] - begin[name]) / (steps - few) for name in all_steps}
        motion = a_step["NwKickDrift"] + a_step["NwKick"] + a_step["NwBonds"]
        lists = a_step["NwRebuild"] * (steps - few) / max(1, rebuilds - begun)
        net = re.search(r"latency (\S+) ghost (\S+)", mpirun(2, pathlib.Path(__file__).with_name("network.py")))
        seen.append([1e9 * a_step["NwPairs"] / (total * pairs_per_segment), 1e9 * motion / total, 1e9 * lists / total,
                     (steps - few) / max(1, rebuilds - begun), float(net[2]), float(net[1])])
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
