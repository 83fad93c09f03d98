#!/usr/bin/python3
"""Multiple time steps (-ts_inner) against one:
limits by linear theory and by runs, errors, rest, cost.

multiple_time_steps.md tells what came out. More than one inner step needs the prototype.

    tests/bench/multiple_time_steps.py theory | limits | errors | tension | rest | cost
    (after a build)
"""

import itertools
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from nanoweft import generators, runs, states, tables  # noqa: E402
from nanoweft.generators import LENGTH  # noqa: E402

WEAVE = "-weave_fibres 6,6 -weave_segments 36 -weave_periodic -scene_perturb 0.05 -pair_points 3"
# Tubes hot enough that contacts work: 0.1 A off their places.
BUNDLE = "-scene file -scene_file {bundle} -scene_perturb 0.1 -pair_points 3"
LOCAL = "-damping_local 0.4"
# Tubes 0.3 A off their places but straight: motion of contacts alone.
STRAIGHT = "-scene file -scene_file {straight} -pair_points 3"
SCENES = {"weave": (WEAVE, 1200), "bundle": (BUNDLE, 1200), "straight tubes": (STRAIGHT, 1200),
          "damped weave": (f"{WEAVE} {LOCAL}", 12000)}
INNER = (1, 2, 3)
FINEST = 0.625


# Runs

def run(folder, options, dt, inner, more=""):
    """Exit status, printed text, energy table, final positions (unwrapped)."""
    words = options.format(bundle=folder / "bundle.h5", straight=folder / "straight.h5").split()
    words += f"-ts_dt {dt:.10g} -ts_dt_unsafe -ts_limit_interval 0 {more}".split()
    words += f"-energy_monitor ascii:{folder}/e.csv -state_output {folder}/s.h5".split()
    words += [] if inner == 1 else ["-ts_inner", str(inner)]
    done = runs.run(words)
    if done.returncode == 1:
        sys.exit(done.stderr)
    if done.returncode:
        return done.returncode, done.stdout + done.stderr, None, None
    return 0, done.stdout, tables.read(folder / "e.csv"), states.read(folder / "s.h5").whole


def balance_error(table):
    return np.abs(table.balance - table.balance[0]).max()


def rms(x):
    return np.sqrt(np.mean(np.square(x)))


def straight(file):
    """37 straight tubes in a hexagonal bundle, displaced as a whole each."""
    random = np.random.default_rng(2)
    places = generators.hexagon(17.07, 3)
    generators.endless_tubes(file, places + 0.3 * random.standard_normal(places.shape),
                             LENGTH * random.random(len(places)), generators.Endless())


# Errors after a fixed time

def errors(folder):
    print("| scene | inner | step, fs | position, A | elastic energy | energy balance |\n"
          "|---|---|---|---|---|---|")
    for name, (options, time) in SCENES.items():
        def at(dt, inner):
            every = max(1, round(600 / dt)) if dt < 5 else 1
            status, _, table, position = run(folder, options, dt, inner,
                                             f"-ts_max_steps {round(time / dt)} "
                                            f"-monitor_interval {every}")
            if status:
                return None
            common = np.abs((table["time_fs"] + 1) % 600 - 1) < 1e-6
            return position, table.elastic[common], balance_error(table), table
        exact = at(FINEST, 1)
        scale = exact[1][0] if "weave" in name else exact[3].motion.max()
        other = at(FINEST, 2)
        print(f"<!-- {name}: the two integrators at {FINEST} fs differ by "
              f"{rms(other[0] - exact[0]):.2g} A; scale of energies {scale:.5g} eV -->")
        for inner, dt in itertools.product(INNER, (10, 15, 20, 25, 30, 40)):
            found = at(dt, inner)
            if found is None:
                print(f"| {name} | {inner} | {dt} | unstable | | |", flush=True)
                continue
            position, energy, balance, _ = found
            print(f"| {name} | {inner} | {dt} | {rms(position - exact[0]):.2g} | "
                  f"{rms(energy - exact[1]) / scale:.2g} | {balance / scale:.2g} |", flush=True)


# Stress in tension, damped

