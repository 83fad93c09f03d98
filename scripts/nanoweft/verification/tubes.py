"""Two parallel tubes: adhesion, best distance, corrugation,
and the force that pulls one off the other."""
import math

import numpy as np

from .. import states, tables
from ..beams import TUBE
from .common import CURVES, Row, in_plane, new_folder, relative, simulate, write_state

T, RF = TUBE.T, TUBE.radius
EPS, A, B, ALPHA, BETA, K = 0.07124, 0.0223, 1.31, 9.5, 4.0, 200.0
SWITCH, CUTOFF = 3 * T, 4 * T
BEST = RF * (2 + (ALPHA * A / (BETA * B)) ** (1 / (ALPHA - BETA)))
SEGMENTS = 24


def attraction(r, derivative=0):
    D, value = r / RF - 2, 0
    for factor, power in ((A, ALPHA), (-B, BETA)):
        term = factor * D ** (-power)
        for k in range(derivative):
            term = term * -(power + k) / (D * RF)
        value = value + term
    return 4 * EPS * value


def join(splice):
    """Where the repulsion joins: at the minimum, or where the curvature is 2k."""
    if splice == "kink":
        return BEST
    low, high = 2.2 * RF, BEST
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if attraction(middle, 2) > 2 * K else (low, middle)
    return low


def law(r, splice, cut=True):
    s = join(splice)
    near = attraction(s) + attraction(s, 1) * (r - s) + K * (r - s)**2
    u = np.where(r > s, attraction(np.maximum(r, s)), near)
    if not cut:
        return u
    x = np.clip((r - SWITCH) / (CUTOFF - SWITCH), 0, 1)
    return u * (1 - x**3 * (10 - 15 * x + 6 * x**2))


def energy(distance, slide, points, splice):
    """Energy per length of two infinite tubes:
    a sum over the points of both in one segment and its images."""
    z = np.arange(-12 * points, 12 * points + 1) * T / points
    return np.sum(law(np.hypot(distance, z + slide), splice)) / (points * T)


def continuous(distance, splice, cut):
    """Energy per length without points: the integral over both axes."""
    reach = CUTOFF if cut else 40 * CUTOFF
    z = np.linspace(0, reach, 100001)
    f = law(np.hypot(distance, z), splice, cut)
    h = z[1]
    return 2 * h * (f[0] + 4 * f[1:-1:2].sum() + 2 * f[2:-1:2].sum() + f[-1]) / 3 / T**2


def best(function, low=15.0, high=18.3):
    """Where the least value over the distance is, and the value, by golden sections."""
    g = (math.sqrt(5) - 1) / 2
    for _ in range(60):
        a, b = high - g * (high - low), low + g * (high - low)
        low, high = (low, b) if function(a) < function(b) else (a, high)
    return (low + high) / 2, function((low + high) / 2)


def program_energy(folder, distance, slide, points, splice):
    x = np.zeros((SEGMENTS, 3))
    x[:, 0] = np.arange(SEGMENTS) * T
    q = in_plane(np.zeros(SEGMENTS))
    write_state(folder / "in.h5", [(x, q), (x + [slide, distance, 0], q)], period=SEGMENTS * T,
                closed=True)
    (folder / "energy.csv").unlink(missing_ok=True)
    simulate(folder.name, "-scene file -scene_file {dir}/in.h5 -ts_max_steps 0 -energy_monitor "
             f"ascii:{{dir}}/energy.csv -pair_points {points} -vdw_splice {splice}")
    return tables.read(folder / "energy.csv")["pair"][0] / (SEGMENTS * T)


