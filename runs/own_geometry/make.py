#!/usr/bin/python3
"""Two tubes side by side, 20 A apart, as a state file: python3 make.py FILE"""
import sys

import h5py
import numpy as np

n, T = 100, 13.56
x = np.zeros((2 * n, 3))
x[:, 0] = np.tile(np.arange(n) * T, 2)
x[n:, 1] = 20.0
with h5py.File(sys.argv[1], "w") as f:
    g = f.create_group("state")
    g.attrs.update(format="nanoweft-state", version=1, step=0, time=0.0, units="nano",
                   lower=[-100.0, -100.0, -100.0], upper=[n * T + 100, 120.0, 100.0],
                   periodic=[0, 0, 0])
    g["position"] = x
    g["orientation"] = np.tile([1.0, 0.0, 0.0, 0.0], (2 * n, 1))  # axis along x
    g["fibre"] = np.repeat([0, 1], n)
    g["index"] = np.tile(np.arange(n), 2)
