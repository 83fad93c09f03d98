"""What the tests of the scripts share: running programs and a folder that goes away."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import h5py
import numpy as np


class FolderTest(unittest.TestCase):
    """Each test has an empty folder, self.folder, of its own."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="nanoweft-test-")
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def run_program(self, program, *arguments):
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
