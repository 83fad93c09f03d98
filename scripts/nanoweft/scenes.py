"""Scenes that the program lays, to be moved, turned and mixed:

    film = scenes.make("film", film_size=(800, 800), film_coverage=2, film_periodic=False)
    rope = scenes.make("rope", rope_plies=(3, 7), rope_segments=80)
    rope = rope.turned((0, 0, 1), math.pi / 4).moved((400, 400, 150))
    scenes.join(film, rope).write("mixed.h5")

A run takes the file by `-scene file -scene_file mixed.h5`, and then refuses fibres that overlap.
"""

from __future__ import annotations

import itertools
import os
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from numbers import Integral
from typing import Any, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import kinds, rotations, runs, states
from .problems import Unusable

Array = NDArray[Any]
Value = Union[bool, int, float, str]
Option = Union[Value, Sequence[Value], Array]

# Rows that a mixture has, as far as one of its parts has them, and their columns; they are 0 in the
# others.
KEPT = {"position": 3, "orientation": 4, "fibre": 1, "index": 1, "kind": 1, "group": 1,
        "velocity": 3, "angular_velocity": 3, "bond_broken": 1, "rest_rotation": 3,
        "rest_extension": 1}


class Scene(states.State):
    """Segments and their box; lengths in the state's unit, A but for -units si."""

    @property
    def position(self) -> Array:
        """Centres [N,3], with periodic images undone."""
        return self.whole

    @property
    def orientation(self) -> Array:
        """Unit quaternions [N,4], w x y z, that turn the x axis into the segment's."""
        return self["orientation"]

    @property
    def fibre(self) -> Array:
        return self["fibre"]

    @property
    def index(self) -> Array:
        """Places of the segments along their fibres, from 0 on."""
        return self["index"]

    @property
    def kind(self) -> Array:
        """Numbers of the segments' kinds, whose names are kinds.names."""
        return self["kind"]

    def moved(self, way: ArrayLike) -> Scene:
        """The scene and its box, moved by [3]."""
        way = np.asarray(way, float)
        return replace(self, rows={**self.rows, "position": self["position"] + way},
                       lower=self.lower + way, upper=self.upper + way)

    def turned(self, axis: ArrayLike, angle: float, about: ArrayLike = (0, 0, 0)) -> Scene:
        """The scene, turned by an angle in radians about an axis [3] through the point `about`; its
        box holds the corners of the box before. Unusable for a periodic one."""
        if self.periodic.any():
            raise Unusable("a scene with a periodic box cannot be turned: lay it open")
        q, point = rotations.rotation_about(axis, angle), np.asarray(about, float)
        turn = rotations.matrices(q)[0].T
        rows = {**self.rows, "position": (self.whole - point) @ turn + point,
                "orientation": rotations.multiply(q, self["orientation"])}
        rows.pop("image", None)
        rows.update({name: rows[name] @ turn
                     for name in ("velocity", "angular_velocity", "force", "torque")
                     if name in rows})
        corners = np.array(list(itertools.product(*zip(self.lower, self.upper))))
        corners = (corners - point) @ turn + point
        return replace(self, rows=rows, lower=corners.min(axis=0), upper=corners.max(axis=0))

    def write(self, name: states.Path) -> None:
        """A state file, as one made by hand."""
        states.write(name, self)


def read(name: states.Path) -> Scene:
    """The segments of a state file. Unusable says what is wrong with it, or that it has links."""
    state = states.read(name)
    if len(state.links):
        raise Unusable(f"{name}: it has links, which scenes do not keep;"
                       " give -links_density to the run of the mixture")
    return Scene(**vars(state))


def make(scene: str, **options: Option) -> Scene:
    """What the program lays with `-scene NAME` and further options, without their hyphens. Unusable
    with the program's line where it refuses them."""
    with tempfile.TemporaryDirectory(prefix="nanoweft-") as folder:
        file = os.path.join(folder, "scene.h5")
        words = [word for name, value in options.items() for word in (f"-{name}", text(value))]
        words += ["-scene", scene, "-ts_max_steps", "0", "-state_output", file]
        try:
            done = runs.run(words, runs.Launch(folder=os.getcwd()))
        except OSError:
            raise Unusable(f"there is no program {runs.PROGRAM}: build it, or say where it is in"
                           " NANOWEFT_PROGRAM") from None
        if done.returncode:
            raise Unusable(refusal(done.stdout + done.stderr))
        made = read(file)
    return named(made, text(options["kinds"])) if "kinds" in options else made


def named(scene: Scene, names: str) -> Scene:
    """The scene with its only kind named; with several, they have their names."""
    if not scene.kinds.names:
        scene.kinds = kinds.Kinds(kinds.split(names), scene.kinds.radii)
        scene.rows["kind"] = np.zeros(len(scene), np.int32)
    return scene


def text(value: Option) -> str:
    """An option's value as the program reads it."""
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    if isinstance(value, Sequence) or np.ndim(value):
        return ",".join(text(one) for one in value)  # type: ignore[union-attr]
    return str(int(value)) if isinstance(value, (Integral, np.bool_)) else f"{value:.17g}"