def adhesion():
    rows = []
    for splice in ("smooth", "kink"):
        folder = new_folder(f"adhesion_{splice}")
        where, value = best(lambda d: energy(d, 0.0, 7, splice))
        measured = program_energy(folder, where, 0.0, 7, splice)
        rows.append(relative("adhesion", f"{splice}, 7 points, eV/A: own sum", value, measured,
                             1e-10, "round-off of the sums"))
        # Least energy over the distance, from the program alone:
        # a parabola through five distances' energies.
        d = where + 0.02 * np.arange(-2, 3)
        e = [program_energy(folder, k, T / 28, 7, splice) for k in d]
        fit = np.polyfit(d - where, e, 4)
        roots = np.roots(np.polyder(fit))
        found = where + roots[np.argmin(np.abs(roots))].real
        exact, least = best(lambda d: continuous(d, splice, True))
        shift = max(abs(best(lambda d: energy(d, s, 7, splice))[0] - exact)
                    for s in (0, T / 28, T / 14))
        rows.append(Row("adhesion", f"{splice}, best distance, A: integral over both tubes", exact,
                        found, abs(found - exact), shift + 1e-4,
                        "7 points for the integral, and the fit"))
        spread = max(abs(energy(exact, s, 7, splice) / least - 1) for s in (0, T / 28, T / 14))
        rows.append(relative("adhesion", f"{splice}, energy, eV/A: integral over both tubes", least,
                             program_energy(folder, exact, T / 28, 7, splice), spread + 1e-9,
                             "7 points for the integral"))
        CURVES[f"adhesion_{splice}"] = [
            (k, energy(k, 0, 7, splice)) for k in np.linspace(16.2, 30, 200)]
        CURVES[f"adhesion_{splice}_program"] = [
            (k, program_energy(folder, k, 0.0, 7, splice))
            for k in (16.5, 16.8, 17.1, 17.4, 17.8, 18.5, 20, 22, 25, 28)]
    return rows


def corrugation(splice):
    """Spread of the least energy over the distance as one tube slides,
    over the strongest adhesion."""
    rows, curve = [], []
    folder = new_folder(f"corrugation_{splice}")
    for points in (1, 2, 3, 4, 5, 7):
        slides = np.arange(9) / 8 * T / points / 2
        own, found = [], []
        for slide in slides:
            where, value = best(lambda d: energy(d, slide, points, splice))
            own.append(value)
            found.append(program_energy(folder, where, slide, points, splice))
        spread = [100 * np.ptp(e) / abs(np.min(e)) for e in (own, found)]
        rows.append(Row("corrugation", f"{splice}, {points} points, %", spread[0], spread[1],
                        abs(spread[1] - spread[0]), 1e-8, "round-off of energies: 1e-10 of them"))
        curve.append((points, *spread))
    CURVES[f"corrugation_{splice}"] = curve
    return rows


def own_force(segments, distance, slides, points, h=1e-4):
    """The same force from differences of the energy of the finite tubes."""
    z = np.arange(segments * points) * T / points
    gap = z[None, :] - z[:, None] + 8 * T

    def total(slide):
        return np.sum(law(np.hypot(distance, gap + slide), "smooth")) / points**2
    return np.array([(total(s + h) - total(s - h)) / (2 * h) for s in slides])


def pull_off():
    """Force along the axis on a finite tube beside another, averaged over a slide by a segment.

    Each slide by T takes one segment out of contact, so the mean is the adhesion W with the points
    as they lie at the start. It is taken with Gauss's rule, as the corrugation is not periodic near
    the ends."""
    rows, n = [], 30
    folder = new_folder("pull_off")
    for points in (3, 5):
        where = best(lambda d: energy(d, 0, points, "smooth"))[0]
        expected = -energy(where, 0, points, "smooth")
        fibres, x, q = [], np.zeros((n, 3)), in_plane(np.zeros(n))
        x[:, 0] = np.arange(n) * T
        nodes, weights = np.polynomial.legendre.leggauss(32)
        slides = (1 + nodes) / 2 * T
        for k, slide in enumerate(slides):
            place = [0, 0, 300.0 * k]
            fibres += [(x + place, q), (x + place + [8 * T + slide, where, 0], q)]
        write_state(folder / "in.h5", fibres)
        simulate("pull_off",
                 "-scene file -scene_file {dir}/in.h5 -ts_max_steps 0 -state_output {dir}/out.h5 "
                 f"-state_forces -pair_points {points}")
        force = states.read(folder / "out.h5")["force"].reshape(-1, n, 3).sum(1)[1::2, 0]
        rule = abs(own_force(n, where, slides, points) @ weights / 2 / expected - 1)
        rows.append(relative("pull-off",
                             f"mean force along the axis, eV/A, {points} points: adhesion W",
                             expected, -force @ weights / 2, 2 * rule + 1e-9,
                             "twice the error of the same rule with an own force"))
        CURVES[f"pull_off_{points}"] = np.column_stack([slides / T, -force])
    return rows


CHECKS = {"adhesion": adhesion, "corrugation_smooth": lambda: corrugation("smooth"),
          "corrugation_kink": lambda: corrugation("kink"), "pull_off": pull_off}
