#!/usr/bin/python3
"""Ping-pong between two ranks, started by scaling --measure: ns a message, ns per 64 bytes
(Open MPI)."""

import ctypes
import time

import numpy as np


def main():
    mpi = ctypes.CDLL("libmpi.so.40", mode=ctypes.RTLD_GLOBAL)

    def handle(name):
        return ctypes.c_void_p(ctypes.addressof(ctypes.c_char.in_dll(mpi, name)))

    world, byte = handle("ompi_mpi_comm_world"), handle("ompi_mpi_byte")
    mpi.MPI_Init(None, None)
    rank = ctypes.c_int()
    mpi.MPI_Comm_rank(world, ctypes.byref(rank))
    other = ctypes.c_int(1 - rank.value)
    out, into = (np.zeros(64 * 4096, np.uint8) for _ in range(2))

    def exchange(ghosts, rounds):
        count, tag = ctypes.c_int(64 * ghosts), ctypes.c_int(1)
        a, b = (ctypes.c_void_p(x.ctypes.data) for x in (out, into))
        begin = time.perf_counter()
        for _ in range(rounds):
            mpi.MPI_Sendrecv(a, count, byte, other, tag, b, count, byte, other, tag, world, None)
        return (time.perf_counter() - begin) / rounds * 1e9

    exchange(1, 1000)
    small = np.median([exchange(1, 200) for _ in range(50)])
    large = np.median([exchange(4096, 10) for _ in range(50)])
    if rank.value == 0:
        print(f"latency {small:.0f} ghost {(large - small) / 4095:.3f}")
    mpi.MPI_Finalize()


main()
