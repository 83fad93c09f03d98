"""Options of the program: files of them, and as words of a command."""

from __future__ import annotations

import os
import pathlib
from collections.abc import Mapping

# A value; None stands for an option without one, False leaves the option out.
Value = str | float | os.PathLike[str] | None
Options = Mapping[str, Value]


def read(file: str | os.PathLike[str]) -> dict[str, Value]:
    """An options file: name without its hyphen, and value."""
    return parse(pathlib.Path(file).read_text())


def parse(text: str) -> dict[str, Value]:
    """Options one a line, with or without a value; # starts a comment."""
    options: dict[str, Value] = {}
    for line in text.splitlines():
        words = line.split("#")[0].split(maxsplit=1)
        if words:
            options[words[0].lstrip("-")] = words[1].strip() if len(words) > 1 else None
    return options


def words(options: Options) -> list[str]:
    result: list[str] = []
    for name, value in options.items():
        if value is not False:
            result += [f"-{name}"] + ([] if value is None else [str(value)])
    return result
