"""Rotations of many segments at once: unit quaternions (w, x, y, z) and matrices."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[Any]


def rotation_about(axis: ArrayLike, angle: ArrayLike) -> Array:
    """Unit quaternions of rotations about one axis."""
    angle = np.atleast_1d(angle)
    q = np.zeros((len(angle), 4))
    q[:, 0] = np.cos(angle / 2)
    q[:, 1:] = np.sin(angle / 2)[:, None] * np.asarray(axis, float) / np.linalg.norm(axis)
    return q


def multiply(p: Array, q: Array) -> Array:
    w, v, u, r = p[..., 0], p[..., 1:], q[..., 0], q[..., 1:]
    vector = w[..., None] * r + u[..., None] * v + np.cross(v, r)
    return np.concatenate([(w * u - np.sum(v * r, -1))[..., None], vector], -1)


def matrices(q: Array) -> Array:
    """Rotation matrices, whose columns are e1, e2, e3."""
    w, x, y, z = np.moveaxis(q, -1, 0)
    return np.moveaxis(np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]), -1, 0)


def rotation_vectors(q: Array) -> Array:
    """Axes times angles, between 0 and pi, of unit quaternions."""
    q = np.where(q[:, :1] < 0, -q, q)
    sine = np.linalg.norm(q[:, 1:], axis=1)
    angle = 2 * np.arctan2(sine, q[:, 0])
    return np.asarray(q[:, 1:] * (angle / np.maximum(sine, 1e-300))[:, None])


def no_rotation(count: int) -> Array:
    """Axes along x."""
    return np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))


def along(position: Array) -> Array:
    """Orientations of the segments of one fibre,
    whose axes follow the curve through their centres."""
    e1 = np.gradient(position, axis=0)
    e1 /= np.linalg.norm(e1, axis=1)[:, None]
    q = np.column_stack([1 + e1[:, 0], np.zeros(len(position)), -e1[:, 2], e1[:, 1]])
    q[np.linalg.norm(q, axis=1) < 1e-6] = (0, 0, 1, 0)
    return np.asarray(q / np.linalg.norm(q, axis=1)[:, None])


def carried(axes: Array) -> Array:
    """Orientations with these axes [fibres, segments, 3], each turned on from the one before it
    by the least angle, so that fibres are not twisted. Neighbours must not be opposite."""
    start = np.repeat([[1.0, 0.0, 0.0]], len(axes), axis=0)
    q = np.empty((*axes.shape[:2], 4))
    for k in range(axes.shape[1]):
        before = axes[:, k - 1] if k else start
        turn = np.column_stack([1 + (before * axes[:, k]).sum(axis=1),
                                np.cross(before, axes[:, k])])
        turn /= np.linalg.norm(turn, axis=1)[:, None]
        q[:, k] = multiply(turn, q[:, k - 1]) if k else turn
    return q


def scalar_last(quaternion: Array, axis: str) -> Array:
    """(w, x, y, z) to (x, y, z, w), first turned so that the body's `axis` (x or z)
    is the fibre's axis."""
    w, x, y, z = quaternion.T
    if axis == "z":  # q (cos 45, 0, sin 45, 0): the body's z goes where its x was
        w, x, y, z = np.sqrt(0.5) * np.array([w - y, x - z, w + y, x + z])
    return np.stack([x, y, z, w], axis=1)
