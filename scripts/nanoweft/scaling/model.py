"""Time of a step from what each rank has to do.

    local    = segments x motion + bonds, packing included in the figure for a ghost
    halo     = messages x latency + ghosts x time of a ghost         (travels while inner pairs run)
    step     = max over ranks [ local + inner pairs + max(0, halo - hidden x inner pairs)
                                + outer pairs + rebuild ] + allreduce
    rebuild  = (segments and ghosts x time of a list) / steps between rebuilds
    allreduce = log2(ranks) x latency, and a share of those that a rebuild needs
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

    HELP: ClassVar = {"pair": "ns per pair of the list",
                      "segment": "ns per segment for motion and bonds",
            "list": "ns per segment and ghost for a rebuild of the lists",
            "interval": "steps between rebuilds of the lists", "ghost": "ns per ghost",
            "latency": "ns per message",
                      "hidden": "fraction of the inner pairs that can hide the halo",
            "collectives": "collective calls of a rebuild"}

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


def step(loads, costs, ranks=None):
    """Seconds of one step;
    `ranks`: of the whole machine, when `loads` holds a sample of its ranks."""
    ranks = ranks or loads.ranks
    local = costs.segment * loads.owned
    inner = costs.pair * loads.inner
    halo = costs.latency * loads.messages + costs.ghost * np.maximum(loads.ghosts, loads.sent)
    left = np.maximum(0.0, halo - costs.hidden * inner)
    lists = costs.list * (loads.owned + loads.ghosts) / costs.interval
    busy = local + inner + left + costs.pair * loads.outer + lists
    rounds = np.ceil(np.log2(ranks)) * (1 + costs.collectives / costs.interval)
    return 1e-9 * (busy.max() + costs.latency * rounds)


def serial(segments, pairs, costs):
    """Seconds of a step on one rank."""
    return 1e-9 * (segments * (costs.segment + costs.list / costs.interval) + pairs * costs.pair)
