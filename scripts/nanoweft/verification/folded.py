"""A fibre that holds on to itself: racket and ring beside the straight fibre.

The length that counts is l = sqrt(EJ/W), W the adhesion per length. E and G are lowered until
l = 8 T. Closed forms: a racket's head has the length 6.055 l and the racket has less energy than
the straight fibre beyond 12.11 l; a ring of one turn and an overlap, taken as a circle, beyond
11.54 l. They hold for thin tubes with adhesion of no range. Here tubes have their distance
d = 0.16 l and attract each other a few A further, so the racket's energy is also computed from a
planar curve with the tubes' own energy e(distance)."""
import math

import numpy as np

from .. import tables
from ..beams import TUBE, Tube
from .common import CURVES, RESULTS, Rest, Row, in_plane, relative, settle
from .tubes import best, energy, law

T, POINTS = TUBE.T, 5
DISTANCE, W = (lambda pair: (pair[0], -pair[1]))(best(lambda d: energy(d, 0, POINTS, "smooth")))
REACH = 8 * T
SOFT = W * REACH**2 / TUBE.EJ
FIBRE = Tube(1029 * SOFT, 459 * SOFT)
SIZES = (80, 120)


def options(fineness):
    """Segments `fineness` times shorter."""
    return (f"-fibre_young {1029 * SOFT!r} -fibre_shear {459 * SOFT!r} "
            f"-fibre_segment_length {T / fineness!r} -pair_points {POINTS} -ts_dt {20 / fineness} "
            "-energy_monitor ascii:{dir}/energy.csv -monitor_interval 2000 ")


def head(width):
    """Half of a racket's head, lengths in l, whose ends are `width` apart:
    angle, x from the axis, arc length.

    f'' = -v cos f, f' = 1 where contact ends (EJ f'^2 = W), f = -pi/2 and x = 0 at the tip."""
    def path(v, h=1e-3):
        u, rows = np.array([0.0, 1.0, width / 2]), []

        def slope(u):
            return np.array([u[1], -v * math.cos(u[0]), math.sin(u[0])])
        while u[0] > -math.pi / 2:
            rows.append(u)
            k1 = slope(u)
            k2 = slope(u + h / 2 * k1)
            k3 = slope(u + h / 2 * k2)
            u = u + h / 6 * (k1 + 2 * k2 + 2 * k3 + slope(u + h * k3))
        share = (-math.pi / 2 - rows[-1][0]) / (u[0] - rows[-1][0])
        rows.append(rows[-1] + share * (u - rows[-1]))
        s = h * np.arange(len(rows))
        s[-1] = s[-2] + share * h
        return np.array(rows), s
    low, high = 0.52, 3.0
    for _ in range(45):
        v = (low + high) / 2
        low, high = (v, high) if path(v)[0][-1, 2] > 0 else (low, v)
    rows, s = path(v)
    bending = np.sum((rows[1:, 1]**2 + rows[:-1, 1]**2) / 2 * np.diff(s))
    return rows[:, 0], rows[:, 2], s, bending


def tubes(distances, h=1e-3):
    """Energy per length of infinite tubes at these distances, with its first two derivatives."""
    z = np.arange(-12 * POINTS, 12 * POINTS + 1) * T / POINTS
    low, here, high = (law(np.hypot(distances[:, None] + k, z), "smooth").sum(1) / (POINTS * T)
                       for k in (-h, 0, h))
    return here, (high - low) / (2 * h), (high - 2 * here + low) / h**2


