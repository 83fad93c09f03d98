"""How plots look."""

from typing import Any

# Okabe and Ito's palette: colour-blind readers can tell them apart.
BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY = (
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
CYCLE = [BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY]
INK, GREY, GRID = "#222222", "#8A8A8A", "#EAEAEA"

STYLE: dict[str, Any] = {
    "text.color": INK, "axes.labelcolor": INK, "axes.edgecolor": GREY, "axes.spines.top": False,
    "axes.spines.right": False, "axes.grid": True, "grid.color": GRID, "legend.frameon": False}

# Of the plots of tables.
TABLES: dict[str, Any] = STYLE | {
    "savefig.dpi": 200, "font.size": 9, "lines.linewidth": 1.4, "axes.linewidth": 0.7,
    "axes.axisbelow": True,
    "axes.xmargin": 0.01, "grid.linewidth": 0.6, "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-3, 5), "axes.formatter.use_mathtext": True,
    "xtick.color": GREY, "ytick.color": GREY, "xtick.labelcolor": INK, "ytick.labelcolor": INK}
