"""The page: tables from matrix.csv, and what to read from them."""

import numpy as np

from . import plots

HEAD = """\
# What each setting costs and buys

Made by `{command}` on {machine}; every run on 1 rank x 1 thread, costs one run at a time, rounds: {rounds}, {seconds} s in
all. All rows are in [matrix.csv](matrix.csv); `scripts/speed_error --page FOLDER` draws this page from it again.

Cost is the wall time for the same length of fibre and the same simulated time, relative to the paper's setting
(`runs/settings/paper.opts`): the median of ratios to a run of that setting next to it in time, so the machine's own
speed drops out. Half the range of a ratio over the rounds was {noise:.0f} % of it in the median, {worst:.0f} % at worst: read differences
in cost accordingly. Absolute times wander with the machine; errors don't depend on it.

The two scenes: `weave`, {weave}, five between crossings as in the paper, 4 ps after it is let
go; `bundle`, {tubes} tubes hexagonally packed 17.07 A apart, slightly disordered, endless along their axis.
"""

FOUR = """
## Four settings to choose from

    build/bin/nanoweft -options_file runs/fabric/relax.opts -options_file runs/settings/balanced.opts

A later file wins over an earlier one, so these change the numerics of any scene of (10,10) tubes. `-ts_max_steps` counts
steps: with another step, give the end as a `-ts_max_time`.

{table}

{costs}

Forces: rms error over the segments, over the rms of the pair forces, against 9 points and 6 T to 7 T with the
same splice. Corrugation: how much the adhesion energy of two tubes varies as one slides along the other, which should
be nothing. Adhesion: of two tubes at rest. Energy drift: seven tubes fall together from 24 A without damping for 8 ps, with the
setting's own step; largest error of the energy over the largest kinetic energy.

* `fast`: for first looks and large damped scenes.
* `balanced`: for everything else; what the program does by itself.
* `paper`: to compare with the paper. Its splice is the one nearest to the printed equation, which puts a jump of the
  stiffness where tubes rest: {paper_corrugation} of the adhesion energy acts as friction that isn't there.
* `reference`: to check one of the others on a small piece of your own scene.

![forces](forces.png)

A lower left point is better; the grey band joins the settings that no other beats in both. Points and far points are judged against
9 points of the same splice at the same range, the option files (stars) also against the wider range and with their own
time step in the cost. A label `5, 1 · 2.5T` means five points, one for what reaches beyond 2.5 T.
"""

POINTS = """
## Points per segment, and the splice

{table}

Two infinite parallel tubes, independent double sums (the program agrees with them to {sums:.0e} in every setting here);
reference: 48 points at the same range and splice. Forces: against 9 points of the same splice.

![two tubes](two_tubes.png)

With `-vdw_splice smooth` the pair energy has a continuous stiffness, and equally spaced points converge exponentially: each
point more takes an order of magnitude from the corrugation. With `kink` the stiffness jumps from 5.9 to 400 eV/A^2 exactly
where tubes rest, the convergence is only algebraic, and tubes slide less freely with 9
points than with 4 and the smooth splice. The two are
different force laws ({smooth:.4f} and {kink:.4f} eV/A at rest), each is judged by its own limit. Errors of forces at the crossings of a weave,
where two segments meet at right angles in a point, fall more slowly and less
evenly than those along a bundle.
"""

FAR = """
## Fewer points for the far part of a law

{table}

`5, 1 beyond 2T`, the default for (10,10) tubes: the law is split at 2 T (model.md, 4.1). Five points sum what happens within, one
point what reaches beyond. Both are laws of their own, so nothing drifts: compare the last two columns of errors. Nearer splits are
cheaper, and give the one point more than it can resolve.
"""

ACCURACY = """
## An accuracy that is asked for

{table}

`-pair_accuracy 0.02`: the program chooses points, far points and the place of the split by its own estimate of the error, in a
bundle and where fibres cross, and the range by the cohesion it takes from a bundle. Measured against 24 points everywhere and 6 T to 7 T, in a weave and a film 4 and 2 ps after they were let go, in a bundle and in a
ring of three windings: rms errors of forces over the rms of the pair forces. Times are those of `-pair_precision double`. Without it a build for
AVX-512 takes single precision (below).
"""

