"""Tests of scripts/export: python3 export.py NANOWEFT SCRIPTS"""
import os
import shlex
import sys
import unittest

import h5py
import numpy as np
from support import FolderTest, read_state


def read_xyz(name):
    """Frames of an extended XYZ file: dictionaries of the header's keys and the columns."""
    frames = []
    with open(name) as file:
        while count := file.readline():
            frame = dict(word.split("=", 1) for word in shlex.split(file.readline()))
            rows = [file.readline().split() for _ in range(int(count))]
            columns = frame["Properties"].split(":")
            assert len(rows[0]) == sum(map(int, columns[2::3]))
            begin = 0
            for key, kind, width in zip(columns[::3], columns[1::3], map(int, columns[2::3])):
                values = [row[begin:begin + width] for row in rows]
                frame[key] = np.array(values, {"S": str, "I": np.int64, "R": float}[kind])
                begin += width
            frames.append(frame)
    return frames


def read_dump(name):
    """Frames of a LAMMPS dump: dictionaries of the items and the columns."""
    frames = []
    with open(name) as file:
        while item := file.readline():
            assert item == "ITEM: TIMESTEP\n"
            frame = {"step": int(file.readline())}
            assert file.readline() == "ITEM: NUMBER OF ATOMS\n"
            count = int(file.readline())
            *title, a, b, c = file.readline().split()
            assert title == ["ITEM:", "BOX", "BOUNDS"]
            frame["flags"] = [a, b, c]
            frame["bounds"] = np.array([file.readline().split() for _ in range(3)], float)
            item, atoms, *names = file.readline().split()
            assert (item, atoms) == ("ITEM:", "ATOMS")
            rows = np.array([file.readline().split() for _ in range(count)])
            assert rows.shape == (count, len(names))
            frame.update(zip(names, rows.T.astype(float)))
            frames.append(frame)
    return frames


def together(frame, names):
    return np.stack([frame[name] for name in names.split()], axis=1)


def rotate(quaternion, vector):
    """Vectors turned by quaternions x, y, z, w."""
    u, w = quaternion[:, :3], quaternion[:, 3:]
    return vector + 2 * np.cross(u, np.cross(u, vector) + w * vector)


def write_state(name, position, **more):
    count = len(position)
    state = {"units": "nano", "orientation": np.tile([1.0, 0, 0, 0], (count, 1)),
             "fibre": np.zeros(count, np.int64), "index": np.arange(count), **more}
    with h5py.File(name, "w") as file:
        group = file.create_group("state")
        group.attrs.update(format="nanoweft-state", version=1, step=7, time=2.5,
                           units=state.pop("units"),
                           lower=[-10.0, 0.0, -5.0], upper=[10.0, 30.0, 5.0], periodic=[1, 1, 0])
        group.create_dataset("position", data=position, fletcher32=True, chunks=True)
        for key, value in state.items():
            group[key] = value


