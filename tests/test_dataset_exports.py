"""Exports hold the same recordings in the conventions of who reads them."""

import json
from dataclasses import replace

import numpy as np
import pytest

from imubench import rotations
from imubench.dataset import read
from imubench.dataset.exports import EXPORTS, held_rows
from imubench.dataset.generate import generate
from imubench.dataset.reading import indices
from imubench.dataset.shard import Job
from imubench.errors import InputError
from imubench.main import main
from imubench.recording import Imu
from tests.hub import offline

__all__ = ["offline"]

SPEC = """
name = "small"
seconds = [3, 4]
recordings_per_rig = 2
recordings_per_file = 4
precision = "double"
[[rig]]
family = "hinge"
[[rig]]
family = "pendulum"
[[effect]]
name = "dropouts"
probability = 0.5
fraction = 0.1
"""
COUNT = 10


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("exports") / "d"
    generate(Job({"spec.toml": SPEC.encode()}, 2, COUNT, str(out)), workers=0)
    return out


@pytest.fixture(scope="module")
def exported(folder, tmp_path_factory):
    out = {}
    for name, export in EXPORTS.items():
        out[name] = tmp_path_factory.mktemp(name)
        export((read(folder, i) for i in range(COUNT)), out[name])
    return out


def hinges(folder):
    return [s for s in (read(folder, i) for i in range(COUNT)) if s.recording.rig == "hinge"]


def test_qmt_loads_a_recording_and_finds_its_axis(folder, exported):
    qmt = pytest.importorskip("qmt")
    for stored in hinges(folder)[:2]:
        loaded = qmt.Struct.load(str(exported["qmt"] / f"{stored.recording.name}.mat"))
        one, two = (loaded[f"imu{n}"] for n in (1, 2))
        assert loaded["rate"] == 100
        assert one["gyr"].shape == two["gyr"].shape == (len(loaded["t"]), 3)
        # The hinge axis is the same in the world for both: what they turn on relative to each other.
        both = [rotations.rotate(imu["quat"], imu["joint_axis"]) for imu in (one, two)]
        assert np.abs(both[0] - both[1]).max() < 1e-9  # two products of rotations, rounded
        assert np.array_equal(np.isin(one["t"], stored.recording.imu("imu1").time), np.ones(len(one["t"]), bool))
        relative = rotations.rotate(one["quat"], one["gyr"]) - rotations.rotate(two["quat"], two["gyr"])
        off_axis = np.cross(relative, both[0])
        # What is left beside the axis is bias (0.005 rad/s an axis) and noise (0.006 rad/s a sample) of two MTw.
        assert np.sqrt(np.mean(off_axis**2)) < 0.03 < np.sqrt(np.mean(relative**2))


def test_sto_tables_hold_truth_and_readings(folder, exported):
    stored = hinges(folder)[0]
    for what, kind, width in (("orientations", "Quaternion", 4), ("linear_accelerations", "Vec3", 3)):
        lines = (exported["opensim"] / f"{stored.recording.name}_{what}.sto").read_text().splitlines()
        assert lines[:2] == ["DataRate=100.000000", f"DataType={kind}"]
        assert lines[4:6] == ["endheader", "time\timu1_imu\timu2_imu"]
        rows = [line.split("\t") for line in lines[6:]]
        values = np.array([[float(x) for x in row[1].split(",")] for row in rows])
        assert values.shape == (stored.truth.time.size, width)
        if width == 4:
            assert np.allclose(values, stored.truth.sensor("imu1").quaternion, atol=1e-8)  # nine digits are written
        assert np.allclose([float(row[0]) for row in rows], stored.truth.time, atol=1e-9)