PRECISION = """
## Single precision

{table}

`-pair_precision single`: the law and its sums over the points of a pair in single precision, distances of centres, axes, forces and torques of
pairs in doubles. Forces: against the same in doubles. It needs a build for AVX-512.
"""

RANGE = """
## Range of the forces

{table}

Against 6 T to 7 T. Adhesion with many points, forces with 3 points on both sides, so that the range alone counts.

![range](range.png)
"""

STEP = """
## Time step

{table}

Against a step of {finest} fs at the same time. Fibre: bent by 1.5 rad and let go, after 0.6 ps. Undamped weave: periodic, after 1.2 ps,
before chaos takes over. Damped weave: elastic energy over 12 ps of relaxation. Elastic energies and the energy
balance over the elastic energy of the start. The steps cost the same each, so cost is 20 fs over the step. Errors fall with the
square of the step until the fastest modes have lost their phase, which saturates at the largest steps.

![time step](time_step.png)
"""

LENGTH = """
## Length of a segment

{table}

Elastica: tip of a cantilever of length 20 x 13.56 A under P L^2/EJ = 3 against an independent shooting solution of the
extensible rod. Frequency: first bending mode of a free fibre of 40 x 13.56 A against a fine beam with the same
mass and rotary inertia. Both fall with the square of T. Adhesion: pair laws are energies per length squared, so it is the
same number for all. Share that breaks: of 600 fibres of 20 diameters stretched by 2 %, whose bonds' critical strains belong to 3 +- 0.5 %
for a length of 2 rf, less the exact share of 37 %; its statistical error is 0.02. Stress: of a sparse weave of 4 x 4 tubes at 5 % against T = rf. Points a segment are 2, 3, 6, 9, so points per length
stay about the same. `step` is 0.68 of the stable step of fibres pressed together, as 20 fs is for the paper's setting;
cost is for the same length of fibre and the same simulated time, on a bundle.

![segment length](segment_length.png)
"""

TERMS = """
## Model only what a scene needs

A step of the weave relative to a bare one (bonds, pair forces, motion; nothing else was ever asked for), paired run by run:

{table}

The first row repeats the bare run, so it shows the noise of this measurement (`+-`: half the range over the rounds).
What is switched off costs what it never had: the rows `off` agree with it within that noise. The solver's log (`-log_view`), 100 steps:

{events}

An event that isn't there was never entered. Without pair forces the lists are made once; without
monitors NwRecord runs only at the start and the end.

* Sparse fibres in tension carry their load in bonds: `-pair none` changes the stress of a weave of 6 x 6 fibres, 15 segments between
  crossings, at 5 % strain by the error above, at a fraction of the cost. Anything that bundles, slides or rests on contacts needs them.
* Torsion can't be left out to save time: its energy is part of each bond's one evaluation. `-fibre_bond_stiffness` needs B4 > 0,
  since without it nothing keeps a segment from spinning.
* Shear: with a quarter of B2 and B3 = EJ/T - B2/4 - B4/2 the bending stiffness stays and the stable step of a free chain grows, but crossings
  shear and the elastic energy of a weave changes by the error above. Not worth it where fibres are bent at contacts.
* Breakage can stay off while strains are far below the critical ones: the stress is the same to the last bit.
* Viscous damping needs velocities and a second sum over the pairs; what local damping costs is within the noise.
* Monitors: at every step they need the energies of all pairs; every 100 steps they cost nothing that can be measured.
"""


def number(x):
    return "" if x is None else f"{x:.2g}" if abs(x) < 100 else f"{x:.0f}"


def table(header, lines):
    out = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(out + ["| " + " | ".join(line) + " |" for line in lines])


def cost_of(rows, axis, setting, scene, column="relative_cost"):
    return next((r[column] for r in rows if (r["axis"], r["setting"]) == (axis, setting)
                 and (r["scene"] == scene or scene is None) and r[column] is not None), None)