class Export(FolderTest):
    def export(self, *arguments):
        return self.run_program(os.path.join(scripts, "export"), *arguments)

    def expect_export(self, *arguments):
        done = self.export(*arguments)
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def expect_refusal(self, text, *arguments):
        before = sorted(os.listdir(self.folder))
        done = self.export(*arguments)
        self.assertNotEqual(done.returncode, 0)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        self.assertIn(text, done.stderr)
        self.assertEqual(sorted(os.listdir(self.folder)), before)

    def weave(self):
        snapshots = self.simulate(nanoweft,
                                  "-weave_fibres 4,4 -weave_segments 24 -damping_local 0.4"
                                  " -ts_max_steps 20 -snapshot_interval 10 -state_output final.h5")
        self.assertEqual(len(snapshots), 3)
        return snapshots + [self.path("final.h5")]

    def test_weave_as_xyz(self):
        files = self.weave()
        self.expect_export(*files, "-o", "out.xyz")
        frames = read_xyz(self.path("out.xyz"))
        self.assertEqual([int(frame["step"]) for frame in frames], [0, 10, 20, 20])
        for name, frame in zip(files, frames):
            state = read_state(name)
            self.assertEqual(frame["pos"].shape, (2 * 4 * 24, 3))
            # 17 digits give back the same double.
            np.testing.assert_array_equal(frame["pos"], state["position"])
            np.testing.assert_array_equal(frame["orientation"],
                                          state["orientation"][:, [1, 2, 3, 0]])
            np.testing.assert_allclose(np.linalg.norm(frame["orientation"], axis=1), 1, rtol=1e-12)
            np.testing.assert_array_equal(frame["fibre"][:, 0], np.repeat(np.arange(8), 24))
            np.testing.assert_array_equal(frame["index"][:, 0], np.tile(np.arange(24), 8))
            np.testing.assert_array_equal(frame["group"][:, 0], state["group"])
            np.testing.assert_array_equal(frame["bond_broken"], 0)
            lattice = np.array(frame["Lattice"].split(), float).reshape(3, 3)
            np.testing.assert_array_equal(lattice, np.diag(state["upper"] - state["lower"]))
            np.testing.assert_array_equal(np.array(frame["Origin"].split(), float), state["lower"])
            self.assertEqual(frame["pbc"], "F F F")
            self.assertEqual(float(frame["time"]), state["time"])

    def test_weave_as_dump(self):
        files = self.weave()
        self.expect_export(*files, "-o", "out.dump")
        frames = read_dump(self.path("out.dump"))
        self.assertEqual([frame["step"] for frame in frames], [0, 10, 20, 20])
        for name, frame in zip(files, frames):
            state = read_state(name)
            np.testing.assert_array_equal(frame["id"], np.arange(1, 193))
            np.testing.assert_array_equal(frame["mol"], np.repeat(np.arange(8), 24))
            np.testing.assert_array_equal(together(frame, "x y z"), state["position"])
            np.testing.assert_array_equal(together(frame, "quati quatj quatk quatw"),
                                          state["orientation"][:, [1, 2, 3, 0]])
            np.testing.assert_array_equal(frame["bounds"],
                                          np.stack([state["lower"], state["upper"]], axis=1))
            self.assertEqual(frame["flags"], ["ff"] * 3)

    def test_orientations_point_along_the_fibres(self):
        # In a smooth curve the chord from a node to the next lies between their tangents, or beside
        # them by less than the angle between them where the curvature changes.
        first = self.weave()[0]
        for axis, vector in ("x", [1, 0, 0]), ("z", [0, 0, 1]):
            self.expect_export(first, "-o", "out.xyz", "--force", "--axis", axis)
            frame, = read_xyz(self.path("out.xyz"))
            np.testing.assert_allclose(np.linalg.norm(frame["orientation"], axis=1), 1, rtol=1e-12)
            tangent = rotate(frame["orientation"], np.array(vector, float)).reshape(8, 24, 3)
            chord = np.diff(frame["pos"].reshape(8, 24, 3), axis=1)
            chord /= np.linalg.norm(chord, axis=2, keepdims=True)
            turn = np.arccos(np.clip((tangent[:, 1:] * tangent[:, :-1]).sum(axis=2), -1, 1)).max()
            aside = np.arccos(np.clip((tangent[:, :-1] * chord).sum(axis=2), -1, 1)).max()
            self.assertLess(aside, turn)
            self.assertLess(turn, 0.5)  # so that the bound above means something

    def test_periodic_images_and_broken_bonds(self):
        write_state(self.path("in.h5"), np.array([[9.0, 1, 0], [-9.5, 29, 1], [0.125, 3, -6]]),
                    image=np.array([[0, 0, 0], [1, -2, 0], [0, 0, 0]], np.int32),
                    fibre=np.array([-3, -3, 2**40]), index=np.array([0, 1, 0]),
                    group=np.array([0, 5, 8], np.int32), bond_broken=np.array([1, 0, 0], np.int8))
        whole = [[9, 1, 0], [-9.5 + 20, 29 - 60, 1], [0.125, 3, -6]]
        self.expect_export("in.h5", "-o", "in.xyz")
        self.expect_export("in.h5", "-o", "unwrapped.xyz", "--unwrap")
        held, = read_xyz(self.path("in.xyz"))
        unwrapped, = read_xyz(self.path("unwrapped.xyz"))
        self.assertEqual(held["pbc"], "T T F")
        self.assertEqual(held["map_shift"].tolist(), [[0, 0, 0], [1, -2, 0], [0, 0, 0]])
        self.assertEqual(unwrapped["pos"].tolist(), whole)
        self.assertNotIn("map_shift", unwrapped)
        for frame in held, unwrapped:
            self.assertEqual(frame["fibre"].ravel().tolist(), [-3, -3, 2**40])
            self.assertEqual(frame["group"].ravel().tolist(), [0, 5, 8])
            self.assertEqual(frame["bond_broken"].ravel().tolist(), [1, 0, 0])
        self.expect_export("in.h5", "-o", "in.txt", "--format", "lammps")
        self.expect_export("in.h5", "-o", "unwrapped.lammpstrj", "--unwrap")
        held, = read_dump(self.path("in.txt"))
        unwrapped, = read_dump(self.path("unwrapped.lammpstrj"))
        self.assertEqual(held["flags"], ["pp", "pp", "ff"])
        self.assertEqual(held["bounds"].tolist(), [[-10, 10], [0, 30], [-5, 5]])
        self.assertEqual(together(held, "ix iy iz").tolist(), [[0, 0, 0], [1, -2, 0], [0, 0, 0]])
        self.assertEqual(together(unwrapped, "xu yu zu").tolist(), whole)
        self.assertEqual(held["bond_broken"].tolist(), [1, 0, 0])

    def test_lengths_in_si_become_micrometres(self):
        write_state(self.path("in.h5"), np.array([[1e-6, 2e-6, 3e-6]]), units="si")
        self.expect_export("in.h5", "-o", "in.xyz")
        self.expect_export("in.h5", "-o", "in.dump", "--scale", "0.5")
        micro, = read_xyz(self.path("in.xyz"))
        half, = read_dump(self.path("in.dump"))
        np.testing.assert_allclose(micro["pos"], [[1, 2, 3]], rtol=1e-15)
        self.assertEqual(micro["Origin"], "-10000000 0 -5000000")
        self.assertEqual(half["bounds"].tolist(), [[-5, 5], [0, 15], [-2.5, 2.5]])
        self.assertEqual(together(half, "x y z").tolist(), [[5e-7, 1e-6, 1.5e-6]])

    def test_more_segments_than_are_read_at_a_time(self):
        position = np.random.default_rng(1).normal(size=(40000, 3))
        write_state(self.path("in.h5"), position)
        self.expect_export("in.h5", "-o", "in.xyz")
        frame, = read_xyz(self.path("in.xyz"))
        np.testing.assert_array_equal(frame["pos"], position)
        np.testing.assert_array_equal(frame["id"].ravel(), np.arange(1, 40001))

    def test_refusals(self):
        write_state(self.path("in.h5"), np.zeros((3, 3)))
        write_state(self.path("short.h5"), np.zeros((3, 3)), group=np.zeros(2, np.int32))
        write_state(self.path("nan.h5"), np.full((3, 3), np.nan))
        write_state(self.path("empty.h5"), np.zeros((0, 3)))
        with h5py.File(self.path("foreign.h5"), "w") as file:
            file["state/position"] = np.zeros((3, 3))
        with open(self.path("text.h5"), "w") as file:
            file.write("not HDF5")
        with open(self.path("there.xyz"), "w") as file:
            file.write("kept")
        self.expect_refusal("exists", "in.h5", "-o", "there.xyz")
        self.expect_refusal("no such file", "none.h5", "-o", "out.xyz")
        self.expect_refusal("not a nanoweft state file", "foreign.h5", "-o", "out.xyz")
        self.expect_refusal("not a nanoweft state file", "text.h5", "-o", "out.xyz")
        self.expect_refusal("group does not match", "short.h5", "-o", "out.xyz")
        self.expect_refusal("not finite", "in.h5", "nan.h5", "-o", "out.xyz")
        self.expect_refusal("no segments", "empty.h5", "-o", "out.xyz")
        self.expect_refusal("choose with --format", "in.h5", "-o", "out.txt")
        self.expect_refusal("cannot write", "in.h5", "-o", "none/out.xyz")
        self.expect_refusal("also to be read", "in.h5", "-o", "in.h5", "--format", "xyz", "--force")
        # A failure leaves the old file even where it may be overwritten.
        self.expect_refusal("not finite", "in.h5", "nan.h5", "-o", "there.xyz", "--force")
        with open(self.path("there.xyz")) as file:
            self.assertEqual(file.read(), "kept")
        self.expect_export("in.h5", "-o", "there.xyz", "--force")
        self.assertEqual(len(read_xyz(self.path("there.xyz"))), 1)

    def test_tilted_box(self):
        write_state(self.path("in.h5"), np.array([[1.0, 2, 3], [4, 5, 2]]),
                    image=np.array([[0, 0, 0], [1, -2, 0]]))
        with h5py.File(self.path("in.h5"), "r+") as file:
            file["state"].attrs["tilt"] = [4.0, 0, 0]
        self.expect_export("in.h5", "-o", "out.xyz", "--unwrap")
        frame, = read_xyz(self.path("out.xyz"))
        self.assertEqual(frame["Lattice"], "20 0 0 4 30 0 0 0 10")
        np.testing.assert_array_equal(frame["pos"], [[1, 2, 3], [4 + 20 - 8, 5 - 60, 2]])
        self.expect_export("in.h5", "-o", "out.dump")
        with open(self.path("out.dump")) as file:
            lines = file.read().splitlines()
        self.assertEqual(lines[4:8], ["ITEM: BOX BOUNDS xy xz yz pp pp ff", "-10 14 4", "0 30 0",
                                      "-5 5 0"])

    def test_without_images_fibres_are_made_whole_along_themselves(self):
        for tilt in 0.0, 4.0:
            one = np.array([-8.0, 3, 0]) + np.arange(12)[:, None] * [5, 7, 0.25]
            whole = np.concatenate([one, one[::-1] * [1, 0.1, 1]])
            position = np.array(whole)
            position[:, 0] -= tilt * (whole[:, 1] // 30)
            position[:, 1] %= 30
            position[:, 0] = (position[:, 0] + 10) % 20 - 10
            # A fibre starts in the image of its first segment, here the box itself.
            whole[12:, 0] -= np.round(whole[12, 0] - position[12, 0])
            rows = np.random.default_rng(1).permutation(24)
            write_state(self.path("in.h5"), position[rows], fibre=np.repeat([7, 3], 12)[rows],
                        index=np.tile(np.arange(12), 2)[rows])
            with h5py.File(self.path("in.h5"), "r+") as file:
                file["state"].attrs["tilt"] = [tilt, 0, 0]
            self.expect_export("in.h5", "-o", "unwrapped.xyz", "--unwrap", "--force")
            self.expect_export("in.h5", "-o", "in.xyz", "--force")
            unwrapped, = read_xyz(self.path("unwrapped.xyz"))
            held, = read_xyz(self.path("in.xyz"))
            np.testing.assert_allclose(unwrapped["pos"], whole[rows], atol=1e-12)
            np.testing.assert_array_equal(held["pos"], position[rows])
            way = np.array([[20, 0, 0], [tilt, 30, 0], [0, 0, 10]])
            np.testing.assert_allclose(held["pos"] + held["map_shift"] @ way, whole[rows],
                                       atol=1e-12)

    def test_damaged_data_are_refused(self):
        position = np.full((3, 3), 1.2345678)
        write_state(self.path("in.h5"), position)
        with open(self.path("in.h5"), "rb") as file:
            content = file.read()
        place = content.index(position.tobytes())
        with open(self.path("in.h5"), "wb") as file:
            file.write(content[:place] + b"\xff" + content[place + 1:])
        self.expect_refusal("damaged", "in.h5", "-o", "out.xyz")


if __name__ == "__main__":
    nanoweft, scripts = sys.argv[1:3]
    unittest.main(argv=sys.argv[:1])
