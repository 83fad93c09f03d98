"""Kinds of arguments that several commands take; argparse turns a ValueError into its message."""

import math


def positive(text: str) -> float:
    value = float(text)
    if not 0 < value < math.inf:
        raise ValueError
    return value


def positives(text: str) -> tuple[float, ...]:
    """A,B,..."""
    return tuple(map(positive, text.split(",")))


def fraction(text: str) -> float:
    """Above 0, at most a half."""
    value = float(text)
    if not 0 < value <= 0.5:
        raise ValueError
    return value


def count(text: str) -> int:
    value = int(text)
    if value < 1:
        raise ValueError
    return value


def interval(text: str) -> tuple[float, float]:
    """LO,HI"""
    low, high = map(float, text.split(","))
    if not -math.inf < low < high < math.inf:
        raise ValueError
    return low, high
