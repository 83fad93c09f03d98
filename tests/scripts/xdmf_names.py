"""The index of snapshots is well-formed for any name: python3 xdmf_names.py NANOWEFT"""
import os
import sys
import unittest
from xml.etree import ElementTree

import h5py
from support import FolderTest

NAMES = ["plain", "a&b", "<a>", "a\"b'c", "a b", "größe", "--a--", "]]>", "a%sb", "#a", "x" * 200]


class XdmfNames(FolderTest):
    def test_every_dataset_is_found_under_its_name(self):
        for name in NAMES:
            with self.subTest(name=name):
                done = self.run_program(
                    sys.argv[1], *"-weave_fibres 2,2 -weave_segments 12 -damping_local 0.3"
                    " -ts_max_steps 4".split(), "-snapshot_interval", "2",
                    "-progress_interval", "0", "-snapshot_file", f"./{name}")
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
                index = ElementTree.parse(self.path(name + ".xdmf"))
                self.assertEqual(len(index.findall(".//Time")), 3)
                items = index.findall(".//DataItem")
                self.assertEqual(len(items), 3 * (6 + 6))
                for item in items:
                    file, dataset = item.text.split(":")
                    self.assertIn(file, os.listdir(self.folder))
                    with h5py.File(self.path(file)) as f:
                        shape = " ".join(map(str, f[dataset].shape))
                    self.assertEqual(item.get("Dimensions"), shape)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
