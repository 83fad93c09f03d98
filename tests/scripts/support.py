"""What the tests of the scripts share: running programs and a folder that goes away."""
import contextlib
import os
import pathlib
import runpy
import shutil
import subprocess
import sys
import tempfile
import traceback
import unittest
import warnings

import h5py
import numpy as np

with contextlib.suppress(ImportError):
    import matplotlib.pyplot  # noqa: F401  what scripts need is loaded once (run_script)


class FolderTest(unittest.TestCase):
    """Each test has an empty folder, self.folder, of its own."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="nanoweft-test-")
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def run_program(self, program, *arguments):
        with open(shutil.which(program) or program, "rb") as file:
            python = file.readline(40).startswith(b"#!/usr/bin/python3")
        if python:
            return run_script(program, arguments, self.folder)
        return self.execute(program, *arguments)

    def execute(self, program, *arguments):
        return subprocess.run([program, *arguments], cwd=self.folder, capture_output=True,
                              text=True,
                              env={**os.environ, "OMP_NUM_THREADS": "1"})

    def simulate(self, binary, options):
        """Runs nanoweft with snapshots frame_<step>.h5; their paths in order."""
        done = self.run_program(binary, *options.split(), "-snapshot_file", "frame",
                                "-progress_interval", "0")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return sorted(self.path(name) for name in os.listdir(self.folder)
                      if name.startswith("frame_") and name.endswith(".h5"))


def run_script(script, arguments, folder):
    """A Python script in a process of its own, forked from this one: to load matplotlib takes
    longer than most scripts do."""
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        sys.stdout.flush()
        sys.stderr.flush()
        process = os.fork()
        if process == 0:
            os.dup2(out.fileno(), 1)
            os.dup2(err.fileno(), 2)
            sys.stdout, sys.stderr = (open(fd, "w", closefd=False) for fd in (1, 2))
            status = in_this_process(script, arguments, folder)
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(status)
        status = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
        for file in out, err:
            file.seek(0)
        return subprocess.CompletedProcess([script, *arguments], status, out.read(), err.read())


def in_this_process(script, arguments, folder):
    """Runs a script as python3 would; its exit status."""
    os.chdir(folder)
    os.environ["OMP_NUM_THREADS"] = "1"
    for kind in ResourceWarning, DeprecationWarning:  # unittest shows them, the interpreter doesn't
        warnings.simplefilter("ignore", kind)
    sys.argv, sys.path[0] = [str(script), *arguments], os.path.dirname(os.path.realpath(script))
    try:
        runpy.run_path(str(script), run_name="__main__")
    except SystemExit as end:
        if isinstance(end.code, str):
            print(end.code, file=sys.stderr)
            return 1
        return end.code or 0
    except BaseException:  # as the interpreter does
        traceback.print_exc()
        return 1
    return 0


def tracked(root: pathlib.Path, *patterns: str) -> list[pathlib.Path]:
    """The files that git keeps; ends as skipped (CTest's 77) where there is no repository."""
    done = subprocess.run(["git", "-c", f"safe.directory={root}", "ls-files", "-z", "--",
                           *patterns],
                          cwd=root, capture_output=True, text=True)
    if done.returncode:
        print(f"skipped: {done.stderr.strip()}")
        sys.exit(77)
    # One that is deleted but not yet committed is listed, too.
    return [root / name for name in done.stdout.split("\0") if name and (root / name).exists()]


def read_fields(name):
    with h5py.File(name, "r") as file:
        return {key: data[()] for key, data in file["field"].items()}


def read_state(name):
    with h5py.File(name, "r") as file:
        state = {key: data[()] for key, data in file["state"].items()}
        state.update(file["state"].attrs)
    return state


def write_state(name, fibres, time=0.0, step=0, box=None, field=None, **more):
    """A state of straight fibres, each an array of positions."""
    count = [len(fibre) for fibre in fibres]
    with h5py.File(name, "w") as file:
        group = file.create_group("state")
        lower, upper = box or ([-1e5] * 3, [1e5] * 3)
        group.attrs.update(format="nanoweft-state", version=1, step=step, time=time, units="nano",
                           lower=lower, upper=upper, periodic=[int(box is not None), 0, 0])
        group["position"] = np.concatenate([np.zeros((0, 3)), *fibres])
        group["fibre"] = np.repeat(np.arange(len(fibres)), count)
        group["index"] = np.concatenate([np.zeros(0, int), *(np.arange(n) for n in count)])
        group["orientation"] = np.tile([1.0, 0, 0, 0], (sum(count), 1))
        for key, value in more.items():
            group[key] = value
        for key, value in (field or {}).items():
            file[f"field/{key}"] = value
