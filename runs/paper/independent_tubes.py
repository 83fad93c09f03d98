#!/usr/bin/python3
"""The stress of a pulled fabric if its tubes did not know of each other.

Each tube that both grips hold is slack by (its length between the grips) / (their distance) - 1. It
bears nothing until the pull has straightened it, then its axial stiffness times the strain beyond,
until its weakest bond breaks. Takes the first snapshot of a tension test (its groups tell what the
grips hold) and prints the slack of the tubes and the strength over many draws of the critical
strains."""
import argparse
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from nanoweft import states  # noqa: E402
from nanoweft.problems import Unusable, command  # noqa: E402

STIFFNESS = 916.56  # of a (10,10) tube, B1 T, eV/A
LENGTH = 13.56  # of a segment, A
THICKNESS = 17.1  # of the fabric, A
GIGAPASCAL = 160.2177  # eV/A^3


def slack_tubes(path, axis):
    """Slack and number of bonds between the grips, of each tube that both hold."""
    state = states.read(path)
    x, fibre, group = state["position"][:, axis], state["fibre"], state["group"]
    found = []
    ends = np.flatnonzero(np.diff(fibre, prepend=-1, append=-1))
    for begin, end in zip(ends, ends[1:]):
        left, right = (np.flatnonzero(group[begin:end] >> bit & 1) for bit in (28, 29))
        if not len(left) or not len(right):
            continue
        if left[0] > right[0]:
            left, right = right, left
        a, b = left[-1], right[0]
        if b > a:
            found.append(((b - a) * LENGTH / abs(x[begin + b] - x[begin + a]) - 1, b - a))
    return np.array(found).reshape(-1, 2)


def strength(tubes, width, per, seed):
    """Largest stress, GPa, and its strain."""
    draw = np.random.default_rng(seed)
    critical = np.array([draw.normal(0.3, 0.05, int(n) if per == "bond" else 1).min()
                         for n in tubes[:, 1]])
    strain = np.linspace(0, 1.2, 1201)
    own = (1 + strain[:, None]) / (1 + tubes[:, 0]) - 1
    stress = np.where(own < critical, own.clip(0),
                      0).sum(1) * STIFFNESS / (width * THICKNESS) * GIGAPASCAL
    return stress.max(), strain[stress.argmax()]


def main():
    parser = argparse.ArgumentParser(prog="independent_tubes", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("state", metavar="SNAPSHOT.h5")
    parser.add_argument("--width", type=float, required=True,
                        help="of the fabric, A, as in the run's header")
    parser.add_argument("--slack", type=float, default=1.0, metavar="FACTOR",
                        help="what if every tube were so many times as slack (default: 1)")
    parser.add_argument("--axis", choices="xyz", default="x")
    arguments = parser.parse_args()
    tubes = slack_tubes(arguments.state, "xyz".index(arguments.axis))
    if not len(tubes):
        raise Unusable(f"{arguments.state}: no tube is held by both grips")
    tubes[:, 0] *= arguments.slack
    shares = np.percentile(100 * tubes[:, 0], [0, 10, 50, 90, 100])
    print(f"{len(tubes)} tubes, slack in %: least {shares[0]:.1f}, tenth {shares[1]:.1f}, "
          f"median {shares[2]:.1f}, nine tenths {shares[3]:.1f}, most {shares[4]:.1f}; "
          f"bonds between the grips: {np.median(tubes[:, 1]):.0f}")
    for per in ("bond", "fibre"):
        draws = np.array([strength(tubes, arguments.width, per, seed) for seed in range(200)])
        (mean, at), (deviation, _) = draws.mean(0), draws.std(0)
        print(f"a critical strain per {per}: strength {mean:.1f} +- {deviation:.1f} GPa "
              f"at {100 * at:.0f} %")


command(main)
