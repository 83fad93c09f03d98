"""Snapshots as ParaView's readers see them: python3 xdmf.py NANOWEFT

Exit status 77 (CTest: skipped) without ParaView's Python modules (Debian: python3-paraview)."""
import sys
import unittest

import numpy as np
from support import FolderTest, read_fields, read_state

try:
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
    from vtkmodules.vtkIOXdmf2 import vtkXdmfReader
    from vtkmodules.vtkIOXdmf3 import vtkXdmf3Reader
except ImportError as error:
    print(f"skipped: {error}; install python3-paraview")
    sys.exit(77)


def frames(kind, name):
    """Time and data of each frame; the data are the reader's own and last until the next frame."""
    reader = kind()
    reader.SetFileName(name)
    reader.UpdateInformation()
    for time in reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS()):
        reader.UpdateTimeStep(time)
        yield time, reader.GetOutputDataObject(0)


def lines(data):
    """The cells, which must join two points each, as a set of pairs."""
    pairs = set()
    for k in range(data.GetNumberOfCells()):
        cell = data.GetCell(k)
        assert cell.GetClassName() in ("vtkLine", "vtkPolyLine") and cell.GetNumberOfPoints() == 2
        pairs.add((cell.GetPointId(0), cell.GetPointId(1)))
    return pairs


def bonds(state):
    """Pairs of neighbouring rows of one fibre whose bond is whole."""
    rows = {(fibre, index): row for row,
            (fibre, index) in enumerate(zip(state["fibre"], state["index"]))}
    return {(row, rows[fibre, index + 1]) for (fibre, index), row in rows.items()
            if (fibre, index + 1) in rows and not state["bond_broken"][row]}


class Xdmf(FolderTest):
    def expect_frames(self, snapshots):
        """Both readers see what the snapshots hold; returns the numbers of lines."""
        states = [read_state(name) for name in snapshots]
        fields = [read_fields(name) for name in snapshots]
        for field in fields:
            self.assertEqual(set(field), {"strain"} | {part + "_energy" for part in (
                "stretch", "shear", "bending", "torsion", "pair")})
        for kind in vtkXdmf3Reader, vtkXdmfReader:
            for (time, data), state, field in zip(frames(kind, self.path("frame.xdmf")), states,
                                                  fields, strict=True):
                self.assertEqual(time, state["time"])
                whole = state["position"] + state["image"] * (state["upper"] - state["lower"])
                np.testing.assert_array_equal(vtk_to_numpy(data.GetPoints().GetData()),
                                              whole.astype(np.float32))
                self.assertEqual(data.GetNumberOfCells(), len(bonds(state)))
                self.assertEqual(lines(data), bonds(state))
                points = data.GetPointData()
                seen = {"velocity", "fibre", "group", "bond_broken"} | set(field)
                self.assertEqual({points.GetArrayName(k)
                                  for k in range(points.GetNumberOfArrays())}, seen)
                for key in seen:
                    np.testing.assert_array_equal(vtk_to_numpy(points.GetArray(key)),
                                                  (state | field)[key])
        return [len(bonds(state)) for state in states]

    def test_weave(self):
        snapshots = self.simulate(sys.argv[1],
                                  "-weave_fibres 4,4 -weave_segments 24 -damping_local 0.4"
                                  " -ts_max_steps 20 -snapshot_interval 10")
        self.assertEqual([len(read_state(name)["fibre"]) for name in snapshots], [192] * 3)
        self.assertEqual(self.expect_frames(snapshots), [8 * 23] * 3)

    def test_lines_end_at_broken_bonds(self):
        snapshots = self.simulate(
            sys.argv[1],
            "-weave_fibres 4,4 -weave_segments 24 -damping_local 0.4 -tension_rate 2e-5"
            " -tension_ramp 2000 -tension_grip 40 -tension_max_strain 0.45 -break_strain_mean 0.12"
            " -break_strain_std 0.03 -ts_dt 15 -snapshot_interval 250")
        broken = [int(read_state(name)["bond_broken"].sum()) for name in snapshots]
        self.assertEqual(broken[0], 0)
        self.assertGreater(broken[-1], 0)
        self.assertEqual(self.expect_frames(snapshots), [8 * 23 - count for count in broken])

    def test_periodic_weave_has_no_lines_across_the_box(self):
        snapshots = self.simulate(sys.argv[1],
                                  "-weave_fibres 6,6 -weave_segments 36 -weave_periodic"
                                  " -ts_max_steps 10 -snapshot_interval 10")
        self.assertEqual(self.expect_frames(snapshots), [12 * 35] * 2)
        for name in snapshots:
            state = read_state(name)
            whole = state["position"] + state["image"] * (state["upper"] - state["lower"])
            lengths = [np.linalg.norm(whole[j] - whole[i]) for i, j in bonds(state)]
            self.assertLess(max(lengths), 2 * min(lengths))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
