"""All C++ is as clang-format leaves it: python3 format.py

Exit status 77 (CTest: skipped) without clang-format or outside a git repository."""
import pathlib
import shutil
import subprocess
import sys

from support import tracked

files = tracked(pathlib.Path(__file__).resolve().parents[2], "*.cpp", "*.hpp")
if not shutil.which("clang-format"):
    print("skipped: no clang-format; install Debian's clang-format")
    sys.exit(77)
sys.exit(subprocess.run(["clang-format", "--dry-run", "-Werror", *files]).returncode)
