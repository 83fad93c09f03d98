"""What the tests of the scripts share: running programs and a folder that goes away."""
import os
import subprocess
import tempfile
import unittest

import h5py


class FolderTest(unittest.TestCase):
    """Each test has an empty folder, self.folder, of its own."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="nanoweft-test-")
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def run_program(self, program, *arguments):
        return subprocess.run([program, *arguments], cwd=self.folder, capture_output=True, text=True,
                              env={**os.environ, "OMP_NUM_THREADS": "1"})

    def simulate(self, binary, options):
        """Runs nanoweft with snapshots frame_<step>.h5; their paths in order."""
        done = self.run_program(binary, *options.split(), "-snapshot_file", "frame", "-progress_interval", "0")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return sorted(self.path(name) for name in os.listdir(self.folder)
                      if name.startswith("frame_") and name.endswith(".h5"))


def read_fields(name):
    with h5py.File(name, "r") as file:
        return {key: data[()] for key, data in file["field"].items()}


def read_state(name):
    with h5py.File(name, "r") as file:
        state = {key: data[()] for key, data in file["state"].items()}
        state.update(file["state"].attrs)
    return state
