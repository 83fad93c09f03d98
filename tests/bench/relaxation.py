#!/usr/bin/python3
"""How far a relaxation has come, from its energy monitor and its states; see relaxation.md.

usage: tests/bench/relaxation.py energy.csv [state.h5 ...]
"""
import csv
import sys

import h5py
import numpy as np

NEAR = 22.0  # A: two centres of tubes that touch (17.1 A) lie at most half a segment apart along them


def print_energies(file):
    with open(file) as f:
        lines = (line for line in f if not line.startswith("#"))
        rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(lines)]
    for r in rows:
        r["elastic"] = r["stretch"] + r["shear"] + r["bending"] + r["torsion"]
        r["balance"] = r["total"] + r["damped"] + r["broken"] - r["external"]
    marks = [s for s in (0, 1000, 2000, 5000, 10000, 15000, 20000, 30000, 40000)]
    print(f"{file}\n  step, elastic, pair, elastic + pair, kinetic (eV)")
    for r in rows:
        if int(r["step"]) in marks or r is rows[-1]:
            print(f"  {int(r['step'])}, {r['elastic']:.1f}, {r['pair']:.1f}, {r['elastic'] + r['pair']:.1f}, "
                  f"{r['kinetic'] + r['rotational']:.3g}")
    start = rows[0]["elastic"]
    for part in (0.3, 0.1, 0.05, 0.03):
        step = next((int(r["step"]) for r in rows if r["elastic"] <= part * start), None)
        print(f"  elastic energy below {part:g} of the start's at step {step}")
    print(f"  energy balance drifted by {rows[-1]['balance'] - rows[0]['balance']:.3g} of {rows[-1]['damped']:.6g} eV damped")


def neighbours(file):
    """Mean number of other fibres beside a segment, and the share of segments with 3 or more."""
    with h5py.File(file) as f:
        g = f["state"]
        x, fibre = g["position"][:], g["fibre"][:]
        box = np.where(g.attrs["periodic"], np.asarray(g.attrs["upper"]) - g.attrs["lower"], np.inf)
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
    print(f"  {state}: {mean:.2f} fibres beside a segment, {100 * bundled:.0f} % of segments beside 3 or more")
