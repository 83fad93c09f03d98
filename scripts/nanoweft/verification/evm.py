"""The nonlinear chain: forces of the enhanced vector model, written anew from its energy

    U = B1/2 (r-T)^2 + B2/2 (n_j1 - n_i1).d + B3 n_i1.n_j1 - B4/2 (n_i2.n_j2 + n_i3.n_j3) + const

with n_i1 = e1_i, n_j1 = -e1_j, and the modes of its small motions about a state of equilibrium."""
import numpy as np

from ..rotations import matrices, multiply


def energies(x, frames, tube, shift=None):
    """Energy of each bond; with `shift` the last segment is bonded to the first, moved by it."""
    i, j, R, S = neighbours(x, frames, shift)
    gap = j - i
    r = np.linalg.norm(gap, axis=1)
    d = gap / r[:, None]
    a, b = R[:, :, 0], -S[:, :, 0]
    across = np.sum(R[:, :, 1] * S[:, :, 1] + R[:, :, 2] * S[:, :, 2], 1)
    return (tube.B1 / 2 * (r - tube.T)**2 + tube.B2 / 2 * np.sum((b - a) * d, 1)
            + tube.B3 * np.sum(a * b, 1) - tube.B4 / 2 * across + tube.B2 + tube.B3 + tube.B4)


def neighbours(x, frames, shift):
    if shift is None:
        return x[:-1], x[1:], frames[:-1], frames[1:]
    return x, np.vstack([x[1:], x[:1] + shift]), frames, np.roll(frames, -1, 0)


def gradient(x, frames, tube, shift=None):
    """Forces and torques, [n, 6]."""
    i, j, R, S = neighbours(x, frames, shift)
    gap = j - i
    r = np.linalg.norm(gap, axis=1)[:, None]
    d, a, b = gap / r, R[:, :, 0], -S[:, :, 0]
    w = b - a
    pull = tube.B1 * (r - tube.T) * d + tube.B2 / (2 * r) * (w - np.sum(w * d, 1)[:, None] * d)
    common = (tube.B3 * np.cross(a, b)
              - tube.B4 / 2 * (np.cross(R[:, :, 1], S[:, :, 1]) + np.cross(R[:, :, 2], S[:, :, 2])))
    total = np.zeros((len(x), 6))
    first = np.arange(len(i))
    second = (first + 1) % len(x)
    total[first, :3] += pull
    total[second, :3] -= pull
    total[first, 3:] += tube.B2 / 2 * np.cross(a, d) - common
    total[second, 3:] += -tube.B2 / 2 * np.cross(b, d) + common
    return total


def turned(q, angles):
    """Orientations after small rotations (vectors, space axes)."""
    size = np.linalg.norm(angles, axis=1)
    p = np.column_stack([np.cos(size / 2), np.sinc(size / (2 * np.pi))[:, None] / 2 * angles])
    return multiply(p, q)


def hessian(x, q, tube, shift=None, h=1e-5):
    """Second derivatives in displacements and rotations, by central differences."""
    n = len(x)
    result = np.empty((6 * n, 6 * n))
    for column in range(6 * n):
        u = np.zeros((n, 6))
        u[column // 6, column % 6] = h * (tube.T if column % 6 < 3 else 1)
        forward = gradient(x + u[:, :3], matrices(turned(q, u[:, 3:])), tube, shift)
        back = gradient(x - u[:, :3], matrices(turned(q, -u[:, 3:])), tube, shift)
        result[:, column] = (back - forward).ravel() / (2 * u[column // 6, column % 6])
    return (result + result.T) / 2


def modes(x, q, tube, shift=None):
    """Squared frequencies and shapes [6 n, modes], lowest first."""
    root = np.sqrt(np.tile([tube.m] * 3 + [tube.I] * 3, len(x)))
    squared, vectors = np.linalg.eigh(hessian(x, q, tube, shift) / np.outer(root, root))
    return squared, vectors / root[:, None]
