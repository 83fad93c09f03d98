"""State files that the measurements start from."""

import h5py
import numpy as np

from .independent import LENGTH


def write(file, position, fibres, lower, upper, periodic, orientation=None, closed=False):
    """Fibres of equal numbers of segments, one after another."""
    n = len(position) // fibres
    with h5py.File(file, "w") as f:
        g = f.create_group("state")
        g.attrs.update(format="nanoweft-state", version=1, step=0, time=0.0, units="nano",
                       lower=np.array(lower, float), upper=np.array(upper, float),
                       periodic=np.array(periodic, np.int32))
        g["position"] = position
        g["orientation"] = (np.tile([1.0, 0, 0, 0], (len(position), 1)) if orientation is None
                            else orientation)
        g["fibre"] = np.repeat(np.arange(fibres), n)
        g["index"] = np.tile(np.arange(n), fibres)
        if closed:
            g["fibre_closed"] = np.arange(fibres)
    return file


def tubes(file, places, offsets, T, segments, noise=0.0, seed=1):
    """Endless tubes along x through the given places in the y-z plane."""
    places, random = np.asarray(places, float), np.random.default_rng(seed)
    x = np.zeros((len(places), segments, 3))
    x[:, :, 0] = np.arange(segments) * T + np.asarray(offsets)[:, None]
    x[:, :, 1:] = places[:, None, :]
    x += noise * random.standard_normal(x.shape)
    low, high = places.min(axis=0) - 150, places.max(axis=0) + 150
    return write(file, x.reshape(-1, 3), len(places), [0, *low], [segments * T, *high], [1, 0, 0],
                 closed=True)


def bundle(file, T=LENGTH, rings=4, length=16 * LENGTH, spacing=17.07, seed=1):
    """Hexagonally packed tubes, each shifted along itself and a little sideways."""
    random = np.random.default_rng(seed)
    places = [(spacing * (i + 0.5 * j), spacing * np.sqrt(0.75) * j)
              for i in range(-rings, rings + 1) for j in range(-rings, rings + 1)
              if abs(i + j) <= rings]
    places = np.array(places) + 0.05 * random.standard_normal((len(places), 2))
    return tubes(file, places, LENGTH * random.random(len(places)), T, round(length / T), 0.02, seed)


def free_mode(file, T, length, amplitude):
    """A free fibre bent, without stretch, as in its first bending mode."""
    n = round(length / T)
    k = 4.730040744862704 / length
    s = (np.arange(n) + 0.5) * T
    ratio = (np.cosh(k * length) - np.cos(k * length)) / (np.sinh(k * length) - np.sin(k * length))
    slope = k * (np.sinh(k * s) - np.sin(k * s) - ratio * (np.cosh(k * s) + np.cos(k * s)))
    angle = np.arctan(amplitude * slope)
    # A bond lies halfway between the directions of its ends: no shear.
    bond = 0.5 * (angle[1:] + angle[:-1])
    position = np.zeros((n, 3))
    position[1:, 0] = np.cumsum(T * np.cos(bond))
    position[1:, 1] = np.cumsum(T * np.sin(bond))
    orientation = np.stack([np.cos(angle / 2), 0 * s, 0 * s, np.sin(angle / 2)], axis=1)
    return write(file, position, 1, [-300, -300, -300], [length + 300, 300, 300], [0, 0, 0], orientation)