def tension(folder):
    options = (f"-weave_fibres 6,6 -weave_segments 90 -pair_points 3 {LOCAL} -tension_rate 2e-6 "
               "-tension_ramp 3000 -tension_max_strain 0.05 -stress_monitor ascii:{bundle}.csv")
    print("| inner | step, fs | stress | energy balance |\n|---|---|---|---|")

    def at(dt, inner):
        every = 120 if dt < 5 else 1
        status, text, table, _ = run(folder, options, dt, inner, f"-monitor_interval {every}")
        if status:
            return None
        rows = tables.read(folder / "bundle.h5.csv")
        times = np.arange(600, 24001, 600)
        stress = 0.5 * (rows["stress_left_GPa"] + rows["stress_right_GPa"])
        return np.interp(times, rows["time_fs"], stress), balance_error(table)
    exact = at(FINEST, 1)[0]
    for inner, dt in itertools.product(INNER, (10, 20, 25, 30)):
        found = at(dt, inner)
        print(f"| {inner} | {dt} | " + ("unstable | |" if found is None else
              f"{rms(found[0] - exact) / np.abs(exact).max():.2g} | {found[1]:.2g} |"), flush=True)


# Largest stable step

def limits(folder):
    print("| scene | inner | longest stable step, fs | said of the start |\n|---|---|---|---|")
    for name, inner in itertools.product(("weave", "bundle", "damped weave"), INNER):
        steps = 20000 if name == "weave" else 4000

        def stable(dt):
            status, text, table, _ = run(folder, SCENES[name][0], dt, inner,
                                         f"-ts_max_steps {steps}")
            said.extend(line.split("below ")[1].split()[0] for line in text.splitlines()
                        if "below" in line)
            return status == 0 and np.isfinite(table["total"]).all()
        said, low, high = [], 15.0, 80.0
        while high - low > 0.5:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if stable(middle) else (low, middle)
        print(f"| {name} | {inner} | {low:.1f} | {said[0]} |", flush=True)


# The state at rest

def rest(folder):
    """An undisturbed, so symmetric weave, damped until nothing moves. Forces balance at every step
    in Verlet, only on average over an outer step in multiple steps."""
    symmetric = WEAVE.replace("-scene_perturb 0.05", "")
    print("| inner | step, fs | stretch, eV | shear, eV | bending, eV | pair, eV | kinetic, eV "
          "| position, A |")
    print("|---|---|---|---|---|---|---|---|")
    exact = None
    for inner, dt in [(1, 10), (1, 20), (1, 25), (2, 5), (2, 10), (2, 20), (2, 30), (3, 20),
                      (3, 30)]:
        status, _, table, position = run(folder, f"{symmetric} {LOCAL}", dt, inner,
                                         f"-ts_max_steps {round(30000 / dt)}")
        if status:
            print(f"| {inner} | {dt} | unstable |")
            continue
        exact = position if exact is None else exact
        row = " | ".join(f"{table[c][-1]:.3f}" for c in ("stretch", "shear", "bending", "pair"))
        print(f"| {inner} | {dt} | {row} | {table.motion[-1]:.1g} | {rms(position - exact):.2g} |",
              flush=True)


# Cost of a step

def cost(folder):
    big = {"weave, 6 between crossings": WEAVE.replace("6,6", "24,24").replace("36", "144"),
           "weave, 10 between crossings": WEAVE.replace("6,6", "20,20").replace("36", "200"),
           "bundle": BUNDLE}
    print("| scene | inner | cost of a step |\n|---|---|---|")
    for name, options in big.items():
        steps = 150 if "weave" in name else 400
        seconds = {k: [] for k in (1, 2, 3)}
        for _, k in itertools.product(range(7), seconds):
            _, text, _, _ = run(folder, options, 10, k,
                                f"-ts_max_steps {steps} -monitor_interval 1000")
            speed = next(line for line in text.splitlines() if line.startswith("speed"))
            seconds[k].append(1 / float(speed.split()[1]))
        for k, found in seconds.items():
            ratio = np.array(found) / np.array(seconds[1])
            print(f"| {name} | {k} | {np.median(ratio):.3f} "
                  f"({ratio.min():.2f} to {ratio.max():.2f}) |", flush=True)


