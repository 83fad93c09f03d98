#!/usr/bin/python3
"""How far a relaxation has come, from its energy monitor and its states; see relaxation.md.

usage: tests/bench/relaxation.py energy.csv [state.h5 ...]
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
from nanoweft import states, tables  # noqa: E402

# A: two centres of tubes that touch (17.1 A) lie at most half a segment apart along them
NEAR = 22.0


def print_energies(file):
    table = tables.read(file)
    marks = [s for s in (0, 1000, 2000, 5000, 10000, 15000, 20000, 30000, 40000)]
    print(f"{file}\n  step, elastic, pair, elastic + pair, kinetic (eV)")
    for k, step in enumerate(table["step"]):
        if int(step) in marks or k == len(table) - 1:
            elastic, pair = table.elastic[k], table["pair"][k]
            print(f"  {int(step)}, {elastic:.1f}, {pair:.1f}, {elastic + pair:.1f}, "
                  f"{table.motion[k]:.3g}")
    for part in (0.3, 0.1, 0.05, 0.03):
        below = np.flatnonzero(table.elastic <= part * table.elastic[0])
        step = int(table["step"][below[0]]) if len(below) else None
        print(f"  elastic energy below {part:g} of the start's at step {step}")
    drift = table.balance[-1] - table.balance[0]
    print(f"  energy balance drifted by {drift:.3g} of {table['damped'][-1]:.6g} eV damped")


def neighbours(file):
    """Mean number of other fibres beside a segment, and the share of segments with 3 or more."""
    state = states.read(file)
    x, fibre = state["position"], state["fibre"]
    box = np.where(state.periodic, state.box, np.inf)
    counts = np.zeros(len(x), int)
    for i in range(len(x)):
        d = x - x[i]
        d -= np.where(np.isfinite(box), box, 0) * np.where(np.isfinite(box), np.round(d / box), 0)
        near = fibre[(d * d).sum(axis=1) < NEAR * NEAR]
        counts[i] = len(np.unique(near)) - 1
    return counts.mean(), (counts >= 3).mean()


print_energies(sys.argv[1])
for state in sys.argv[2:]:
    mean, bundled = neighbours(state)
    print(f"  {state}: {mean:.2f} fibres beside a segment, "
          f"{100 * bundled:.0f} % of segments beside 3 or more")
