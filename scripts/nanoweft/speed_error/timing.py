"""What a setting costs: runs one at a time, interleaved with runs of the paper's setting.

A machine's speed wanders, so a cost is quoted as the ratio to a run of the paper's setting next to
it in time; the median over the rounds is taken.
"""

from dataclasses import dataclass

import numpy as np

from .independent import LENGTH
from .settings import PAPER


@dataclass
class Cost:
    nanoseconds: float  # a segment-step
    pairs_per_second: float
    ratio: float        # of a segment-step to one of the paper's setting
    spread: float       # of the ratio: half of largest less smallest
    limit: float        # estimated stable step of fibres pressed together


def work(options):
    """A guess of the work of a step, over that of the paper's setting."""
    if options.get("pair") == "none":
        return 0.1
    n = options.get("pair_points", 3)
    if "pair_far_points" in options:
        n = 0.5 * (n + options["pair_far_points"])
    return max(0.3, (n / 3)**2 * (options.get("pair_cutoff", 4 * LENGTH) / 4 / LENGTH)**3)


class Stopwatch:
    def __init__(self, program, rounds, seconds):
        self.program, self.rounds, self.seconds = program, rounds, seconds

    def once(self, scene, options, steps, *more):
        # Local damping as in the paper's relaxation keeps the scene near where it began.
        given = {"scene": "file", "scene_file": scene, "damping_local": 0.4, "ts_dt": 20.0}
        return self.program.run(given | options | {"ts_max_steps": steps}, *more)

    def costs(self, scene, cases, base=PAPER, paired=False):
        """Cost of every case (name -> options) on a scene; `paired`: the base before every case."""
        short = self.once(scene, base, 20)
        steps = self.seconds * 20 / short.wall
        count = {name: max(10, round(steps / work(options))) for name, options in cases.items()}
        # The solver's count of pairs includes the estimate of the stable step:
        # a run of one step has it.
        single = {name: self.once(scene, options, 1) for name, options in cases.items()}
        seen = {name: [] for name in cases}
        for _ in range(self.rounds):
            for k, (name, options) in enumerate(cases.items()):
                if paired or k % 2 == 0:
                    reference = self.once(scene, base, max(10, round(steps)))
                seen[name].append((self.once(scene, options, count[name]), reference))
        return {name: self.summary(seen[name], single[name]) for name in cases}

    @staticmethod
    def summary(seen, single):
        ratios = [b.segment_steps / a.segment_steps for a, b in seen]
        speed = np.median([a.segment_steps for a, _ in seen])
        pairs = np.median([(a.resolved - single.resolved) / (a.steps - 1) / a.segments
                           for a, _ in seen])
        return Cost(1e9 / speed, pairs * speed, float(np.median(ratios)),
                    0.5 * float(np.ptp(ratios)),
                    single.limits[2])
