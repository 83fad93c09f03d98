"""Fibres that are more than elastic: modes that decay, wires that keep what they were bent to."""
import math

import numpy as np

from .. import states, tables
from ..beams import TUBE
from ..rotations import matrices
from . import linear
from .common import in_plane, new_folder, relative, simulate, write_state

T = TUBE.T
VISCOUS, PLASTIC = "internal viscosity", "plastic flow"


def decays():
    """Energy of a free fibre's bending modes, which falls as exp(-t omega^2 time)."""
    rows, nodes = [], 21
    squared, shapes = linear.modes(nodes, [])
    modes = [k for k, square in enumerate(squared) if square > 1e-6 * squared[-1]][:2]
    for number, mode in enumerate(modes):
        omega, shape = math.sqrt(squared[mode]), shapes[:, mode]
        u = 1e-4 * nodes * T * shape / np.abs(shape[::2]).max()
        x = np.column_stack([np.arange(nodes) * T, np.zeros(nodes), u[::2]])
        folder = new_folder(f"viscosity_{number}")
        write_state(folder / "in.h5", [(x, in_plane(u[1::2]))])
        steps = math.ceil(2 * math.pi / omega / 8)
        dt, time = 2 * math.pi / omega / steps, 0.02 / omega
        simulate(folder.name, "-scene file -scene_file {dir}/in.h5 -pair none "
                 f"-fibre_retardation {time!r} -ts_dt {dt!r} -ts_max_steps {6 * steps} "
                 f"-energy_monitor ascii:{{dir}}/energy.csv -monitor_interval {steps}")
        total = tables.read(folder / "energy.csv")["total"]
        rows.append(relative(
            VISCOUS, f"bending mode {number + 1} of a free fibre: rate of decay, 1/fs",
            time * omega**2, math.log(total[0] / total[6]) / (6 * steps * dt), 2e-3,
            "damping ratio squared (1e-4), and forces half a step late"))
    return rows


def kept():
    """Angle of two segments that were bent and let go, and length of two that were stretched."""
    curvature, bent, strain = 0.008, 0.2, 0.05
    options = ("-pair none -damping_local 0.3 -ts_dt 10 -ts_max_steps 4000 "
               "-state_output {dir}/out.h5 ")
    folder = new_folder("plastic_bent")
    simulate(folder.name, f"-scene fibre -fibre_segments 2 -fibre_bend {bent} "
             f"-fibre_yield_curvature {curvature} " + options)
    axes = matrices(states.read(folder / "out.h5")["orientation"])[:, :, 0]
    rows = [relative(PLASTIC, "two segments bent by 0.2 rad and let go: angle, rad",
                     bent - curvature * T, math.acos(axes[0] @ axes[1]), 1e-8, "rest of damping")]
    folder = new_folder("plastic_stretched")
    write_state(folder / "in.h5", [(np.array([[0, 0, 0], [T * (1 + strain), 0, 0]]),
                                    np.tile([1.0, 0, 0, 0], (2, 1)))])
    simulate(folder.name, "-scene file -scene_file {dir}/in.h5 -start_unchecked "
             "-fibre_yield_strain 0.02 " + options)
    x = states.read(folder / "out.h5")["position"]
    rows.append(relative(PLASTIC, "two segments stretched by 5 % and let go: length, A",
                         T * (1 + strain - 0.02), x[1, 0] - x[0, 0], 1e-8, "rest of damping"))
    return rows


CHECKS = {"viscosity": decays, "plastic": kept}
