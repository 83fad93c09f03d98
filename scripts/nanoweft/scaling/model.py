"""Time of a step from what each rank has to do.

    local    = segments x motion + bonds, packing included in the figure for a ghost
    halo     = messages x latency + ghosts x time of a ghost        (positions travel while the
               first half of the inner pairs runs, sums on ghosts back while the second does)
    rebuild  = (segments and ghosts x time of a list) / steps between rebuilds
    agree    = log2(ranks) x latency
    notices  = log2(ranks) messages, each once the one before has arrived (travel while inner pairs
               run; a rank looks for them after each 256 segments' pairs)
    step     = max over ranks [ local + inner pairs + twice what half of them leaves of halo
                                + half of the outer pairs + rebuild ]
               + agree x (1 + 1 / steps between drawings
                          + collective calls of a rebuild / steps between rebuilds)
    late     = max over ranks [ the same, at first what is left of the longer of halo and notices ]
               + agree x collective calls of a rebuild / steps between rebuilds

The step is late from 128 ranks on, as the program's (-agreement). With fewer than 100 segments a
rank, each of two ranks resolves all of their common pairs, and no sums travel. What it costs to
foresee which pairs will be missing is left out.
"""

from dataclasses import dataclass, fields, replace
from typing import ClassVar

import numpy as np


@dataclass
class Costs:
    """Nanoseconds, but for counts and the fraction."""
    pair: float = 7.0           # a pair of the list, 3 points a segment
    segment: float = 42.0       # motion and bonds of a segment
    list: float = 230.0         # a segment in a rebuild of the lists
    interval: float = 36.0      # steps between rebuilds
    ghost: float = 17.0         # a ghost's 64 bytes, packing included
    latency: float = 1700.0     # a message
    hidden: float = 1.0         # fraction of the inner pairs' time that can hide the halo
    collectives: float = 25.0   # reductions and barriers of a rebuild
    drawing: float = 2.5        # steps between drawings of pairs

    HELP: ClassVar = {"pair": "ns per pair of the list",
                      "segment": "ns per segment for motion and bonds",
            "list": "ns per segment and ghost for a rebuild of the lists",
            "interval": "steps between rebuilds of the lists", "ghost": "ns per ghost",
            "latency": "ns per message",
                      "hidden": "fraction of the inner pairs that can hide the halo",
            "collectives": "collective calls of a rebuild",
                      "drawing": "steps between drawings of pairs"}

    def slower_network(self, latency=10.0, ghost=10.0):
        return replace(self, latency=self.latency * latency, ghost=self.ghost * ghost)

    @classmethod
    def add_options(cls, parser):
        for f in fields(cls):
            parser.add_argument(f"--{f.name}", type=float, default=f.default, metavar="X",
                                help=f"{cls.HELP[f.name]} (default: %(default)s)")

    @classmethod
    def given(cls, arguments):
        return cls(**{f.name: getattr(arguments, f.name) for f in fields(cls)})


# Segments of a chunk of pairs, after which a rank looks for messages (src/force/pair_draw.cpp).
CHUNK = 256
# Ranks from which on the step is late (-agreement).
LATE = 128
# Segments a rank from which on ranks share their pairs (src/force/pair_list.cpp).
LEAST = 100


def part_of(loads):
    """The part of its inner pairs that a rank computes first, and of its outer pairs that it
    computes at all."""
    return 0.5 if loads.owned.mean() >= LEAST else 1.0


def left_of_notices(loads, costs, rounds):
    """Nanoseconds for which a rank waits for what all ranks agree on, after the first part of its
    inner pairs."""
    if costs.latency == 0:
        return 0.0
    inner = costs.hidden * costs.pair * loads.inner
    hiding = part_of(loads) * inner
    chunk = inner * np.minimum(1.0, CHUNK / np.maximum(1, loads.owned))
    return costs.latency * np.maximum(0.0, rounds - hiding / np.maximum(costs.latency, chunk))


def step(loads, costs, ranks=None, late=None):
    """Seconds of one step;
    `ranks`: of the whole machine, when `loads` holds a sample of its ranks;
    `late`: do ranks hear of each other while they compute (None: as the program chooses)?"""
    ranks = ranks or loads.ranks
    late = ranks >= LATE if late is None else late
    local = costs.segment * loads.owned
    inner = costs.pair * loads.inner
    halo = costs.latency * loads.messages + costs.ghost * np.maximum(loads.ghosts, loads.sent)
    rounds = np.ceil(np.log2(ranks))
    part = part_of(loads)
    left = np.maximum(0.0, halo - part * costs.hidden * inner)
    back = left if part < 1 else 0.0
    asked = costs.collectives / costs.interval
    if late:
        left = np.maximum(left, left_of_notices(loads, costs, rounds))
    else:
        asked += 1 + 1 / costs.drawing
    lists = costs.list * (loads.owned + loads.ghosts) / costs.interval
    busy = local + inner + left + back + part * costs.pair * loads.outer + lists
    return 1e-9 * (busy.max() + costs.latency * rounds * asked)


def serial(segments, pairs, costs):
    """Seconds of a step on one rank."""
    return 1e-9 * (segments * (costs.segment + costs.list / costs.interval) + pairs * costs.pair)