def curve(half_length, cells=300, reach=REACH):
    """Least energy of a racket: a planar inextensible curve
    with the tubes' energy at their distance 2 x.

    Unknown are the angles of its cells from the tip on;
    Newton's method with a shift that keeps it downhill."""
    h = half_length / cells
    middle = (np.arange(cells) + 0.5) * h
    angle, _, s, _ = head(DISTANCE / reach)
    length = s[-1] * reach
    f = np.where(middle < length, np.interp(length - middle, s * reach, -angle), 0.0)
    across = h * (np.tril(np.ones((cells, cells))) - np.eye(cells) / 2)
    # The tip, half a cell before the first, has the angle pi/2.
    stiff = 2 * np.eye(cells) - np.eye(cells, k=1) - np.eye(cells, k=-1)
    stiff[0, 0], stiff[-1, -1] = 3, 1
    stiff *= W * reach**2 / h
    # Segments less than 20 apart do not see each other.
    seen = middle > 10 * T

    def parts(f):
        x = across @ np.sin(f)
        e, slope, bend = tubes(np.where(seen, 2 * x, 100 * T))
        return (f - math.pi / 2) @ stiff @ (f - math.pi / 2) + h * e.sum(), h * slope, h * bend
    shift, now = 1.0, parts(f)
    for _ in range(200):
        gradient = 2 * stiff @ (f - math.pi / 2) + 2 * np.cos(f) * (across.T @ now[1])
        curvature = (2 * stiff + 4 * np.outer(np.cos(f), np.cos(f))
                     * (across.T @ (now[2][:, None] * across))
                     - np.diag(2 * np.sin(f) * (across.T @ now[1])))
        step = np.linalg.solve(curvature + shift * np.eye(cells), -gradient)
        new = parts(f + step)
        if new[0] < now[0] and np.abs(step).max() < 0.5:
            f, now, shift = f + step, new, shift / 4
        elif np.abs(step).max() < 1e-10:
            break
        else:
            shift *= 8
    return now[0], across @ np.sin(f), middle


def missing_end():
    """What two tubes that end together lack beside endless ones: pairs across the end."""
    k = np.arange(1, 12 * POINTS)
    return -np.sum(k * law(np.hypot(DISTANCE, k * T / POINTS), "smooth")) / POINTS**2