# Linear theory

AMU, GPA = 103.642697, 6.241509e-3
rf, h, E, G = 6.78, 3.35, 1029 * GPA, 459 * GPA
T, mass = 2 * rf, 2649 * AMU
inertia = mass * rf**2
S, J = 2 * np.pi * h * rf, np.pi * h * rf * (rf**2 + h**2 / 4)
B1, B2, B4 = E * S / T, 12 * E * J / T, G * 2 * J / T
B3 = -2 * E * J / T - B4 / 2
CONTACT = 6 * 400 / 3  # eV/A^2: six neighbours, 2k/n each


def chain_matrix(q):
    """Mass-weighted stiffness of deflection and rotation
    of a straight chain at phase q a segment."""
    bend = B2 / 4 + B3 + B4 / 2
    ww = 2 * B2 / T**2 * (1 - np.cos(q)) / mass
    tt = (B2 / 4 * (2 + 2 * np.cos(q)) + bend * (2 - 2 * np.cos(q))) / inertia
    wt = B2 / T * np.sin(q) / np.sqrt(mass * inertia)
    return np.array([[ww, wt], [wt, tt]])


def contact_matrix(part):
    """Contacts at three points on each axis, opposite each other: they resist rotation too."""
    lever2 = 2 / 3 * (T / 3)**2
    return part * CONTACT * np.diag([1 / mass, lever2 / inertia])


def growth(bond, pair, H, inner):
    """Largest eigenvalue, by magnitude, of one outer step of the (x, v) of one wave."""
    one, zero = np.eye(2), np.zeros((2, 2))
    kick = lambda a, t: np.block([[one, zero], [-t * a, one]])  # noqa: E731
    drift = lambda t: np.block([[one, t * one], [zero, one]])  # noqa: E731
    t = H / inner
    step = kick(bond, t / 2) @ drift(t) @ kick(bond, t / 2)
    whole = kick(pair, H / 2) @ np.linalg.matrix_power(step, inner) @ kick(pair, H / 2)
    return np.abs(np.linalg.eigvals(whole)).max()


def theory(_):
    phases = np.linspace(0.01, np.pi, 60)
    chains = [chain_matrix(q) for q in phases]
    highest = np.sqrt(max(np.linalg.eigvalsh(a)[-1] for a in chains))
    print(f"highest frequency of a free chain {highest:.5f} /fs, limit {2 / highest:.2f} fs; "
          f"of the contacts alone {2 * np.sqrt(mass / CONTACT):.2f} fs")
    steps = np.arange(20, 100, 0.1)
    inner_steps = (1, 2, 3, 4, 32)
    print("| contacts | " + " | ".join(f"k = {k}" for k in inner_steps) + " |\n"
          + "|---" * (len(inner_steps) + 1) + "|")
    for part in (0.001, 0.05, 0.1, 0.25, 0.5, 1):
        first = []
        for k in inner_steps:
            bad = (H for H in steps
                   if max(growth(a, contact_matrix(part), H, k) for a in chains) > 1 + 1e-6)
            first.append(next(bad, np.inf))
        print(f"| {part} | " + " | ".join(f"{x:.1f}" for x in first) + " |", flush=True)
    print("\nOne wave whose bonds and contacts have one eigenvector, exact inner motion:")
    for part in (0.1, 0.25, 0.5, 1):
        w2 = part * CONTACT / mass
        H = np.arange(1, 75, 0.01)
        print(f"  contacts {part}: H w_p^2/(2 w_b) tan(w_b H/2) < 1 up to "
              f"{H[H * w2 / (2 * highest) * np.tan(highest * H / 2) < 1].max():.1f} fs; "
              f"one step {2 / np.sqrt(highest**2 + w2):.1f} fs")


if __name__ == "__main__":
    if len(sys.argv) != 2 or sys.argv[1] not in ("theory", "limits", "errors", "tension", "rest",
                                                 "cost"):
        sys.exit(__doc__)
    with tempfile.TemporaryDirectory() as name:
        generators.bundle(f"{name}/bundle.h5", rings=3)
        straight(f"{name}/straight.h5")
        globals()[sys.argv[1]](Path(name))
