"""The elastica: planar, inextensible, EJ = L = 1; clamped at the origin along x,
a dead force at its end."""
import math

import numpy as np


def integrate(alpha, fx, fz, steps):
    """From the free end, where the angle is alpha, back to the clamp;
    rows: angle, curvature, x, z."""
    def slope(u):
        s, c = math.sin(u[0]), math.cos(u[0])
        return np.array([u[1], -(fz * c - fx * s), c, s])

    h, path = -1.0 / steps, [np.array([alpha, 0.0, 0.0, 0.0])]
    for _ in range(steps):
        u = path[-1]
        k1 = slope(u)
        k2 = slope(u + h / 2 * k1)
        k3 = slope(u + h / 2 * k2)
        k4 = slope(u + h * k3)
        path.append(u + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4))
    path = np.array(path[::-1])
    path[:, 2:] -= path[0, 2:]
    return path


def solve(fx, fz, guess, steps=800):
    """Angle, x and z at steps + 1 equidistant places, for a first guess of the angle at the end."""
    a, b = guess, guess * 1.001
    ya, yb = (integrate(g, fx, fz, steps)[0, 0] for g in (a, b))
    while abs(b - a) > 1e-14 and yb != ya:
        a, b, ya = b, b - yb * (b - a) / (yb - ya), yb
        yb = integrate(b, fx, fz, steps)[0, 0]
    path = integrate(b, fx, fz, steps)
    return path[:, 0], path[:, 2], path[:, 3]


def complete_integrals(k):
    """K(k), E(k) by the arithmetic-geometric mean."""
    a, b, c, total, power = 1.0, math.sqrt(1 - k * k), k, 0.5 * k * k, 0.5
    while abs(c) > 1e-16:
        a, b, c = (a + b) / 2, math.sqrt(a * b), (a - b) / 2
        power *= 2
        total += power * c * c
    return math.pi / (2 * a), math.pi / (2 * a) * (1 - total)


def buckled(ratio):
    """Clamped-free under ratio times the Euler load: angle, x/L, y/L of the end,
    from K(k), E(k)."""
    target = math.pi / 2 * math.sqrt(ratio)
    low, high = 0.0, 1 - 1e-12
    for _ in range(200):
        k = (low + high) / 2
        low, high = (k, high) if complete_integrals(k)[0] < target else (low, k)
    K, E = complete_integrals(k)
    return 2 * math.asin(k), 2 * E / K - 1, 2 * k / K
