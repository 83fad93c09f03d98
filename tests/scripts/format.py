"""No Python line is over 100 columns, no type of the namespace has the name of another one, all
C++ is as clang-format leaves it: python3 format.py

Exit status 77 (CTest: skipped) without clang-format or outside a git repository."""
import pathlib
import re
import shutil
import subprocess
import sys

from support import tracked

ROOT = pathlib.Path(__file__).resolve().parents[2]
COLUMNS = 100
EXEMPT = {"scripts/nanoweft/speed_error/page.py"}  # Markdown, whose line breaks are the page's


def is_python(file):
    """By its name or, as for the scripts, by its first line."""
    if file.suffix == ".py" or not file.is_file():
        return file.is_file()
    with open(file, "rb") as content:
        first = content.readline(200)
    return first.startswith(b"#!") and b"python" in first


def too_long(files):
    """The lines over 100 columns of the Python among the files, a message for each."""
    found = []
    for file in filter(is_python, files):
        name = str(file.relative_to(ROOT))
        if name not in EXEMPT:
            lines = file.read_text(encoding="utf-8").splitlines()
            found += [f"{name}:{number}: {len(line)} columns"
                      for number, line in enumerate(lines, 1) if len(line) > COLUMNS]
    return found


def same_names(files):
    """The types that two headers define by one name in the namespace: the linker would take the
    functions of either for both."""
    places = {}
    for file in files:
        for name in re.findall(r"^(?:struct|class|enum class) (?:alignas\(\w+\) )?(\w+)\b[^;]*?\{",
                               file.read_text(encoding="utf-8"), re.M):
            places.setdefault(name, []).append(str(file.relative_to(ROOT)))
    return [f"{name}: defined in {' and '.join(where)}" for name, where in places.items()
            if len(where) > 1]


found = too_long(tracked(ROOT)) + same_names(tracked(ROOT, "include/*.hpp"))
if found:
    sys.exit("\n".join(found))
if not shutil.which("clang-format"):
    print("skipped: no clang-format; install Debian's clang-format")
    sys.exit(77)
files = tracked(ROOT, "*.cpp", "*.hpp")
sys.exit(subprocess.run(["clang-format", "--dry-run", "-Werror", *files]).returncode)
