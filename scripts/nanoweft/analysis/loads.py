"""What fibres carry: stress of each fibre, energy of each kind."""

from __future__ import annotations

import numpy as np

from ..units import GPA
from .findings import Curve, Findings
from .sample import Lacking, Sample

LENGTH, STIFFNESS = 1, 4  # places of T and B1 among the numbers of a kind
PARTS = ("stretch", "shear", "bending", "torsion", "pair")


def stress(sample: Sample) -> Findings:
    """Of a fibre, the axial force B1 (r - T - rest extension) of its whole bonds over the section
    of its radius, mean along it."""
    found = Findings(trends=("stress_mean", "stress_max", "stress_min"))
    rows, of = sample.bonded, sample.kind[sample.bonded]
    numbers = sample.numbers[of]
    if not len(rows):
        raise Lacking(f"{sample.name}: no bonds, so no stress")
    state = sample.state
    rest = state["rest_extension"][sample.order[rows]] if "rest_extension" in state else 0
    force = numbers[:, STIFFNESS] * (np.linalg.norm(sample.vector[rows], axis=1)
                                     - numbers[:, LENGTH] - rest)
    one = force / (np.pi * sample.thickness[of]**2) / (1e9 if state.units == "si" else GPA)
    bonds = np.bincount(sample.fibre[rows])
    each = np.bincount(sample.fibre[rows], one)[bonds > 0] / bonds[bonds > 0]
    found.add("stress_mean", one.mean(), "GPa",
              "axial, over a fibre's whole section; tension above 0")
    found.add("stress_deviation", each.std(), "GPa", "standard deviation between fibres")
    found.add("stress_min", each.min(), "GPa", "of one fibre, mean along it")
    found.add("stress_max", each.max(), "GPa", "of one fibre, mean along it")
    found.add("stress_bond_max", one.max(), "GPa", "of one bond")
    found.histogram("stress", each, sample.settings.bins, "stress of a fibre, GPa")
    name = np.unique(state["fibre"])[bonds.nonzero()[0]]
    found.curves.append(Curve("stress_by_fibre", name, each, ("fibre", "stress, GPa"), "table"))
    return found


def energy(sample: Sample) -> Findings:
    """Half of a bond's, link's or pair's energy belongs to each of its segments."""
    lacking = [part for part in PARTS if f"{part}_energy" not in sample.fields]
    if lacking:
        raise Lacking(f"{sample.name}: no {lacking[0]}_energy in /field; snapshots have it"
                      " (-snapshot_file)")
    names = sample.state.kinds.names or ("",)
    unit = "J" if sample.state.units == "si" else "eV"
    found = Findings(trends=tuple(f"energy_{part}{'_' * bool(name) + name}" for name in names
                                  for part in ("elastic", "pair")))
    linked = len(sample.state.links) + sample.state.broken_links > 0
    holders = "bonds and links" if linked else "bonds"
    for k, name in enumerate(names):
        mine, tail = sample.state["kind"] == k, "_" * bool(name) + name
        sums = [float(sample.fields[f"{part}_energy"][mine].sum(dtype=float)) for part in PARTS]
        of = f" of {name}" * bool(name)
        for part, value in zip(PARTS, sums):
            where = f" in {holders}" * (linked and part != "pair")
            found.add(f"energy_{part}{tail}", value, unit, f"{part}{of}{where}")
        found.add(f"energy_elastic{tail}", sum(sums[:4]), unit, f"all of the {holders}{of}")
        found.curves.append(Curve(f"energy{tail}", np.arange(5.0), np.array(sums),
                                  ("", f"energy{of}, {unit}"), "bars", PARTS))
    return found