def refusal(printed: str) -> str:
    """The line in which the program says why it ended, without its name."""
    start = "nanoweft: error: "
    lines = printed.strip().splitlines() or ["the program ended without a word"]
    return next((line[len(start):] for line in lines if line.startswith(start)), lines[-1])


def join(*scenes: Scene, box: tuple[ArrayLike, ArrayLike] | None = None,
         periodic: ArrayLike | None = None) -> Scene:
    """All scenes in one: fibres numbered anew in their order, kinds by their names.

    box: its lower and upper corner; else it is that of the scenes that are periodic in a direction,
    and holds all boxes in the others. periodic [3]: else where some scene is. Unusable for boxes,
    units or kinds that contradict each other."""
    if not scenes:
        raise Unusable("there are no scenes to join")
    if len({scene.units for scene in scenes}) > 1 or any(scene.tilt.any() for scene in scenes):
        raise Unusable("scenes to join need the same units, and boxes that are not tilted")
    lower, upper = bounds(scenes) if box is None else (np.array(side, float) for side in box)
    ways = (np.any([scene.periodic for scene in scenes], axis=0) if periodic is None
            else np.array(periodic, bool))
    numbers, run, common = common_kinds(scenes)
    parts, closed, count = [], [], 0
    for scene, number in zip(scenes, numbers):
        ids, fibre = np.unique(scene["fibre"], return_inverse=True)
        parts.append({**scene.rows, "position": scene.whole, "fibre": fibre + count,
                      "kind": number[scene["kind"]]})
        closed.append(np.searchsorted(ids, scene.closed) + count)
        count += len(ids)
    if not common.names:
        parts = [{name: part[name] for name in part if name != "kind"} for part in parts]
    return Scene(merged(parts, run), lower, upper, ways, units=scenes[0].units, kinds=common,
                 closed=np.concatenate(closed), run=run)


def bounds(scenes: Sequence[Scene]) -> tuple[Array, Array]:
    """Lower and upper corner of the box of all."""
    lower = np.min([scene.lower for scene in scenes], axis=0)
    upper = np.max([scene.upper for scene in scenes], axis=0)
    for d in range(3):
        sides = {(scene.lower[d], scene.upper[d]) for scene in scenes if scene.periodic[d]}
        if len(sides) > 1:
            raise Unusable(f"scenes that are periodic along {'xyz'[d]} need the same box there: "
                           + " and ".join(f"{a:g} to {b:g}" for a, b in sorted(sides)))
        for lower[d], upper[d] in sides:
            pass
    return lower, upper


def common_kinds(scenes: Sequence[Scene]) -> tuple[list[Array], dict[str, Any], kinds.Kinds]:
    """The new number of each kind of each scene; what runs said of all kinds; their names."""
    found: dict[str, dict[str, Array]] = {}  # by name, in the order of their new numbers
    for scene in scenes:
        for k, name in enumerate(scene.kinds.names or ("",)):
            said = {}
            if "fibre" in scene.run:
                straight = np.zeros(3 * len(scene.kinds))
                said = {key: np.reshape(rows, (len(scene.kinds), -1))[k] for key, rows in
                        (("fibre", scene.run["fibre"]),
                         ("rest_shapes", scene.run.get("rest_shapes", straight)))}
            before = found.setdefault(name, said)
            if any(not np.array_equal(before[key], said[key]) for key in before.keys() & said):
                raise Unusable(f"the kind '{name}' is not the same in all scenes" if name else
                               "the fibres of the scenes differ: name their kinds (kinds=...)")
    if "" in found and len(found) > 1:
        raise Unusable("some scenes name their kinds and others do not (kinds=...)")
    order = {name: k for k, name in enumerate(found)}
    run = {key: np.concatenate([said[key] for said in found.values()])
           for key in ("fibre", "rest_shapes") if all(key in said for said in found.values())}
    names = tuple(found) if "" not in found else ()
    radii = tuple(run["fibre"][::kinds.NUMBERS].tolist()) if "fibre" in run else ()
    return ([np.array([order[name] for name in scene.kinds.names or ("",)], np.int32)
             for scene in scenes], run, kinds.Kinds(names, radii))


def merged(parts: Sequence[dict[str, Array]], run: dict[str, Any]) -> dict[str, Array]:
    """Rows of all parts one after another; 0 where a part has none of a name."""
    names = [name for name in KEPT if any(name in part for part in parts)]
    if (any("rest_rotation" in part for part in parts) and np.any(run.get("rest_shapes", 0))
            and not all("rest_rotation" in part for part in parts)):
        raise Unusable("scenes at rest as they lie cannot be joined with such whose kinds are"
                       " curved at rest")
    rows = {}
    for name in names:
        kind = next(part[name].dtype for part in parts if name in part)
        rows[name] = np.concatenate([
            part[name] if name in part else
            np.zeros((len(part["position"]), KEPT[name])[:KEPT[name]], kind) for part in parts])
    return rows