def racket_start(segments, T=T, reach=REACH):
    """A racket whose bending stiffness over its adhesion per length is the square of `reach`."""
    angle, x, s, _ = head(DISTANCE / reach)
    angle, x, s = angle[::-1], x[::-1] * reach, (s[-1] - s[::-1]) * reach
    y = np.concatenate([[0], np.cumsum(np.diff(s) * np.cos((angle[1:] + angle[:-1]) / 2))])
    at = (np.arange(segments // 2) + 0.5) * T
    beyond = np.maximum(at - s[-1], 0)
    px = np.interp(at, s, x)
    py = np.interp(at, s, y) + beyond
    pf = np.where(at < s[-1], np.interp(at, s, -angle), 0.0)
    # x of the half curve is the file's z, and y its x; the other half is its mirror image.
    right = np.column_stack([py, 0 * py, px])
    place = np.vstack([right[::-1] * [1, 1, -1], right])
    return place, in_plane(np.concatenate([math.pi - pf[::-1], pf]))


def ring_start(segments):
    """A helix of about one turn and an overlap, rising by the tubes' distance in a turn."""
    L = segments * T
    radius = (FIBRE.EJ * L / (2 * math.pi * W)) ** (1 / 3)
    rise = DISTANCE / (2 * math.pi)
    a = np.arange(segments) * T / math.hypot(radius, rise)
    x = np.column_stack([radius * np.cos(a), rise * a, radius * np.sin(a)])
    return x, in_plane(a + math.pi / 2)


def relaxed(name, start, fineness=1):
    """Energy of the bonds and pairs after damping, and the state."""
    state = settle(name, [start], None, options(fineness), 4000 * fineness,
                   Rest(1e-7, 240000 * fineness))
    table = tables.read(RESULTS / name / "energy.csv")
    CURVES[name] = state.whole
    parts = "stretch", "shear", "bending", "torsion", "pair"
    return sum(table[part][-1] for part in parts), state


def racket():
    rows, energies, expected = [], {}, {}
    _, _, s, bending = head(0.0)
    closed = 2 * s[-1]
    if abs(closed - 6.055) > 5e-4 or abs(2 * bending + closed - 12.11) > 5e-3:
        raise ArithmeticError("racket: the integration misses the published digits")
    for n in SIZES:
        energies[n], state = relaxed(f"racket_{n}", racket_start(n))
        if n == SIZES[0]:
            coarse = state
            own_energy, x, _ = curve(n * T / 2)
            expected[n] = own_energy + missing_end()
        thin = W * (bending * REACH + closed * REACH / 2 - n * T / 2)
        rows.append(Row("racket", f"{n * T / REACH:.2f} l long, energy, eV: thin tubes; same sign",
                        thin, energies[n], abs(energies[n] - thin), abs(thin),
                        "the sign: which state wins"))
    n, more = SIZES[0], SIZES[1] - SIZES[0]
    rows.append(relative("racket", "energy of a longer arm, eV/A", arm(),
                         (energies[n + more] - energies[n]) / (more * T), 1e-5,
                         "settling and the points' corrugation, 2e-5 of W at most"))
    fine, fine_state = relaxed(f"racket_{n}_fine", racket_start(2 * n, T / 2), 2)

    def critical(e):
        return 2 * (e + W * n * T / 2) / (W * REACH)
    found = [(critical(energies[n]), critical(fine)), (width(coarse), width(fine_state))]
    own = [critical(expected[n]), 2 * x.max()]
    for what, (first, second), value in zip(("critical length over l", "width of the head, A"),
                                            found, own):
        limit = (4 * second - first) / 3
        rows.append(Row("racket", what + ", limit T = 0: curve with the tubes' energy", value,
                        limit, abs(limit / value - 1), abs(second - first) / 3 / value,
                        "the last step of the extrapolation to T = 0"))
    rows.append(relative("racket", "critical length over l: thin tubes, no range",
                         2 * bending + closed, found[0][1],
                         math.sqrt(DISTANCE / REACH) / 4,
                         "thickness and range: a quarter of the root of d/l"))
    return rows


def width(state):
    """Between the two widest places: of parabolas through the outermost node and its neighbours."""
    z = state.whole[:, 2]
    k = np.argmax(z)
    a, b, c = z[k - 1:k + 2]
    top = b - (c - a)**2 / (8 * (a - 2 * b + c))
    k = np.argmin(z)
    a, b, c = z[k - 1:k + 2]
    return top - (b - (c - a)**2 / (8 * (a - 2 * b + c)))


def arm():
    """Energy per length of fibre of two tubes side by side, which adhesion shortens a little."""
    k = np.arange(-8, 9)
    a = (np.arange(POINTS) - (POINTS - 1) / 2) * T / POINTS

    def value(strain, distance):
        z = k[:, None, None] * T * (1 + strain) + a[:, None] - a[None, :]
        return (law(np.hypot(distance, z), "smooth").sum() / POINTS**2
                + FIBRE.B1 * (strain * T)**2) / (2 * T)
    return min(best(lambda d: value(strain, d))[1] for strain in np.linspace(-2e-3, 0, 41))


def ring():
    """As a circle: E = EJ L/(2 R^2) - W (L - 2 pi R), least at R^3 = EJ L/(2 pi W)."""
    rows = []
    for n in (76, 112):
        L = n * T
        radius = (FIBRE.EJ * L / (2 * math.pi * W)) ** (1 / 3)
        circle = FIBRE.EJ * L / (2 * radius**2) - W * (L - 2 * math.pi * radius)
        found, _ = relaxed(f"ring_{n}", ring_start(n))
        rows.append(Row("ring", f"{L / REACH:.2f} l long, energy, eV: thin circle; same sign",
                        circle, found, abs(found - circle), abs(circle),
                        "the sign: which state wins"))
    return rows


CHECKS = {"racket": racket, "ring": ring}
