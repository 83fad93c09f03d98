"""Runs of the solver: what a pair, a segment and a list cost, and what real ranks print."""

from __future__ import annotations

import pathlib
import re
from typing import Any

import numpy as np

from ..problems import RunFailed
from ..runs import PROGRAM, Launch, Printed

RELAX = "-damping_local 0.4 -progress_interval 0 -ts_limit_interval 0"


def mpirun(ranks: int, *words: str | pathlib.Path) -> str:
    done = Launch(ranks)(words)
    if done.returncode:
        raise RunFailed(f"{' '.join(map(str, words))}: {done.stdout[-300:]}{done.stderr[-600:]}")
    return done.stdout


def nanoweft(ranks: int, weave: tuple[int, int], skin: float, steps: int,
             more: str = "") -> Printed:
    """`weave`: fibres each way, segments of a fibre."""
    fibres, segments = weave
    options = (f"-weave_fibres {fibres},{fibres} -weave_segments {segments} -pair_points 3 "
               f"-pair_skin {skin} -ts_max_steps {steps} {RELAX} {more}")
    return Printed(mpirun(ranks, PROGRAM, *options.split()))


def measure(pairs_per_segment: float, skin: float, rounds: int) -> dict[str, float]:
    """Costs of the kernels on one rank and of messages between two, medians over the rounds."""
    fibres, segments, few, steps = 60, 300, 20, 200
    total = 2 * fibres * segments
    seen = []
    for _ in range(rounds):
        # What a start costs is in both.
        begin, whole = (nanoweft(1, (fibres, segments), skin, n, "-log_view").events
                        for n in (few, steps))
        a_step = {name: (whole[name][1] - begin[name][1]) / (steps - few) for name in whole}
        rebuilds, begun = whole["NwRebuild"][0], begin["NwRebuild"][0]
        motion = a_step["NwKickDrift"] + a_step["NwKick"] + a_step["NwBonds"]
        lists = a_step["NwRebuild"] * (steps - few) / max(1, rebuilds - begun)
        said = mpirun(2, pathlib.Path(__file__).with_name("network.py"))
        net = re.search(r"latency (\S+) ghost (\S+)", said)
        assert net, said
        seen.append([1e9 * a_step["NwPairs"] / (total * pairs_per_segment),
                     1e9 * motion / total, 1e9 * lists / total,
                     (steps - few) / max(1, rebuilds - begun), float(net[2]), float(net[1])])
    names = ["pair", "segment", "list", "interval", "ghost", "latency"]
    return dict(zip(names, np.median(seen, 0)))


def printed(ranks: int, weave: tuple[int, int], skin: float, kind: str,
            piece: int) -> dict[str, Any]:
    """What the summary says of the partition and the time of a step; None where it does not."""
    name, _, length = kind.partition(":")
    options = (f"-partition {name}"
               + (f" -partition_piece {length or piece}" if name == "metis" else ""))
    speed = [nanoweft(ranks, weave, skin, 100, options).segment_steps for _ in range(3)]
    said = nanoweft(ranks, weave, skin, 1, options)
    found = {"imbalance": said.number(r"imbalance ([\d.]+), peak memory") if ranks == 1 else None,
             "ghosts": None, "bonds": None, "ms": 2e3 * weave[0] * weave[1] / np.median(speed)}
    if said.partition:
        found |= {"imbalance": float(said.partition["imbalance"]),
                  "ghosts": float(said.partition["ghosts"]),
                  "bonds": int(said.partition["bonds"])}
    return found
