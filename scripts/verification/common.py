"""The tube, rows of the table, state files and runs of the program."""
import dataclasses
import glob
import math
import os
import pathlib
import subprocess

import h5py
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/bin/nanoweft"
RESULTS = ROOT / "results/verification"
CURVES = {}  # what the plot shows, by name

# CODATA 2018, in eV, A, fs
AMU = 1.66053906660e-27 / 1.602176634e-29  # eV fs^2/A^2
GPA = 1e-21 / 1.602176634e-19  # eV/A^3


class Failed(Exception):
    """A run that did not end well."""


@dataclasses.dataclass
class Row:
    family: str
    name: str
    expected: float
    measured: float
    error: float
    bound: float
    reason: str

    @property
    def holds(self):
        return bool(self.error <= self.bound)


def relative(family, name, expected, measured, bound, reason):
    return Row(family, name, expected, measured, abs(measured / expected - 1), bound, reason)


class Tube:
    """The (10,10) tube of the paper's Table 1; T, E and G may differ."""

    def __init__(self, young=1029.0, shear=459.0, length=13.56):
        rf, h = 6.78, 3.35
        section = 2 * math.pi * h * rf
        second = math.pi * h * rf * (rf**2 + h**2 / 4)
        self.radius, self.T = rf, length
        self.ES, self.EJ = young * GPA * section, young * GPA * second
        self.GJp = shear * GPA * 2 * second
        self.m = 2649 * AMU * length / 13.56
        self.I = self.m * rf**2
        self.rho = self.m / length
        self.B1, self.B2, self.B4 = self.ES / length, 12 * self.EJ / length, self.GJp / length
        self.B3 = -2 * self.EJ / length - self.GJp / (2 * length)


TUBE = Tube()


def richardson(f):
    """Limit of three values, each at twice the number of segments, and its uncertainty.

    With errors a/N^2 + b/N^4 the extrapolated pairs differ by 15 times the error of the last.
    Half of that factor is left as a margin for the terms beyond."""
    first, last = (4 * f[1] - f[0]) / 3, (4 * f[2] - f[1]) / 3
    return last, abs(last - first) / 7.5


def order(errors):
    return math.log2(abs(errors[-2] / errors[-1]))


def rotation_about(axis, angle):
    """Unit quaternions (w, x, y, z) of rotations about one axis."""
    angle = np.atleast_1d(angle)
    q = np.zeros((len(angle), 4))
    q[:, 0] = np.cos(angle / 2)
    q[:, 1:] = np.sin(angle / 2)[:, None] * np.asarray(axis, float) / np.linalg.norm(axis)
    return q


def multiply(p, q):
    w, v, u, r = p[..., 0], p[..., 1:], q[..., 0], q[..., 1:]
    vector = w[..., None] * r + u[..., None] * v + np.cross(v, r)
    return np.concatenate([(w * u - np.sum(v * r, -1))[..., None], vector], -1)


def matrices(q):
    """Rotation matrices, whose columns are e1, e2, e3."""
    w, x, y, z = np.moveaxis(q, -1, 0)
    return np.moveaxis(np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]), -1, 0)


def in_plane(angle):
    """Orientations of segments in the xz plane whose axes make these angles with x."""
    return rotation_about((0, 1, 0), -np.asarray(angle))


def angles_in_plane(state):
    e1 = matrices(state["orientation"])[:, :, 0]
    return np.unwrap(np.arctan2(e1[:, 2], e1[:, 0]))


def write_state(file, fibres, groups=None, period=None, closed=False, velocity=None):
    """fibres: list of (positions, orientations); period: length of a box periodic along x."""
    x = np.concatenate([f[0] for f in fibres])
    lower, upper = x.min(0) - 100, x.max(0) + 100
    if period:
        lower[0], upper[0] = 0, period
    with h5py.File(file, "w") as f:
        g = f.create_group("state")
        g.attrs.update(format="nanoweft-state", version=1, step=0, time=0.0, units="nano",
                       lower=lower, upper=upper, periodic=[int(bool(period)), 0, 0])
        g["position"] = x
        g["orientation"] = np.concatenate([f[1] for f in fibres])
        g["fibre"] = np.repeat(np.arange(len(fibres)), [len(f[0]) for f in fibres])
        g["index"] = np.concatenate([np.arange(len(f[0])) for f in fibres])
        if groups is not None:
            g["group"] = np.asarray(groups, np.int32)
        if velocity is not None:
            g["velocity"] = velocity
        if closed:
            g["fibre_closed"] = np.arange(len(fibres))


def read_state(file):
    with h5py.File(file) as f:
        g = f["state"]
        state = {name: g[name][()] for name in g if isinstance(g[name], h5py.Dataset)}
        for name in ("lower", "upper", "step", "time"):
            state[name] = g.attrs[name]
    if "image" in state:
        state["position"] = state["position"] + state["image"] * (state["upper"] - state["lower"])
    return state


def read_table(file):
    with open(file) as lines:
        # genfromtxt would take names from a comment.
        table = np.genfromtxt((line for line in lines if not line.startswith("#")), delimiter=",", names=True)
    return {name: np.atleast_1d(table[name]) for name in table.dtype.names}


def simulate(name, options):
    """Runs the program in results/verification/NAME; {dir} in the options is that folder."""
    folder = RESULTS / name
    folder.mkdir(parents=True, exist_ok=True)
    command = ["build/bin/nanoweft", *options.format(dir=folder.relative_to(ROOT)).split(),
               "-progress_interval", "0", "-overwrite"]
    environment = dict(os.environ, OMP_NUM_THREADS="1")
    done = subprocess.run(command, env=environment, cwd=ROOT, capture_output=True, text=True)
    (folder / "log.txt").write_text(" ".join(command) + "\n" + done.stdout + done.stderr)
    if done.returncode:
        last = (done.stderr.strip() or done.stdout.strip()).splitlines()[-1:]
        raise Failed(f"{name}: status {done.returncode}: {' '.join(last)} (see {folder}/log.txt)")
    return folder


def new_folder(name):
    folder = RESULTS / name
    folder.mkdir(parents=True, exist_ok=True)
    for old in glob.glob(str(folder / "*")):
        os.remove(old)
    return folder


def settle(name, fibres, groups, options, interval, tolerance=1e-10, steps=2000000, **layout):
    """Damps a state to rest: until the elastic energy no longer changes in `interval` steps."""
    folder = new_folder(name)
    write_state(folder / "in.h5", fibres, groups, **layout)
    simulate(name, "-scene file -scene_file {dir}/in.h5 -damping_local 0.6 "
             f"-relax_tolerance {tolerance} -relax_interval {int(interval)} -ts_max_steps {steps} "
             "-state_output {dir}/out.h5 " + options)
    return read_state(folder / "out.h5")
