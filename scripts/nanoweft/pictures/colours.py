"""Colours of the tubes, all of them apart for colour-blind readers, and what explains them."""

from __future__ import annotations

from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.colors import Colormap, LinearSegmentedColormap, Normalize, to_rgb
from numpy.typing import NDArray

from ..problems import Unusable
from ..states import State, Tubes
from ..units import length_unit

Array = NDArray[Any]
Limits = tuple[float, float]
Legend = tuple[tuple[str, str], ...]
NAMED = ("fibre", "kind", "stretch", "group", "height", "broken")


def ramp(*colours: Any) -> LinearSegmentedColormap:
    return LinearSegmentedColormap.from_list("ramp", colours)


class Palette(NamedTuple):
    """Colour maps for a ground; none fades into it."""
    fibres: Colormap  # over the fibre ids, so that a weave's warp comes out cool and its weft warm
    diverging: Colormap
    sequential: Colormap
    kinds: tuple[str, ...]


WHITE = Palette(
    ramp("#17406B", "#1F6FA8", "#2A9D9A", "#86B583", "#E3BC55", "#EE9440", "#D9572F", "#8F1D2C"),
    ramp("#0B4F8A", "#4C9BCB", "#A9C9DC", "#CFCBC4", "#E8B196", "#DD6E4B", "#97182B"),
    ramp(*matplotlib.colormaps["viridis"](np.linspace(0, 0.94, 9))),
    ("#2F6690", "#CFB07A", "#4E9F95", "#B4553F", "#9A86BE", "#7C8791"))
BLACK = Palette(
    ramp("#3A78C8", "#2F93D0", "#35B3AE", "#94C98F", "#F0CC66", "#F7A04C", "#EE6B40", "#D2454F"),
    ramp("#2F8CE0", "#6DB3E6", "#B7D2E2", "#D8D4CE", "#F0B898", "#EE7C52", "#DC3B48"),
    ramp(*matplotlib.colormaps["viridis"](np.linspace(0.18, 1, 9))),
    ("#5896CF", "#DCC08E", "#66BCAF", "#DB7759", "#B7A4DC", "#A4AEB8"))
GROUPS = ["#B8BCC0", "#D55E00", "#0072B2", "#009E73", "#E69F00", "#CC79A7", "#56B4E9", "#F0E442"]
WHOLE, TORN, BREAK = "#B9C3CC", "#5B8DB8", "#E8421C"
NOTHING = "#8A8A8A"
LINK = "#D6128A"
SOLID = "#D9D4C7"


class Colours(NamedTuple):
    tubes: Array
    scale: tuple[Colormap, Normalize, str] | None = None  # colour map, limits, title
    legend: Legend = ()   # pairs of text and colour


def values_of(how: str, state: State, tubes: Tubes, rest: Array) -> Array | None:
    """The number behind each tube's colour; None where colours are no scale. `rest`: the length of
    each tube without strain."""
    position, first, second, _ = tubes
    if how == "height":
        return np.asarray((position[first, 2] + position[second, 2]) / 2)
    if how == "stretch":
        length = np.linalg.norm(position[second] - position[first], axis=1)
        return np.where(first == second, 0, 100 * (length / rest - 1))
    if state.values is not None:
        return np.asarray((state.values[first] + state.values[second]) / 2)
    return None


def natural_range(how: str, values: Array) -> Limits:
    """From the lowest to the highest number, without the few extreme ones that would wash out all
    the others, and even about zero where both signs occur."""
    values = values[np.isfinite(values)]
    if how == "height":
        return float(values.min()), float(values.max())
    low, high = np.percentile(values, [0.5, 99.5])
    if how == "stretch" or low < 0 < high:
        most = max(-low, high) or 0.1
        return -most, most
    return low, high


