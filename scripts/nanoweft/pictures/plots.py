"""Plots of tables: energies, their convergence, stress over strain."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Any

import matplotlib
import numpy as np
from numpy.typing import NDArray

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402
from matplotlib.ticker import MaxNLocator  # noqa: E402

from .. import options  # noqa: E402
from .. import tables as tables_module  # noqa: E402
from ..analysis.decay import fit_decay  # noqa: E402
from ..problems import Unusable  # noqa: E402
from ..tables import ELASTIC, Table  # noqa: E402
from ..units import ENERGY, TIME, Unit, largest_unit  # noqa: E402
from .style import (BLUE, CYCLE, GREEN, GREY, INK, ORANGE, PURPLE, SKY, TABLES,  # noqa: E402
                    VERMILION)

Array = NDArray[Any]
Tables = Sequence[Table]
Labels = Sequence[str]


def unit_for(columns: Sequence[Array], ladder: Sequence[Unit]) -> Unit:
    """The unit in which the largest number of all columns exceeds two."""
    return largest_unit(max(float(np.abs(column).max()) for column in columns), ladder)


def one_system(tables: Tables) -> str:
    """The units that all tables have."""
    if len({table.units for table in tables}) > 1:
        raise Unusable("the files are in different units")
    return tables[0].units


def by_fire(table: Table) -> bool:
    """Whether the run was relaxed by FIRE, by its options."""
    return options.parse("\n".join(table.options)).get("relax_method") == "fire"


def progress(tables: Tables) -> tuple[list[Array], str, str]:
    """What the tables are drawn over, with its unit and its axis' name: time, or steps where one
    is of FIRE, whose time is no physical one."""
    if any(map(by_fire, tables)):
        return [table.need("step")["step"] for table in tables], "steps", "step"
    unit, second = unit_for([table.time for table in tables], TIME)
    return [table.time / second for table in tables], unit, f"time, {unit}"


def largest_change(table: Table) -> float:
    """Of any energy in the run."""
    exchanged = [table.elastic, table.motion,
                 *(table[name] for name in ("pair", "damped", "broken", "external",
                                            "friction", "heat", "walls")
                   if name in table)]
    return max(float(np.ptp(values)) for values in exchanged) or 1.0


def plot_energy(tables: Tables, labels: Labels) -> Figure:
    ladder = ENERGY[one_system(tables)]
    times, _, time_name = progress(tables)
    unit, factor = unit_for([table.elastic for table in tables], ladder)
    pair_unit, pair_factor = unit_for([table["pair"] for table in tables], ladder)

    figure, (top, middle, bottom) = plt.subplots(
        3, sharex=True, figsize=(7, 7.2), layout="constrained",
        gridspec_kw={"height_ratios": (3, 1.6, 2)})
    single = len(tables) == 1
    for table, time, label, colour in zip(tables, times, labels, CYCLE * len(tables)):
        top.plot(time, table.elastic / factor, color=INK if single else colour,
                 lw=2.2 if single else 1.4, label="sum" if single else label)
        if single:
            for part, part_colour in zip(ELASTIC, (BLUE, ORANGE, GREEN, PURPLE)):
                top.plot(time, table[part] / factor, color=part_colour, label=part)
        middle.plot(time, table["pair"] / pair_factor, color=SKY if single else colour)
        error = np.abs(table.balance - table.balance[0])
        for values, style, name in ((table.motion, "-", "kinetic + rotational"),
                                    (error, ":", "energy balance error")):
            # A logarithmic axis has no place for zero.
            shown = np.where(values > 0, values / largest_change(table), np.nan)
            bottom.plot(time, shown, style, label=name if table is tables[0] else None,
                        color=colour if not single else VERMILION if style == "-" else INK)
    top.set_ylabel(f"elastic energy, {unit}")
    middle.set_ylabel(f"pair energy, {pair_unit}")
    unit, factor = unit_for([np.array([largest_change(table)]) for table in tables], ladder)
    scale = f"{largest_change(tables[-1]) / factor:.4g} {unit}" if single else "each run's own"
    bottom.set(yscale="log", xlabel=time_name,
               ylabel="relative to largest\nenergy change")
    bottom.set_title(f"largest energy change: {scale}", loc="right", fontsize=8, color=GREY)
    # Above the axes, where no curve can hide them.
    above: dict[str, Any] = {"loc": "lower left", "bbox_to_anchor": (0, 1), "borderaxespad": 0.2}
    top.legend(ncols=5 if single else 2, **above)
    bottom.legend(ncols=2, **above)
    figure.align_ylabels()
    return figure


def plot_convergence(tables: Tables, labels: Labels) -> Figure:
    unit, factor = unit_for([table.elastic for table in tables], ENERGY[one_system(tables)])
    times, time_unit, time_name = progress(tables)
    figure, (top, bottom) = plt.subplots(2, sharex=True, figsize=(7, 6), layout="constrained",
                                         gridspec_kw={"height_ratios": (1, 1.5)})
    single = len(tables) == 1
    for table, time, label, colour in zip(tables, times, labels, CYCLE * len(tables)):
        elastic = table.elastic / factor
        fit = fit_decay(time, elastic)
        plateau = fit.plateau if fit else float(elastic.min())
        text = "no plateau yet: above its lowest value"
        if fit:
            pace = (f"constant {fit.constant:.0f}" if time_unit == "steps" else
                    f"time constant {fit.constant:.3g}")
            text = f"{pace} {time_unit}, plateau {plateau:.4g} {unit}"
        if fit and elastic[-1] < plateau:
            text += f", passed: {elastic[-1]:.4g} {unit} at the end"
        top.plot(time, elastic, color=colour)
        above = np.where(elastic > plateau, elastic - plateau, np.nan)
        bottom.plot(time, above, color=colour, label=text if single else f"{label}: {text}")
        if fit:
            _, height, constant, begin = fit
            top.axhline(plateau, color=colour, lw=0.8, ls="--")
            line = height * np.exp(-(time[begin:] - time[begin]) / constant)
            bottom.plot(time[begin:], line, color=INK if single else colour, lw=1.0, ls="--")
    top.set_ylabel(f"elastic energy, {unit}")
    bottom.set_yscale("log")
    # Where the energy passes the plateau its logarithm falls without end.
    low, high = bottom.get_ylim()
    bottom.set(ylim=(max(low, 1e-5 * high), high), xlabel=time_name,
               ylabel=f"above its plateau, {unit}")
    bottom.legend(loc="lower left", bbox_to_anchor=(0, 1), borderaxespad=0.2)
    figure.align_ylabels()
    return figure


def pull_axis(table: Table) -> str | None:
    """The direction of the pull, by the options of the run; None where they do not tell it."""
    given = options.parse("\n".join(table.options))
    if axis := given.get("tension_axis"):
        return str(axis)
    # A test that goes on keeps the axis of the state that it starts from.
    goes_on = given.get("scene") == "file" and "tension_new" not in given
    return "x" if table.program and not goes_on else None


def virial_of(table: Table) -> Array | None:
    """The virial stress along the pull; None without. Where the table does not tell the axis, the
    normal stress that is nearest to that of the grips."""
    normal = {name[7]: table[name] for name in table
              if name[:7] == "virial_" and name[7:9] in ("xx", "yy", "zz")}
    grips = (table["stress_left_GPa"] + table["stress_right_GPa"]) / 2
    return normal.get(pull_axis(table) or min(
        normal, default="", key=lambda axis: float(np.square(normal[axis] - grips).sum())))


def plot_stress(tables: Tables, labels: Labels) -> Figure:
    figure, axes = plt.subplots(figsize=(7, 4.6), layout="constrained")
    bonds = axes.twinx()
    # The stress stays in front of the count of broken bonds.
    axes.set_zorder(bonds.get_zorder() + 1)
    axes.patch.set_visible(False)
    single = len(tables) == 1
    for table, label, colour in zip(tables, labels, CYCLE * len(tables)):
        strain, broken = 100 * table["strain"], table["broken_bonds"]
        left, right = table["stress_left_GPa"], table["stress_right_GPa"]
        mean = (left + right) / 2
        # The largest pressure where the test presses, and never pulls.
        presses = strain.min() < 0 and strain.max() <= 0
        peak = mean.argmin() if presses else mean.argmax()
        strength = f"{mean[peak]:.3g} GPa at {strain[peak]:.3g} %"
        axes.plot(strain, mean, color=colour, lw=2.2,
                  label="mean" if single else f"{label}: {strength}")
        for grip, style, name in ((left, "-", "left grip"), (right, ":", "right grip")):
            axes.plot(strain, grip, style, color=colour, lw=0.6, alpha=0.6,
                      label=name if single else None)
        virial = virial_of(table)
        if virial is not None:
            axes.plot(strain, virial, "--", color=colour if not single else VERMILION,
                      label="virial" if single else None)
        axes.plot(strain[peak], mean[peak], "o", ms=7, mfc="white", mec=colour, mew=1.6)
        if single:
            side = "right" if strain[peak] > 0.8 * strain.max() else "center"
            if presses:
                side = "left" if strain[peak] < 0.8 * strain.min() else "center"
            axes.annotate(strength, (strain[peak], mean[peak]), (0, -17 if presses else 9),
                          ha=side, color=colour, textcoords="offset points")
            bonds.fill_between(strain, broken, step="post", color=GREY, alpha=0.18, lw=0)
        bonds.step(strain, broken, where="post", lw=0.9, ls="-" if single else "-.",
                   color=GREY if single else colour, alpha=0.8)
    dashed = any(virial_of(table) is not None for table in tables) and not single
    axes.set(xlabel="strain, %", ylabel="stress, GPa" + ", dashed: virial" * dashed)
    axes.margins(y=0.12)
    low, high = axes.get_ylim()
    # Marks of pressures stand below their curves, in the margin.
    if low > -high:
        axes.set_ylim(bottom=min(0, *(min(line.get_ydata()) for line in axes.lines)) - 0.02 * high)
    axes.legend(loc="upper left")
    # One zero for both scales.
    low, high = axes.get_ylim()
    broken = max(table["broken_bonds"].max() for table in tables)
    most = 1.12 * max(1.0, float(broken))
    bonds.set_yticks([tick for tick in MaxNLocator(6, integer=True).tick_values(0, most)
                      if tick <= broken])
    bonds.set_ylim(min(low / high, 0) * most, most)
    bonds.set_ylabel("broken bonds" if single else "broken bonds (dash-dotted)", color=GREY)
    bonds.grid(False)
    return figure


Draw = Callable[[Tables, Labels], Figure]
# What each kind needs of a table.
KINDS: dict[str, tuple[Draw, Sequence[str]]] = {
    "energy": (plot_energy, (*ELASTIC, "pair", "kinetic", "rotational", "total", "damped",
                             "external", "broken")),
    "convergence": (plot_convergence, ELASTIC),
    "stress": (plot_stress, ("strain", "stress_left_GPa", "stress_right_GPa", "broken_bonds")),
}


def read_table(name: str | os.PathLike[str], kind: str) -> Table:
    """A table that has what a plot of this kind needs."""
    table = tables_module.read(name).need(*KINDS[kind][1])
    if len(table) < 2:
        raise Unusable(f"{name}: fewer than two rows yet")
    return table


def draw(kind: str, tables: Tables, labels: Labels) -> Figure:
    with plt.rc_context(TABLES):
        return KINDS[kind][0](tables, labels)
