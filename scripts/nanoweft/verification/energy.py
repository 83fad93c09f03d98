"""Energy audit: kinetic + potential + damped + broken - external is constant but for Verlet's
error, which falls with the square of the step and does not drift; undamped motion runs backwards as
well."""
import math

import numpy as np

from .. import states, tables
from .common import CURVES, Row, new_folder, simulate

BLOCKS = 20

# Scene, largest step in fs, time in fs. Breakage needs short steps: it looks at strains once a
# step, so when a bond breaks depends on the step itself.
SCENES = {
    "undamped fibre": ("-scene fibre -fibre_segments 24 -fibre_bend 1 -fibre_twist 1 "
                       "-fibre_strain 0.01 -pair none", 16, 16000),
    "undamped weave": ("-weave_fibres 4,4 -weave_segments 24 -pair_points 5", 12, 6000),
    "damped weave": ("-weave_fibres 4,4 -weave_segments 24 -damping_local 0.4 -pair_points 5", 12,
                     6000),
    "damped weave, fewer far points": ("-weave_fibres 4,4 -weave_segments 24 -damping_local 0.4 "
                                       "-pair_far_points 1", 12, 6000),
    "pulled and broken weave": (
        "-weave_fibres 4,4 -weave_segments 24 -damping_local 0.4 -tension_rate 2e-5 "
        "-tension_ramp 2000 -tension_grip 40 -tension_max_strain 0.6 -break_strain_mean 0.15 "
        "-break_strain_std 0.02", 6, None)}


def throughput(table):
    """Energy that passed through motion: what there was, was brought in,
    or set free by adhesion."""
    return table.elastic[0] + abs(table["external"][-1]) + abs(table["pair"][-1] - table["pair"][0])


def errors(name, scene, dt, time):
    result = []
    for k in range(4):
        folder = new_folder(f"energy_{name}_{k}".replace(" ", "_").replace(",", ""))
        end = f"-ts_max_time {time}" if time else ""
        simulate(folder.name, f"{scene} -ts_dt {dt / 2**k!r} {end} -monitor_interval {2**k} "
                 "-energy_monitor ascii:{dir}/energy.csv")
        table = tables.read(folder / "energy.csv")
        error = np.abs(table.balance - table.balance[0])
        result.append(error.max() / throughput(table))
    return result


def second_order():
    rows = []
    for name, (scene, dt, time) in SCENES.items():
        found = errors(name, scene, dt, time)
        CURVES[f"energy_{name}"] = [(dt / 2**k, e) for k, e in enumerate(found)]
        slope, before = (math.log2(found[k] / found[k + 1]) for k in (2, 1))
        if "broken" in name:
            rows.append(Row("energy",
                            f"{name}: largest error over the energy put in, {dt / 8:g} fs", 0,
                            found[-1], found[-1], 2 * found[0] / 8,
                            "first order at worst: bonds break at the step's end"))
        else:
            rows.append(Row("energy", f"{name}: order in the step, {dt / 4:g} to {dt / 8:g} fs", 2,
                            slope, abs(slope - 2), max(abs(before - 2) / 2, 0.02),
                            "half of the distance from 2 at the next coarser pair, or 0.02"))
    return rows


def drift():
    rows = []
    for name, scene, dt in (("fibre", "-scene fibre -fibre_segments 16 -fibre_bend 1 "
                                      "-fibre_twist 0.5 -pair none", 10),
                            ("weave", "-weave_fibres 2,2 -weave_segments 12 -weave_periodic", 10)):
        folder = new_folder(f"energy_drift_{name}")
        simulate(folder.name, f"{scene} -ts_dt {dt} -ts_max_steps 1000000 -monitor_interval 97 "
                 "-energy_monitor ascii:{dir}/energy.csv")
        table = tables.read(folder / "energy.csv")
        # In the first fifth the motion spreads over the modes,
        # and the offset of Verlet's energy with it.
        total = table["total"][len(table["total"]) // 5:]
        blocks = np.array([block.mean() for block in np.array_split(total, BLOCKS)])
        scale = throughput(table)
        CURVES[f"drift_{name}"] = ([block.mean() for block in np.array_split(table["step"], 50)],
                                   [block.mean() / scale for block in
                                    np.array_split(table["total"] - table["total"][0], 50)])
        place = np.linspace(-0.5, 0.5, BLOCKS)
        slope = np.dot(place, blocks) / np.dot(place, place)
        rest = blocks - blocks.mean() - slope * place
        bound = 3 * math.sqrt(np.dot(rest, rest) / (BLOCKS - 2) / np.dot(place, place))
        what = f"undamped {name}, 1e6 steps of {dt} fs: drift in the last 8e5 over its energy"
        rows.append(Row("energy", what, 0,
                        slope / scale, abs(slope) / scale, bound / scale,
                        f"three standard errors of the slope through {BLOCKS} means"))
    return rows


def reversed_motion():
    rows = []
    for name, scene, steps, growth in (
            ("fibre", "-scene fibre -fibre_segments 24 -fibre_bend 1 -fibre_twist 1 -pair none",
             2000, 1e4),
            ("weave", "-weave_fibres 4,4 -weave_segments 24", 300, 1e6)):
        folder = new_folder(f"energy_reverse_{name}")
        simulate(folder.name,
                 f"{scene} -ts_dt 10 -ts_max_steps {steps} -state_output {{dir}}/there.h5")
        simulate(folder.name, f"{scene} -ts_max_steps 0 -state_output {{dir}}/start.h5")
        states.turn_back(folder / "there.h5")
        simulate(folder.name, "-scene file -scene_file {dir}/there.h5 -scene_file_edited "
                 + ("-pair none " if "none" in scene else "")
                 + f"-ts_dt 10 -ts_max_steps {steps} -state_output {{dir}}/back.h5")
        start, back = (states.read(folder / file) for file in ("start.h5", "back.h5"))
        error = np.abs(back.whole - start.whole).max()
        what = f"{name}, {steps} steps there and back: farthest from the start, A"
        rows.append(Row("energy", what, 0, error, error,
                        growth * np.spacing(np.abs(start.whole).max()),
                        f"round-off of a position, times {growth:g} for its growth"))
    return rows


CHECKS = {"energy_order": second_order, "energy_drift": drift, "energy_reverse": reversed_motion}