def errors(rows, axis, costs=(("cost weave", "weave"), ("cost bundle", "bundle")), more=()):
    """One line a setting: all its errors, then its costs."""
    of = [r for r in rows if r["axis"] == axis]
    kinds = list(dict.fromkeys((r["scene"], r["measure"]) for r in of if r["measure"]))
    lines = []
    for setting in dict.fromkeys(r["setting"] for r in of):
        found = {(r["scene"], r["measure"]): r["error"] for r in of if r["setting"] == setting}
        line = [setting] + [number(found.get(kind)) for kind in kinds]
        line += [number(cost_of(rows, axis, setting, scene, column)) for _, scene, column in more]
        lines.append(line + [number(cost_of(rows, axis, setting, scene)) for _, scene in costs])
    header = [""] + [f"{scene}: {measure}" for scene, measure in kinds]
    return table(header + [m[0] for m in more] + [c[0] for c in costs], lines)


def absolute(rows):
    """What the four settings cost, in seconds."""
    lines = []
    for setting in dict.fromkeys(r["setting"] for r in rows if r["axis"] == "settings"):
        line = [setting, number(cost_of(rows, "settings", setting, None, "step_fs"))]
        for scene in ("weave", "bundle"):
            ns, pairs, ratio = (cost_of(rows, "settings", setting, scene, column) for column in
                                ("ns_per_segment_step", "pairs_per_second", "step_cost"))
            line += [f"{ns:.0f}", f"{pairs:.2g}", number(ratio)]
        lines.append(line)
    columns = [f"{scene}: {what}" for scene in ("weave", "bundle")
               for what in ("ns a segment-step", "pairs/s", "step cost")]
    return table(["", "step, fs", *columns], lines)


def terms(rows):
    of = [r for r in rows if r["axis"] == "terms"]
    lines = []
    for name in dict.fromkeys(r["setting"] for r in of):
        same = [r for r in of if r["setting"] == name]
        lost = "; ".join(f"{r['scene']}: {r['measure']} {number(r['error'])}"
                         for r in same if r["measure"])
        cost = f"{same[0]['step_cost']:.2f} +- {same[0]['step_cost_spread']:.2f}"
        lines.append([name, cost, lost])
    return table(["", "step cost", "difference in the result"], lines)


def events(found):
    names = list(dict.fromkeys(name for one in found.values() for name in one))
    cell = (lambda one,
            name: f"{one[name][0]} ({1e3 * one[name][1]:.2g} ms)" if name in one else "absent")
    return table(["", *names],
                 [[run, *(cell(one, name) for name in names)] for run, one in found.items()])


def write(facts, rows, folder):
    plots.draw(rows, folder)
    paper = next(r["error"] for r in rows if (r["axis"], r["setting"], r["measure"])
                 == ("settings", "paper", "corrugation"))
    spread = [100 * r["step_cost_spread"] / r["step_cost"] for r in rows if r["step_cost"]]
    both = (("cost weave", "weave"), ("cost bundle", "bundle"))
    parts = [
        HEAD.format(noise=np.median(spread), worst=max(spread), **facts),
        FOUR.format(table=errors(rows, "settings"), costs=absolute(rows),
                    paper_corrugation=f"{100 * paper:.1f} %"),
        POINTS.format(table=errors(rows, "points", both), sums=facts["sums"], **facts["adhesion"]),
        FAR.format(table=errors(rows, "far points")),
        *([ACCURACY.format(table=errors(rows, "accuracy"))]
          if any(r["axis"] == "accuracy" for r in rows) else []),
        *([PRECISION.format(table=errors(rows, "precision"))]
          if any(r["axis"] == "precision" for r in rows) else []),
        RANGE.format(table=errors(rows, "range")),
        STEP.format(finest=facts["finest"], table=errors(rows, "time step", (("cost", None),))),
        LENGTH.format(table=errors(rows, "length", (("cost", None),),
                                   (("ns a segment-step", None, "ns_per_segment_step"),
                                    ("step, fs", None, "step_fs")))),
        TERMS.format(table=terms(rows), events=events(facts["events"])),
    ]
    (folder / "README.md").write_text("".join(parts))
