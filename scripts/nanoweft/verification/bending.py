"""Statics of one fibre: cantilever, beam on two supports, elastica, closed circle."""
import math

import numpy as np

from ..beams import TUBE
from ..rotations import matrices
from . import elastica
from .common import (
    CURVES, Rest, Row, angles_in_plane, in_plane, order, relative, richardson, settle)

T, EJ = TUBE.T, TUBE.EJ
CLAMP = "-pair none -bc root,tip -root_group 0 -root_fix 1,1,1 -root_fix_rotation -tip_group 1 "

# Tip angle, x/L, y/L: published digits, which the integration above must meet before it is used.
PUBLISHED = {0.5: (0.24453, 0.98408, 0.16214), 1: (0.46135, 0.94357, 0.30172),
             2: (0.78175, 0.83936, 0.49346), 3: (0.98602, 0.74558, 0.60325),
             5: (1.21537, 0.61237, 0.71379), 10: (1.43029, 0.44500, 0.81061)}


def period(segments):
    """Steps of 20 fs in a period of the lowest mode of a clamped-free fibre."""
    omega = 1.8751**2 * math.sqrt(EJ / TUBE.rho) / (segments * T) ** 2
    return 2 * math.pi / omega / 20


def straight(segments):
    x = np.zeros((segments + 1, 3))
    x[:, 0] = np.arange(segments + 1) * T
    return x


def ends(segments):
    groups = np.zeros(segments + 1, int)
    groups[0], groups[-1] = 1, 2
    return groups


def small_load_error(name, segments, shape, load, settled):
    """Worst error of a node over the largest deflection, extrapolated to no load from two loads."""
    x = straight(segments)
    found = [settled(f"{name}_{segments}_{k}", k * load)["position"][:, 2] / k for k in (1, 2)]
    deflection = (4 * found[0] - found[1]) / 3
    worst = np.argmax(np.abs(deflection - shape))
    largest = np.abs(shape).max()
    at = np.argmax(np.abs(shape))
    return shape[at], deflection[at], abs(deflection[worst] - shape[worst]) / largest


