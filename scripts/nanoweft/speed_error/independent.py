"""What the solver should give, computed without it: two tubes, elastica, vibrating beam."""

import numpy as np

EPSILON, A, B, ALPHA, BETA, STIFFNESS = 0.07124, 0.0223, 1.31, 9.5, 4.0, 200.0
RADIUS, LENGTH = 6.78, 13.56
EV_PER_GPA_A3, AMU = 6.241509074e-3, 103.642697
WALL, YOUNG, MASS = 3.35, 1029 * EV_PER_GPA_A3, 2649 * AMU
EJ = YOUNG * np.pi * WALL * RADIUS * (RADIUS**2 + WALL**2 / 4)
ES = YOUNG * 2 * np.pi * WALL * RADIUS
LINE_DENSITY, ROTARY_DENSITY = MASS / LENGTH, MASS * RADIUS**2 / LENGTH


def bisect(function, low, high, rounds=200):
    """Root of a function that is negative at `low` and positive at `high`."""
    for _ in range(rounds):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if function(middle) < 0 else (low, middle)
    return 0.5 * (low + high)


def raw(r):
    d = r / RADIUS - 2
    return 4 * EPSILON * (A * d**-ALPHA - B * d**-BETA)


def raw_slope(r):
    d = r / RADIUS - 2
    return 4 * EPSILON / RADIUS * (BETA * B * d**(-BETA - 1) - ALPHA * A * d**(-ALPHA - 1))


def raw_curvature(r):
    d = r / RADIUS - 2
    return 4 * EPSILON / RADIUS**2 * (ALPHA * (ALPHA + 1) * A * d**(-ALPHA - 2)
                                      - BETA * (BETA + 1) * B * d**(-BETA - 2))


SPLICE = {"kink": bisect(raw_slope, 15.0, 20.0),
          "smooth": bisect(lambda r: 2 * STIFFNESS - raw_curvature(r), 14.0, 18.0)}


def step(x):
    """From 0 to 1, twice continuously differentiable."""
    x = np.clip(x, 0, 1)
    return x**3 * (10 - x * (15 - 6 * x))


def law(r, splice, switch, cutoff):
    rs = SPLICE[splice]
    far = np.maximum(r, rs)
    u = np.where(r > rs, raw(far), raw(rs) + raw_slope(rs) * (r - rs) + STIFFNESS * (r - rs)**2)
    return u * (1 - step((r - switch) / (cutoff - switch)))


def spring(r, begin, *options):
    """The far part of a law: the law from `begin` on, within it a spring of the same slope."""
    step = 1e-3
    slope = (law(begin + step, *options) - law(begin - step, *options)) / (2 * step)
    within = law(begin, *options) + slope / (2 * begin) * (r**2 - begin**2)
    return np.where(r > begin, law(r, *options), within)


def pair_energies(d, along, n, T, energy):
    """U_ij of parallel segments at distance d whose centres are `along` apart;
    `energy` is one per length squared."""
    shift = (np.arange(n)[:, None] - np.arange(n)) * T / n
    r = np.sqrt(d[..., None, None]**2 + (along[..., None, None] + shift)**2)
    return (T / LENGTH)**2 * energy(r).mean(axis=(-1, -2))


def tube_energy(d, offset, n, T=LENGTH, splice="smooth", switch=3 * LENGTH, cutoff=4 * LENGTH,
                far=None):
    """Energy per length of two infinite parallel tubes; `far`: points of the far part, and where
    it begins."""
    d, offset = np.broadcast_arrays(np.asarray(d, float), np.asarray(offset, float))
    reach = int(np.ceil(cutoff / T)) + 1
    along = offset[..., None] + T * np.arange(-reach, reach + 1)
    across = np.broadcast_to(d[..., None], along.shape)
    options = splice, switch, cutoff
    if not far:
        return pair_energies(across, along, n, T, lambda r: law(r, *options)).sum(-1) / T
    m, begin = far
    u = pair_energies(across, along, n, T, lambda r: law(r, *options) - spring(r, begin, *options))
    u += pair_energies(across, along, m, T, lambda r: spring(r, begin, *options))
    return u.sum(-1) / T


def resting_energies(n, T=LENGTH, offsets=16, **options):
    """Energy per length at the best distance for offsets over one segment."""
    # The energy repeats after a point's spacing (after a segment if the law is split).
    period = T if options.get("far") else T / n
    offset = np.arange(offsets) * period / offsets
    low, high = np.full(offsets, 15.5), np.full(offsets, 19.5)
    golden = 0.5 * (np.sqrt(5) - 1)
    for _ in range(45):
        a, b = high - golden * (high - low), low + golden * (high - low)
        left = tube_energy(a, offset, n, T, **options) < tube_energy(b, offset, n, T, **options)
        low, high = np.where(left, low, a), np.where(left, b, high)
    return tube_energy(0.5 * (low + high), offset, n, T, **options)


def elastica_tip(load, length):
    """x/L and y/L of the tip of a clamped tube under a transverse dead load P with P L^2/EJ = load.
    The tube is extensible, as the solver's is: at these loads it grows by a tenth of a percent."""
    stretch = load * EJ / length**2 / ES

    def rate(s):
        sine, cosine = np.sin(s[0]), np.cos(s[0])
        grown = 1 + stretch * sine
        return np.array([s[1], -load * grown * cosine, grown * cosine, grown * sine])

    def shoot(curvature, steps):
        h, s = 1.0 / steps, np.array([0.0, curvature, 0.0, 0.0])
        for _ in range(steps):
            k1 = rate(s)
            k2 = rate(s + 0.5 * h * k1)
            k3 = rate(s + 0.5 * h * k2)
            s = s + h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(s + h * k3))
        return s
    # Too little curvature at the clamp bends the tip back.
    clamp = bisect(lambda curvature: shoot(curvature, 200)[1], 0.0, load, rounds=40)
    return shoot(clamp, 200)[2:]


def free_beam_frequency(length, elements):
    """Lowest bending frequency (rad/fs) of a free tube: Hermite elements, masses and rotary
    inertias at the middle of `elements` equal pieces."""
    T = length / elements
    block = EJ / T**3 * np.array([[12, 6 * T, -12, 6 * T], [6 * T, 4 * T**2, -6 * T, 2 * T**2],
                                  [-12, -6 * T, 12, -6 * T], [6 * T, 2 * T**2, -6 * T, 4 * T**2]])
    K = np.zeros((2 * elements, 2 * elements))
    for e in range(elements - 1):
        K[2 * e:2 * e + 4, 2 * e:2 * e + 4] += block
    scale = 1 / np.sqrt(np.tile([LINE_DENSITY * T, ROTARY_DENSITY * T], elements))
    # The two lowest are the rigid motions.
    return np.sqrt(np.linalg.eigvalsh(K * scale[:, None] * scale)[2])
