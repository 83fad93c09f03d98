"""Small bending motions of a chain, from its bonds' energy for small angles.

A bond with chord r between nodes with deflection y and rotation f has the angles
t = f - (y_j - y_i)/r against its chord and the energy
2 EJ/T (t1^2 + t1 t2 + t2^2) - P (y_j - y_i)^2/(2 r) under compression P.
Nodes have mass m and inertia I. Degrees of freedom: y_0, f_0, y_1, f_1, ..."""
import numpy as np

from ..beams import TUBE


def matrices(nodes, compression=0.0, tube=TUBE):
    stiffness = np.zeros((2 * nodes, 2 * nodes))
    r = tube.T - compression / tube.B1
    t1, t2 = np.array([1 / r, 1, -1 / r, 0]), np.array([1 / r, 0, -1 / r, 1])
    lean = np.array([-1.0, 0, 1, 0])
    bond = 2 * tube.EJ / tube.T * (2 * np.outer(t1, t1) + np.outer(t1, t2) + np.outer(t2, t1)
                                   + 2 * np.outer(t2, t2)) - compression / r * np.outer(lean, lean)
    for k in range(nodes - 1):
        stiffness[2 * k:2 * k + 4, 2 * k:2 * k + 4] += bond
    return stiffness, np.tile([tube.m, tube.I], nodes)


def modes(nodes, held, compression=0.0, tube=TUBE):
    """Squared frequencies and shapes (columns, all degrees of freedom), lowest first."""
    stiffness, mass = matrices(nodes, compression, tube)
    free = np.setdiff1d(np.arange(2 * nodes), held)
    root = np.sqrt(mass[free])
    squared, vectors = np.linalg.eigh(stiffness[np.ix_(free, free)] / np.outer(root, root))
    shapes = np.zeros((2 * nodes, len(free)))
    shapes[free] = vectors / root[:, None]
    return squared, shapes


def critical_load(nodes, held):
    """Compression at which the lowest mode's frequency vanishes."""
    low, high = 0.0, np.pi**2 * TUBE.EJ / (TUBE.T * (nodes - 1)) ** 2 * 1.5
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if modes(nodes, held, middle)[0][0] > 0 else (low, middle)
    return (low + high) / 2
