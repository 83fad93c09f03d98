"""Options of the program: files of them, and as words of a command."""

from __future__ import annotations

import os
import pathlib
import re
from collections.abc import Mapping

WORD = re.compile(r""""[^"]*"|'[^']*'|\S+""")

# A value; None stands for an option without one, False leaves the option out.
Value = str | float | os.PathLike[str] | None
Options = Mapping[str, Value]


def read(file: str | os.PathLike[str]) -> dict[str, Value]:
    """An options file: name without its hyphen, and value."""
    return parse(pathlib.Path(file).read_text())


def parse(text: str) -> dict[str, Value]:
    """Options one a line, with or without a value. A # at the beginning of a word begins a comment;
    a value with blanks stands in quotes."""
    options: dict[str, Value] = {}
    for line in text.splitlines():
        found = []
        for word in WORD.findall(line):
            if word.startswith("#"):
                break
            found.append(word[1:-1] if word[0] in "\"'" else word)
        if found:
            options[found[0].lstrip("-")] = " ".join(found[1:]) if len(found) > 1 else None
    return options


def words(options: Options) -> list[str]:
    result: list[str] = []
    for name, value in options.items():
        if value is not False:
            result += [f"-{name}"] + ([] if value is None else [str(value)])
    return result