def beams():
    rows = []
    why = "fourth power of deflection/L = 1e-3, and settling to 1e-11 of the energy"
    for n in (1, 4, 10, 20, 40):
        L, s = n * T, straight(n)[:, 0]
        P = 1e-3 * 3 * EJ / L**2

        def cantilever(name, load):
            return settle(name, [(straight(n), in_plane(np.zeros(n + 1)))], ends(n),
                          CLAMP + f"-tip_force 0,0,{load!r}", max(period(n) / 3, 200), Rest(1e-11))
        shape = P * s**2 * (3 * L - s) / (6 * EJ)
        rows.append(Row("cantilever", f"deflection at the end, A, {n} bonds (error: worst node)",
                        *small_load_error("cantilever", n, shape, P, cantilever), 1e-9, why))
    for n in (2, 10, 20, 40):
        L, s = n * T, straight(n)[:, 0]
        P = 1e-3 * 48 * EJ / L**2
        groups = np.zeros(n + 1, int)
        groups[0], groups[-1], groups[n // 2] = 1, 2, 4

        def supported(name, load):
            return settle(name, [(straight(n), in_plane(np.zeros(n + 1)))], groups,
                          "-pair none -bc left,right,middle -left_group 0 -left_fix 1,1,1 "
                          "-right_group 1 -right_fix 0,1,1 -middle_group 2 "
                          f"-middle_force 0,0,{load!r}",
                          max(period(n) / 3, 200), Rest(1e-11))
        half = np.minimum(s, L - s)
        shape = P * half * (3 * L**2 - 4 * half**2) / (48 * EJ)
        rows.append(Row("two supports",
                        f"deflection at the centre, A, {n} bonds (error: worst node)",
                        *small_load_error("supported", n, shape, P, supported), 1e-9, why))
    return rows


def loaded(name, segments, fx, fz, exact):
    """Tip angle, x/L, z/L of the settled chain; it starts on the exact curve and moves off it."""
    angle, x, z = (part[::len(part) // segments] for part in exact)
    L = segments * T
    start = np.column_stack([x * L, 0 * x, z * L])
    f = EJ / L**2
    state = settle(f"{name}_{segments}", [(start, in_plane(angle))], ends(segments),
                   CLAMP + f"-state_forces -tip_force {fx * f!r},0,{fz * f!r}",
                   max(period(segments) / 3, 200), Rest(steps=1000000))
    CURVES[f"{name}_{segments}"] = state.whole[:, [0, 2]] / L
    CURVES[f"{name}_exact"] = np.column_stack([exact[1], exact[2]])
    end = state.whole[-1] / L
    return (np.array([angles_in_plane(state)[-1], end[0], end[2]]),
            unsettled(state, f * np.array([fx, 0, fz])))


def unsettled(state, load):
    """How far the end is from rest, over L: the forces left over,
    against a cantilever's stiffness."""
    n = len(state.whole) - 1
    L, s = n * T, np.arange(n + 1) / n
    force = state["force"].copy()
    force[-1] += load
    lean, tilt = s**2 * (3 - s) / 2, s * (2 - s) * 1.5 / L
    e1 = matrices(state["orientation"])[:, :, 0]
    across = force[:, 2] * e1[:, 0] - force[:, 0] * e1[:, 2]
    return abs(np.sum(across * lean - state["torque"][:, 1] * tilt)) * L**2 / (3 * EJ)


EXTRAPOLATED = "uncertainty of the extrapolation to T = 0, and forces left over"


def elastica_load(load):
    exact = elastica.solve(0, load, min(0.49 * load, 1.43))
    tip = np.array([part[-1] for part in exact])
    if np.abs(tip - PUBLISHED[load]).max() > 6e-6:
        raise ArithmeticError(f"elastica under {load}: the integration misses the published digits")
    settled = {n: loaded(f"elastica_{load}", n, 0, load, exact) for n in (10, 20, 40, 80)}
    found, left = {n: settled[n][0] for n in settled}, settled[80][1]
    CURVES.setdefault("convergence", {})[f"elastica {load}"] = [
        (n, abs(found[n][2] - tip[2])) for n in found]
    rows = []
    for k, what in enumerate(("angle of the end", "x/L", "y/L")):
        limit, doubt = richardson([found[n][k] for n in (20, 40, 80)])
        rows.append(Row("elastica", f"P L^2/EJ = {load}: {what}", tip[k], limit,
                        abs(limit - tip[k]), doubt + 2 * left, EXTRAPOLATED))
    errors = [np.abs(found[n] - tip).max() for n in (20, 40, 80)]
    rows.append(order_row("elastica", f"P L^2/EJ = {load}: order in T of the worst of the three",
                          errors))
    return rows


def order_row(family, name, errors):
    """The order from the two finest sizes; its distance from 2 must have fallen fourfold
    (here: twofold)."""
    coarse = abs(order(errors[:2]) - 2)
    return Row(family, name, 2.0, order(errors), abs(order(errors) - 2), max(coarse / 2, 1e-3),
               "half of the distance from 2 at the next coarser pair")


def circle():
    """A couple 2 pi EJ/L at the end. The bond's law:
    M = B2/2 sin(a/2) - B2/6 sin a for a bend of a."""
    rows, turns, gaps = [], [], []
    for n in (10, 20, 40, 80):
        L = n * T
        M = 2 * math.pi * EJ / L
        low, high = 0.0, 1.0
        for _ in range(100):
            a = (low + high) / 2
            moment = TUBE.B2 / 2 * math.sin(a / 2) - TUBE.B2 / 6 * math.sin(a)
            low, high = (a, high) if moment < M else (low, a)
        s = np.arange(n + 1) / n * 2 * math.pi
        start = np.column_stack([np.sin(s), 0 * s, 1 - np.cos(s)]) * L / (2 * math.pi)
        state = settle(f"circle_{n}", [(start, in_plane(s))], ends(n),
                       CLAMP + f"-tip_torque 0,{-M!r},0", max(period(n) / 3, 200))
        CURVES[f"circle_{n}"] = state.whole[:, [0, 2]] / L
        turn = angles_in_plane(state)[-1]
        turns.append(turn)
        gaps.append(np.linalg.norm(state.whole[-1] - state.whole[0]) / L)
        rows.append(relative("circle",
                             f"angle turned by 2 pi EJ/L, rad, law of the bond, {n} bonds",
                             n * a, turn, 1e-10, "round-off of the torques and the settling"))
    limit, doubt = richardson(turns[1:])
    rows.append(Row("circle", "angle turned by 2 pi EJ/L, rad, limit T = 0", 2 * math.pi, limit,
                    abs(limit - 2 * math.pi), doubt, EXTRAPOLATED))
    errors = [abs(t - 2 * math.pi) for t in turns]
    CURVES.setdefault("convergence", {})["circle, angle"] = list(zip((10, 20, 40, 80), errors))
    rows.append(order_row("circle", "order in T of the angle", errors[1:]))
    rows.append(order_row("circle", "order in T of the gap between the ends", gaps[1:]))
    return rows


CHECKS = {"beams": beams, "circle": circle}
CHECKS.update({f"elastica_{load}": (lambda load=load: elastica_load(load)) for load in PUBLISHED})
