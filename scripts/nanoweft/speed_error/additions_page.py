"""The section about what was added to the paper's model, from additions.csv."""

from .additions import LENGTHS, SEGMENTS
from .additions_errors import TERMS
from .page import number, table

TEXT = ("""
## Kinds, rest shapes, links, kinks, bond laws, contacts, walls, holders, temperature, the box

Made by `scripts/speed_error --additions` on {machine}, last by `{command}` in {seconds} s; rows in
[additions.csv](additions.csv).
A step of a weave of 24 x 24 tubes of 120 segments ({segments}), with pair forces and with bonds
alone: user time, the median of two or three ratios of a run with the term to one without it next to
it in time (`+-`: half their range). Of the box: a periodic weave of as many, with pair forces.

{costs}

The first row repeats the plain run and shows the noise; what is `off` costs nothing beyond it. A
kink or a rest shape adds to a bond's work, which is a small part of a step with pair forces. Two
kinds send pairs of unequal fibres through a slower kernel
([kinds](../../src/manual/kinds.md#mixed-sizes-and-what-they-cost)). There are {links} links
among {segments} segments. Contacts are computed at a closest approach instead of points, and here
they replace the nanotubes' adhesion, so the two have different pairs; the wall is out of touch.

Errors against closed forms, where the fibre stays and its segments' length T changes:

{errors}

Adhesion: a (10,10) tube cut into segments of T beside one of twice its radius, default points,
against the integral over both axes. Ring: of 64 diameters, at rest as a ring, between two
forces, against (pi/4 - 2/pi) F R^3/EJ. Ladder: 40 diameters long with ten rungs, against beams
that pass forces at the rungs: bonds are exact at their nodes, what is left is the load's size.
Kink: against M L/EJ. Contact: force between fibres crossed at a right angle, against Hertz's, and
"""
        "depth of a fibre pressed on a floor, against Hertz's line: how fibres are cut does not "
        "matter. The ring's and\n"
        "the tube's errors fall with the square of T. Half of T means twice as many segments and "
        "a shorter stable step.\n"
        """
Errors of terms against the step, the stiffness of contacts or the points of a segment of 60 A, and
the ratio above:

{terms}

Friction: the bar shakes when its springs yield, which the mean of 1e5 fs keeps in part. A step of
half the length costs twice as much on top of the ratio.
""")


def section(facts, rows):
    costs = []
    for r in (r for r in rows if r["kind"] == "cost"):
        cells = [f"{r[s + '_ns']:.1f} | {r[s + '_ratio']:.3f} +- {r[s + '_spread']:.3f}"
                 if r[s + "_ratio"] is not None else " | "
                 for s in ("alone", "periodic" if r["periodic_ratio"] is not None else "weave")]
        costs.append([r["name"], *cells])
    found = {(r["name"], r["setting"]): r["error"] for r in rows if r["kind"] == "setting"}
    ratio = {r["name"]: next(r[s + "_ratio"] for s in ("periodic", "weave")
                             if r[s + "_ratio"] is not None)
             for r in rows if r["kind"] == "cost" and (r["weave_ratio"] or r["periodic_ratio"])}
    terms = [[t.name, f"{ratio[t.cost]:.2f}", t.measure,
              "; ".join(f"{s:g} {t.unit}: {number(found[t.name, f'{s:g} {t.unit}'])}"
                        for s in t.settings if (t.name, f"{s:g} {t.unit}") in found)]
             for t in TERMS if any(name == t.name for name, _ in found)]
    errors = [r for r in rows if r["kind"] == "error"]
    found = {(r["name"], r["T"]): r["error"] for r in errors}
    lines = [[name, *(number(found.get((name, times))) for times in LENGTHS)]
             for name in dict.fromkeys(r["name"] for r in errors)]
    return TEXT.format(
        costs=table(["", "bonds alone: ns a segment-step", "ratio", "with pairs: ns a segment-step",
                     "ratio"], costs),
        errors=table(["", *(f"T = {times:g} x 2 rf" for times in LENGTHS)], lines),
        terms=table(["term", "cost", "error of, against what", "errors"], terms),
        segments=SEGMENTS, **facts)