def colour(how: str, state: State, tubes: Tubes, palette: Palette,
           scale: tuple[Array, Limits] | None, masks: Array) -> Colours:
    """`scale`: numbers of the tubes, as `values_of` has them, and the range of the colours;
    `masks`: those of all groups that pictures made together show."""
    if how == "fibre":
        return by_fibre(state["fibre"], tubes, palette)
    if how == "kind":
        return by_kind(state, tubes, palette)
    if how == "group":
        return by_group(state, tubes, masks)
    if how == "broken":
        return by_breaks(state, tubes)
    return by_scale(how, state.units, palette,
                    *scale) if scale else Colours(np.zeros((len(tubes.first), 3)))


def by_scale(how: str, units: str, palette: Palette, values: Array, limits: Limits) -> Colours:
    low, high = limits
    title = {"height": "height z", "stretch": "strain of the bonds, %"}.get(how,
                                                                            how.replace("_", " "))
    if how == "height":
        name, size = length_unit(max(abs(low), abs(high)), units)
        values, low, high, title = values / size, low / size, high / size, f"{title}, {name}"
    if high <= low:
        low, high = low - (abs(low) or 1) / 100, high + (abs(high) or 1) / 100
    signed = how != "height" and (how == "stretch" or low < 0 < high)
    cmap = palette.diverging if signed else palette.sequential
    norm = Normalize(low, high, clip=True)
    known = np.isfinite(values)
    rgb = np.where(known[:, None], cmap(norm(np.where(known, values, low)))[:, :3], to_rgb(NOTHING))
    legend = () if known.all() else (("no number", NOTHING),)
    return Colours(rgb, (cmap, norm, title), legend)


def by_fibre(fibre: Array, tubes: Tubes, palette: Palette) -> Colours:
    ids, rank = np.unique(fibre, return_inverse=True)
    rank = rank[tubes[1]]
    return Colours(shaded(palette.fibres((rank + 0.5) / len(ids))[:, :3], rank))


def by_kind(state: State, tubes: Tubes, palette: Palette) -> Colours:
    kind, rank = (rows[tubes.first] for rows in (state["kind"],
                                                 np.unique(state["fibre"], return_inverse=True)[1]))
    names = state.kinds.names or ("one kind",)
    colours = [palette.kinds[k % len(palette.kinds)] for k in range(len(names))]
    legend = tuple((names[k], colours[k]) for k in np.unique(kind))
    return Colours(shaded(np.array([to_rgb(c) for c in colours])[kind], rank, 0.16), None, legend)


def shaded(rgb: Array, rank: Array, by: float = 0.28) -> Array:
    """Neighbours in the list of fibres, often neighbours in space, differ in lightness."""
    shade = 1 - 0.5 * by + by * (rank * 0.618034 % 1)
    return np.asarray(np.minimum(rgb * shade[:, None], 1))


def by_group(state: State, tubes: Tubes, masks: Array) -> Colours:
    """The same colour for a mask in all pictures that show `masks`, which are in order."""
    group = state["group"][tubes[1]]
    which = np.searchsorted(masks, group)
    others = iter(GROUPS[1:] * len(masks))
    palette = [GROUPS[0] if mask == 0 else next(others) for mask in masks]
    legend = tuple((f"group mask {mask}" if mask else "no group", c) for mask,
                   c in zip(masks, palette) if (group == mask).any())
    return Colours(np.array([to_rgb(c) for c in palette])[which], None, legend)


def by_breaks(state: State, tubes: Tubes) -> Colours:
    """Fibres that broke somewhere apart from whole ones; the ends are marked besides."""
    fibre, (_, first, _, torn) = state["fibre"], tubes
    hurt = np.isin(fibre[first], fibre[torn.any(axis=0)])
    return Colours(np.where(hurt[:, None], to_rgb(TORN), to_rgb(WHOLE)), None,
                   (("whole fibres", WHOLE), ("broken fibres", TORN)))


def check_range(how: str, limits: Limits | None) -> None:
    if limits and how in ("fibre", "kind", "group", "broken"):
        raise Unusable(f"--range needs colours on a scale; {how} has none")
