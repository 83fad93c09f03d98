"""The table on the screen and in files, and the picture."""
import csv

import matplotlib
import numpy as np

from ..pictures import style as looks
from ..pictures.style import INK
from . import elastica
from .common import CURVES, RESULTS

matplotlib.use("Agg")
import matplotlib.pyplot as plt

HEADER = ("check", "what", "expected", "measured", "error", "bound", "holds")
COLOURS = looks.CYCLE
STYLE = looks.STYLE | {
    "savefig.dpi": 160, "font.size": 8, "lines.linewidth": 1.2, "legend.fontsize": 7,
    "axes.titlesize": 8.5, "axes.titlelocation": "left"}


def cells(row):
    return (row.family, row.name, f"{row.expected:.8g}", f"{row.measured:.8g}", f"{row.error:.2g}",
            f"{row.bound:.2g}", "yes" if row.holds else "no")


def print_table(rows):
    table = [HEADER, *map(cells, rows)]
    widths = [max(len(line[k]) for line in table) for k in range(len(HEADER))]
    for line in table:
        print("  ".join(cell.ljust(width) for cell, width in zip(line, widths)).rstrip())


def write_tables(rows):
    with open(RESULTS / "table.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow((*HEADER, "where the bound comes from"))
        for r in rows:
            numbers = (repr(float(v)) for v in (r.expected, r.measured, r.error, r.bound))
            writer.writerow((r.family, r.name, *numbers, "yes" if r.holds else "no", r.reason))
    with open(RESULTS / "table.md", "w") as file:
        file.write("| " + " | ".join((*HEADER, "where the bound comes from")) + " |\n")
        file.write("|" + "---|" * (len(HEADER) + 1) + "\n")
        for r in rows:
            file.write("| " + " | ".join((*cells(r), r.reason)) + " |\n")


def draw_elastica(axes):
    loads = sorted(float(name.split("_")[1]) for name in CURVES
                   if name.startswith("elastica_") and name.endswith("_20"))
    for k, load in enumerate(loads):
        exact, chain = (CURVES[f"elastica_{load:g}_{part}"] for part in ("exact", 20))
        axes.plot(*exact.T, color=COLOURS[k % 6], label=f"{load:g}")
        axes.plot(*chain.T, "o", color=COLOURS[k % 6], ms=2.5)
    axes.set(title="elastica under a dead load: 20 bonds and exact", xlabel="x/L", ylabel="y/L",
             aspect="equal")
    if loads:
        axes.legend(title="$PL^2/EJ$", loc="upper left", ncols=2)


def draw_convergence(axes):
    for k, (name, points) in enumerate(sorted(CURVES.get("convergence", {}).items())):
        n, error = np.array(points).T
        axes.loglog(n, error, "o-", ms=2.5, lw=0.7, color=COLOURS[k % 6])
    n = np.array([10.0, 80.0])
    axes.loglog(n, 0.5 * (10 / n)**2, color=INK, ls="--", label="second order")
    axes.set(title="error against continuum theory, all cases", xlabel="bonds",
             ylabel="error (relative, or of y/L)")
    axes.set_xticks([10, 20, 40, 80], ["10", "20", "40", "80"])
    axes.minorticks_off()
    axes.legend()


def draw_buckling(axes):
    ratios = 1 + np.linspace(0.001, 1.27, 300)**2
    axes.plot([elastica.buckled(r)[2] for r in ratios], ratios, color=COLOURS[0],
              label="elliptic integrals")
    axes.plot([0, 0], [0, 1], color=COLOURS[0])
    for ratio, y in CURVES.get("path", []):
        axes.plot(y, ratio, "o", color=COLOURS[1], ms=4)
    axes.plot([], [], "o", color=COLOURS[1], ms=4, label="program, T to 0")
    axes.set(title="clamped-free column beyond its load", xlabel="y/L of the end",
             ylabel="load over Euler's",
             ylim=(0, 2.7))
    axes.legend(loc="lower right")


def draw_adhesion(axes):
    for k, splice in enumerate(("smooth", "kink")):
        for name, style, label in ((f"adhesion_{splice}", "-", splice),
                                   (f"adhesion_{splice}_program", "o", f"{splice}, program")):
            if name in CURVES:
                axes.plot(*np.array(CURVES[name]).T, style, ms=3, color=COLOURS[k], label=label)
    axes.set(title="two endless parallel tubes", xlabel="distance, Å",
             ylabel="energy per length, eV/Å",
             ylim=(-0.21, 0.1))
    if axes.has_data():
        axes.legend()


def draw_corrugation(axes):
    for k, splice in enumerate(("smooth", "kink")):
        if f"corrugation_{splice}" in CURVES:
            points, own, found = np.array(CURVES[f"corrugation_{splice}"]).T
            axes.semilogy(points, own, color=COLOURS[k], label=splice)
            axes.semilogy(points, found, "o", color=COLOURS[k], ms=3.5, label=f"{splice}, program")
    axes.set(title="corrugation: spread of the adhesion while sliding", xlabel="points a segment",
             ylabel="%")
    if axes.has_data():
        axes.legend()


def draw_folded(axes):
    place = 0.0
    for name, columns in (("racket_80", (2, 0)), ("racket_120", (2, 0)), ("ring_76", (0, 2)),
                          ("ring_112", (0, 2))):
        if name in CURVES:
            x = CURVES[name][:, columns]
            x = x - x.min(0) + [place, 0]
            place = x[:, 0].max() + 60
            axes.plot(*x.T, "-o", ms=1, lw=0.8, label=name.replace("_", ", ") + " segments",
                      color=COLOURS[("racket" in name) + 2 * ("0" in name)])
    axes.set(title="rackets and rings at rest", xlabel="Å", ylabel="Å", aspect="equal")


def draw_order(axes):
    steps = None
    names = [name for name in CURVES if name.startswith("energy_")]
    for k, name in enumerate(names):
        steps, error = np.array(CURVES[name]).T
        axes.loglog(steps, error, "o-", ms=3, color=COLOURS[k % 6], label=name[7:])
    if names:
        axes.loglog(steps, error[0] * (steps / steps[0])**2, color=INK, ls="--",
                    label="second order")
        axes.legend(loc="upper left")
    axes.set(title="energy balance: error over the energy put in", xlabel="step, fs",
             ylabel="error")
    axes.set_xticks([1, 2, 4, 8, 16], ["1", "2", "4", "8", "16"])
    axes.minorticks_off()


def draw_drift(axes):
    for k, name in enumerate(name for name in CURVES if name.startswith("drift_")):
        axes.plot(*CURVES[name], color=COLOURS[k], label=f"undamped {name[6:]}")
    axes.set(title="a million steps: energy less its start", xlabel="step",
             ylabel="over the energy of the start")
    if any(name.startswith("drift_") for name in CURVES):
        axes.legend()


def draw_rows(axes, rows):
    families = list(dict.fromkeys(row.family for row in rows))
    for k, family in enumerate(families):
        at = [i for i, row in enumerate(rows) if row.family == family]
        share = [max(rows[i].error / rows[i].bound, 1e-6) for i in at]
        axes.semilogy(at, share, "o", ms=3.5, color=COLOURS[k % 6])
        axes.text(np.mean(at), 1e-7, family, rotation=35, ha="right", va="top",
                  color=COLOURS[k % 6])
    axes.axhline(1, color=INK, lw=0.8)
    axes.set(title="error over bound, each row of the table (those below 1e-6 are drawn there)",
             ylabel="error/bound",
             ylim=(3e-7, 10))
    axes.set_xticks([])


def draw(rows):
    if not rows:
        return
    with plt.rc_context(STYLE):
        figure = plt.figure(figsize=(15, 10), layout="constrained")
        grid = figure.add_gridspec(3, 4, height_ratios=(3, 3, 2.2))
        panels = (draw_elastica, draw_convergence, draw_buckling, draw_order,
                  draw_adhesion, draw_corrugation, draw_folded, draw_drift)
        for k, panel in enumerate(panels):
            panel(figure.add_subplot(grid[k // 4, k % 4]))
        draw_rows(figure.add_subplot(grid[2, :]), rows)
        figure.savefig(RESULTS / "picture.png")
        plt.close(figure)