def test_ring_arrays_are_in_its_conventions(folder, exported):
    with np.load(exported["ring"] / "imus-2.npz") as found:
        X, y, lam, Ts, recording = (found[k] for k in ("X", "y", "lam", "Ts", "recording"))
    assert X.shape[2:] == (2, 9) and y.shape == (*X.shape[:3], 4) and list(lam) == [-1, 0] and Ts == 0.01
    assert list(recording) == [s.row["recording"] for s in hinges(folder)]
    close = 1e-6  # single precision
    for x, target, stored in zip(X, y, hinges(folder), strict=True):
        n = len(x)
        first, second = stored.truth.sensors
        up = rotations.rotate_back(first.quaternion, np.tile([0.0, 0.0, 1.0], (len(first.gyro), 1)))[:n]
        assert np.allclose(rotations.rotate(target[:, 0], np.array([0.0, 0.0, 1.0])), up, atol=close)
        assert np.abs(target[:, 0, 3]).max() < close  # an inclination turns about a horizontal axis
        assert np.allclose(rotations.rotate(target[:, 1], second.joint_axis[:n]), first.joint_axis[:n], atol=close)
        assert np.allclose(x[:, 1, 6:], second.joint_axis[:n], atol=close) and not x[:, 0, 6:].any()
        assert np.abs(np.linalg.norm(target, axis=-1) - 1).max() < close
    with np.load(exported["ring"] / "imus-1.npz") as found:
        assert found["X"].shape[0] == COUNT - len(X) and list(found["lam"]) == [-1]


def test_lost_samples_repeat_the_one_before():
    imu = Imu("imu1", np.array([0.02, 0.03, 0.06]), np.zeros((3, 3)), np.zeros((3, 3)), 100.0)
    assert held_rows(imu, 8).tolist() == [0, 0, 0, 1, 1, 1, 2, 2]


@pytest.mark.parametrize("name", EXPORTS)
@pytest.mark.parametrize("shift", [-10.0, 10.0])
def test_samples_beyond_the_truth_are_refused_in_one_line(name, shift, folder, tmp_path):
    stored = read(folder, 0)
    imus = tuple(replace(imu, time=imu.time + shift) for imu in stored.recording.imus)
    odd = replace(stored, recording=replace(stored.recording, imus=imus))
    with pytest.raises(InputError, match=r"expected samples of imu1 within the .* rows of truth, got them from row"):
        EXPORTS[name](iter([odd]), tmp_path)


def test_less_truth_cannot_be_exported(tmp_path):
    generate(Job({"spec.toml": f"truth = 'core'\n{SPEC}".encode()}, 2, 1, str(tmp_path / "d")), workers=0)
    with pytest.raises(InputError, match='expected a dataset with truth = "full"'):
        EXPORTS["qmt"](iter([read(tmp_path / "d", 0)]), tmp_path)


def test_the_command_exports_a_split(folder, tmp_path, monkeypatch, capsys):
    counts = json.loads((folder / "manifest.json").read_text())["recordings"]
    monkeypatch.setattr(
        "sys.argv", ["imubench", "export", "qmt", str(folder), "--split", "train", "--out", str(tmp_path / "o")]
    )
    with pytest.raises(SystemExit) as caught:
        main()
    assert caught.value.code == 0
    assert len(list((tmp_path / "o").glob("*.mat"))) == counts["train"] == len(list(indices(folder, "train")))
    monkeypatch.setattr(
        "sys.argv", ["imubench", "export", "qmt", str(folder), "--split", "rest", "--out", str(tmp_path / "p")]
    )
    with pytest.raises(SystemExit) as caught:
        main()
    assert caught.value.code == 2
    assert "unknown split 'rest'; known: train, validation, test" in capsys.readouterr().err


def test_load_dataset_reads_one_sensor_of_all_folders_in_format_1(folder, exported, offline):
    """As docs/datasets.md has it: rows of all recordings, in the order of their folders, as their IMUs read them."""
    files = sorted(str(path) for path in exported["format1"].glob("*/imu1.csv"))
    assert len(files) == COUNT
    loaded = offline.load_dataset("csv", data_files=str(exported["format1"] / "*" / "imu1.csv"))["train"]
    imus = [read(folder, i).recording.imu("imu1") for i in range(COUNT)]
    assert loaded.num_rows == sum(imu.time.size for imu in imus)
    columns = [loaded[f"{kind}_{axis}"] for kind in ("gyr", "acc") for axis in "xyz"]
    expected = np.concatenate([np.hstack([imu.gyro, imu.accel]) for imu in imus])
    np.testing.assert_array_equal(np.column_stack([np.array(c) for c in columns]), expected)  # written in full
    one = offline.load_dataset("csv", data_files=files[0])["train"]
    np.testing.assert_array_equal(np.array(one["time"]), imus[0].time)
