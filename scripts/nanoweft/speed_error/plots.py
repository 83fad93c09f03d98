"""Error against cost, log-log, with the Pareto front of each panel."""

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from ..pictures import style  # noqa: E402
from ..pictures.style import BLUE, GREEN, GREY, INK, VERMILION  # noqa: E402

COLOURS = [*style.CYCLE, INK]
LOOK = {
    ("points", "smooth"): (BLUE, "o", "-", "points a segment, smooth"),
    ("points", "kink"): (VERMILION, "s", "-", "points a segment, kink"),
    ("far points", ""): (GREEN, "D", "none", "fewer points for far parts"),
    ("settings", ""): (INK, "*", "none", "option files"),
}
TICKS = (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50)
SIDES = ((6, 3, "left"), (-6, 3, "right"), (6, -11, "left"), (-6, -11, "right"),
         (0, 8, "center"), (0, -17, "center"))
SHIFT = {"left": 0.0, "center": 0.5, "right": 1.0}
STYLE = style.STYLE | {
    "savefig.dpi": 160, "font.size": 9, "axes.axisbelow": True, "xtick.labelcolor": INK,
    "ytick.labelcolor": INK, "xtick.color": GREY, "ytick.color": GREY}


def front(x, y):
    """Indices of the points that no other beats in both, from cheap to dear."""
    chosen, best = [], np.inf
    for k in sorted(range(len(x)), key=lambda k: (x[k], y[k])):
        if y[k] < best:
            chosen.append(k)
            best = y[k]
    return chosen


def kind(row):
    return row["axis"], row["setting"].split()[-1] if row["axis"] == "points" else ""


def short(row):
    name = row["setting"]
    return name.split()[0] if row["axis"] == "points" else name.replace(" beyond ", " · ")


def panel(axes, rows, title):
    """One cloud of settings: a colour for each axis."""
    x = np.array([r["relative_cost"] for r in rows])
    y = np.array([r["error"] for r in rows])
    best = front(x, y)
    axes.plot(x[best], y[best], color="#DDDDDD", lw=7, solid_capstyle="round", zorder=0,
              label="Pareto front")
    axes.set(xscale="log", yscale="log", title=title, xlabel="cost relative to the paper's setting")
    axes.margins(x=0.12)
    for (axis, splice), (colour, marker, line, label) in LOOK.items():
        of = [k for k, r in enumerate(rows) if kind(r) == (axis, splice)]
        if of:
            axes.plot(x[of], y[of], linestyle=line, color=colour, marker=marker, label=label,
                      lw=0.8,
                      ms=11 if axis == "settings" else 5, mec="white", mew=0.6,
                      zorder=4 if axis == "settings" else 3)
    ticks = [t for t in TICKS if 0.8 * x.min() < t < 1.3 * x.max()]
    axes.set_xticks(ticks, [f"{t:g}" for t in ticks])
    axes.minorticks_off()
    return x, y, best


def name_points(axes, rows, x, y, best):
    """Names beside the points, the important ones first, none over another."""
    pixels = axes.transData.transform(np.column_stack([x, y]))
    order = sorted(range(len(rows)), key=lambda k: list(LOOK).index(kind(rows[k])), reverse=True)
    point = axes.figure.dpi / 72
    taken = [(place, np.full(2, 6 * point)) for place in pixels]
    for k in order:
        if rows[k]["axis"] == "far points" and k not in best:
            continue
        text, large = short(rows[k]), rows[k]["axis"] == "settings"
        size = np.array([(5.2 if large else 4.4) * len(text) + 1, 9]) * point
        for dx, dy, side in (SIDES[3::-1] + SIDES[4:]
                             if rows[k]["axis"] == "far points" else SIDES):
            corner = pixels[k] + np.array([dx, dy]) * point - size * [SHIFT[side], 0]
            inside = corner[0] + size[0] < axes.bbox.x1
            if inside and all(np.any(np.abs(corner + size / 2 - c) > (size + other) / 2)
                              for c, other in taken):
                taken.append((corner + size / 2, size))
                axes.annotate(text, (x[k], y[k]), (dx, dy), textcoords="offset points", ha=side,
                              color=LOOK[kind(rows[k])][0], fontsize=8 if large else 7)
                break


def clouds(rows, scenes, measure_of, ylabel, file):
    """Panels side by side, one for each (scene, measure)."""
    figure, panels = plt.subplots(1, 2, figsize=(10.5, 5.4), layout="constrained")
    drawn = []
    for axes, scene, measure in zip(panels, scenes, measure_of):
        # Below 1e-8 the search for the resting distance counts.
        of = [r for r in rows if (r["scene"], r["measure"]) == (scene, measure)
              and kind(r) in LOOK and (r["error"] or 0) > 1e-8]
        drawn.append((axes, of, *panel(axes, of, f"{scene}: {measure}")))
    panels[0].set_ylabel(ylabel)
    # Places of names are known once the panels have their sizes.
    figure.canvas.draw()
    for one in drawn:
        name_points(*one)
    # Above both panels, where no point can hide it.
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, ncols=5, loc="lower center", bbox_to_anchor=(0.5, 1), fontsize=8)
    figure.savefig(file, bbox_inches="tight")
    plt.close(figure)


def curves(rows, axis, file, xlabel, ylabel="relative error", x="relative_cost"):
    """Every measure of one axis as a curve over the column `x`, the settings named above."""
    of = [r for r in rows if r["axis"] == axis and r["error"]]
    kinds = list(dict.fromkeys((r["scene"], r["measure"]) for r in of))
    figure, axes = plt.subplots(figsize=(7.5, 4.6), layout="constrained")
    scenes = list(dict.fromkeys(scene for scene, _ in kinds))
    for k, (scene, measure) in enumerate(kinds):
        line = sorted(((r[x], r["error"]) for r in of
                       if (r["scene"], r["measure"]) == (scene, measure)))
        axes.plot(*zip(*line), marker="osD^vPX"[scenes.index(scene)], ms=5, lw=1.2,
                  color=COLOURS[k % len(COLOURS)], label=f"{scene}: {measure}")
    named = {r["setting"]: r[x] for r in of}
    for name, place in named.items():
        axes.annotate(name, (place, 1), (0, 3), xycoords=("data", "axes fraction"), ha="center",
                      textcoords="offset points", fontsize=8, color=GREY)
    axes.set(xscale="log", yscale="log", xlabel=xlabel, ylabel=ylabel)
    ticks = [t for t in TICKS
             if 0.7 * min(named.values()) < t < 1.4 * max(named.values())]
    axes.set_xticks(ticks, [f"{t:g}" for t in ticks])
    axes.minorticks_off()
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1), fontsize=8)
    figure.savefig(file)
    plt.close(figure)


def draw(rows, folder):
    with plt.rc_context(STYLE):
        clouds(rows, ("weave", "bundle"), ("force", "force"), "error of the forces, rms over rms",
               folder / "forces.png")
        clouds(rows, ("two tubes", "two tubes"), ("adhesion", "corrugation"), "relative error",
               folder / "two_tubes.png")
        cost = "cost of the same simulated time relative to the paper's setting"
        curves(rows, "time step", folder / "time_step.png", cost, "relative error (positions: A)")
        curves(rows, "range", folder / "range.png", cost)
        # Costs of the coarse ones are nearly equal, so the lengths themselves are the abscissa.
        curves(rows, "length", folder / "segment_length.png", "length of a segment, A",
               x="segment_A")
