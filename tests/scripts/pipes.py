"""A command whose reader has left ends at once and says nothing: python3 pipes.py SCRIPTS"""
import os
import pathlib
import signal
import subprocess
import sys
import unittest

from support import FolderTest, write_state


def is_python(file: pathlib.Path) -> bool:
    return file.is_file() and file.read_bytes().startswith(b"#!/usr/bin/python3")


class Pipes(FolderTest):
    def left(self, *command: str) -> subprocess.CompletedProcess[str]:
        """Runs a command into a pipe that nobody reads."""
        out, into = os.pipe()
        os.close(out)
        try:
            return subprocess.run(command, cwd=self.folder, stdout=into, stderr=subprocess.PIPE,
                                  text=True, timeout=600)
        finally:
            os.close(into)

    def test_help(self) -> None:
        commands = [file for file in scripts.iterdir() if is_python(file)]
        self.assertGreater(len(commands), 10)
        for command in commands:
            if command.name != "options_table":  # it prints nothing
                with self.subTest(command.name):
                    done = self.left(str(command), "--help")
                    self.assertEqual((done.returncode, done.stderr), (128 + signal.SIGPIPE, ""))

    def test_output(self) -> None:
        write_state(self.path("state.h5"), [[[13.56 * k, 17.3 * j, 0] for k in range(40)]
                                            for j in range(2)])
        done = self.left(str(scripts / "bundles"), "state.h5")
        self.assertEqual((done.returncode, done.stderr), (128 + signal.SIGPIPE, ""))

    def test_problem(self) -> None:
        done = self.left(str(scripts / "bundles"), "none.h5")
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"^bundles: .*none.h5.*\n$")


if __name__ == "__main__":
    scripts = pathlib.Path(sys.argv[1]).resolve()
    unittest.main(argv=sys.argv[:1])
