"""Time of a step and efficiency against ranks."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

COLOURS = ["#1f5fa8", "#d1582a", "#2f8f4e", "#7a4fa0"]


def _frame(axes, ticks):
    axes.set_xscale("log", base=2)
    axes.set_xlabel("ranks")
    axes.set_xticks(ticks, [str(t) for t in ticks])
    axes.grid(alpha=0.3)


def _curves(axes, rows, column, **style):
    for kind, colour in zip(dict.fromkeys(r["kind"] for r in rows), COLOURS):
        mine = [r for r in rows if r["kind"] == kind]
        axes.plot([r["ranks"] for r in mine], [r[column] for r in mine], color=colour,
                  **{"marker": "o", "ms": 3.5, "label": kind} | style)


def scaling(rows, title, file, strong=True):
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    ticks = [2**k for k in range(0, 13, 2)]
    for axes in (left, right):
        _frame(axes, ticks)
    _curves(left, rows, "ms")
    _curves(left, rows, "ms_slow_network", ls=":", marker="", label=None)
    ranks = np.array(sorted({r["ranks"] for r in rows}))
    ideal = min((r for r in rows if r["ranks"] == ranks[0]), key=lambda r: r["ms"])
    ideal = ideal["ms"] * ideal["efficiency"] * ranks[0]
    if strong:
        left.plot(ranks, ideal / ranks, color="0.6", lw=1, label="ideal")
        left.set_yscale("log")
    else:
        left.set_ylim(bottom=0)
    left.set_ylabel("ms a step")
    left.legend(title="dotted: network ten times slower", title_fontsize=8, fontsize=8)
    _curves(right, rows, "efficiency")
    _curves(right, rows, "efficiency_slow_network", ls=":", marker="", label=None)
    right.set_ylim(0, 1.05)
    right.set_ylabel("efficiency")
    figure.suptitle(title)
    figure.savefig(file, dpi=110)
    plt.close(figure)


def partitions(rows, title, file):
    rows = [r for r in rows if r["ranks"] > 1]
    figure, axes = plt.subplots(1, 4, figsize=(13, 3.4), layout="constrained")
    for a, column, name in zip(axes, ("imbalance", "ghosts_per_segment", "messages_mean",
                                      "cut_pairs_percent"),
                               ("imbalance of work", "ghosts a segment", "messages a rank and step",
                                "pairs of two ranks, %")):
        _frame(a, [2**k for k in (1, 3, 6, 9, 12)])
        _curves(a, rows, column)
        a.set_title(name, fontsize=10)
    axes[1].set_yscale("log")
    axes[3].set_yscale("log")
    axes[0].legend(fontsize=8)
    figure.suptitle(title)
    figure.savefig(file, dpi=110)
    plt.close(figure)
