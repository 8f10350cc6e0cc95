"""Converters on miniature sources in the layout of broad and multiarm, and what holds for all of them."""

import inspect
import sys

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from imubench.alignment import gyro_delay
from imubench.convert import CONVERTERS
from imubench.convert.multiarm import UPRIGHT
from imubench.errors import InputError
from imubench.recording import Imu
from imubench.rotations import from_axis_angle, multiply, rotate
from tests.chain import G_W, base_quaternion, readings

# --- broad ---


def broad_trial(path, leave_out=(), gyro_late=0.0):
    """Write a trial of 10 s whose gyroscope shows at a stamp what the cameras show `gyro_late` s before it."""
    t = np.arange(10 * 200) / 200
    gyro, accel = readings(t, 0, delay=gyro_late)
    quaternion = base_quaternion(t)
    quaternion[50:60] = np.nan
    arrays = {"imu_acc": accel, "imu_gyr": gyro, "opt_quat": 2 * quaternion, "opt_pos": np.zeros((t.size, 3))}
    with h5py.File(path, "w") as file:
        for key, array in (arrays | {"movement": (t > 1) & (t < 9)}).items():
            if key not in leave_out:
                file[key] = array
        if "sampling_rate" not in leave_out:
            file.attrs["sampling_rate"] = 200.0
    return path


def test_broad_gives_an_imu_and_a_pose(tmp_path):
    (out,) = CONVERTERS["broad"](broad_trial(tmp_path / "07_x.hdf5"))
    (imu,), (pose,) = out.recording.imus, out.recording.poses
    assert (out.recording.name, out.recording.rig, out.reference) == ("broad-07_x", "free", None)
    assert imu.rate == 200 and imu.time[1] == 1 / 200 and pose.segment == "segment1"
    seen = np.isfinite(pose.quaternion).all(axis=-1)
    assert (~seen).sum() == 10 and np.isfinite(pose.position).all()
    np.testing.assert_allclose(np.linalg.norm(pose.quaternion[seen], axis=-1), 1, atol=1e-12)  # rounding
    assert "CC BY 4.0" in out.note and "Movement phase 1.0 to 9.0 s" in out.note


@pytest.mark.parametrize("gyro_late", [0.0042, -0.0023])
def test_broad_puts_the_pose_on_the_clock_of_the_imu(tmp_path, gyro_late):
    source = broad_trial(tmp_path / "07_x.hdf5", gyro_late=gyro_late)
    (out,) = CONVERTERS["broad"](source)
    (imu,), (pose,) = out.recording.imus, out.recording.poses
    delay, _ = gyro_delay(imu, pose.time, pose.quaternion)
    assert abs(delay) < 2e-4  # s: what interpolation at 200 Hz allows
    assert f"Optical stamps {-1e3 * gyro_late:+.1f}" in out.note
    (as_written,) = CONVERTERS["broad"](source, optical_delay=0.0)
    np.testing.assert_array_equal(as_written.recording.poses[0].time, imu.time)


@pytest.mark.parametrize("key", ["imu_gyr", "opt_quat", "sampling_rate"])
def test_broad_missing_key(tmp_path, key):
    with pytest.raises(InputError, match=rf"t.hdf5: expected (key|attribute) '{key}', got "):
        CONVERTERS["broad"](broad_trial(tmp_path / "t.hdf5", leave_out=(key,)))


def test_broad_bad_sources(tmp_path, monkeypatch):
    (tmp_path / "t.hdf5").write_text("not hdf5")
    with pytest.raises(InputError, match=r"t.hdf5: expected a readable HDF5 file, got: "):
        CONVERTERS["broad"](tmp_path / "t.hdf5")
    with pytest.raises(InputError, match=r"unknown option of broad 'rate'; known: optical_delay"):
        CONVERTERS["broad"](tmp_path / "t.hdf5", rate="100")
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(InputError, match=r"pip install 'imubench\[convert\]'"):
        CONVERTERS["broad"](tmp_path / "t.hdf5")


# --- multiarm ---


def multiarm_file(path, rate_scale=1.0, middle=np.pi, leave_out=()):
    """Two identification pieces and one for validation at 500 Hz, swinging about `middle`."""
    cells = {"Time_id": [], "Y_id": [], "Time_vad": [], "Y_vad": []}
    for i, kind in enumerate(("id", "id", "vad")):
        t = 3.0 * i + np.arange(1500) / 500
        angle, rate = middle + 0.8 * np.cos(5 * t), -4.0 * np.sin(5 * t)
        cells[f"Time_{kind}"].append(t[:, None])
        cells[f"Y_{kind}"].append(np.stack([angle, rate_scale * rate]))
    content = {"dt": 0.002}
    for key, values in cells.items():
        cell = np.empty((len(values), 1), dtype=object)
        for i, value in enumerate(values):
            cell[i, 0] = value
        content[key] = cell
    savemat(path, {key: value for key, value in content.items() if key not in leave_out})
    return path


def test_multiarm_gives_one_recording_a_piece(tmp_path):
    path = multiarm_file(tmp_path / "p.mat")
    pieces = CONVERTERS["multiarm"](path)
    assert [p.recording.name for p in pieces] == ["multiarm-id-1", "multiarm-id-2", "multiarm-vad-1"]
    (out,) = CONVERTERS["multiarm"](path, piece="id-2")
    recording = out.recording
    assert (recording.rig, recording.base, recording.motion, recording.imus) == ("hinge", "fixed", "free", ())
    (encoder,) = recording.encoders
    assert encoder.joint == "hinge" and encoder.time[0] == 3.0 and recording.free_swings == ((3.0, encoder.time[-1]),)
    np.testing.assert_array_equal(encoder.angle, np.pi + 0.8 * np.cos(5 * encoder.time))
    assert "500 Hz" in out.note


def test_multiarm_base_makes_the_angle_from_upright_the_hinge_angle():
    """Kinematics of our hinge: segment 2 runs along +x of its frame, which is segment 1's turned by q about +y."""
    angle = np.linspace(-np.pi, np.pi, 25)
    direction = rotate(multiply(UPRIGHT, from_axis_angle([0, 1.0, 0], angle)), [1.0, 0, 0])
    # upright at 0, hanging at pi, and elsewhere by that angle from upright in one vertical plane; rounding
    np.testing.assert_allclose(direction, np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=-1), atol=1e-12)
    # gravity's potential g cos(q) then has its minimum, and the pendulum its rest, at pi
    assert np.argmin(direction @ G_W) in (0, 24)


def test_multiarm_bad_sources(tmp_path):
    convert = CONVERTERS["multiarm"]
    with pytest.raises(InputError, match=r"unknown piece 'id-9'; known: all, id-1, id-2, vad-1"):
        convert(multiarm_file(tmp_path / "a.mat"), piece="id-9")
    with pytest.raises(InputError, match=r"piece id-1: expected a rate that is the derivative .* difference of 98%"):
        convert(multiarm_file(tmp_path / "b.mat", rate_scale=180 / np.pi))
    with pytest.raises(InputError, match=r"piece id-1: expected a swing about pi \(hanging\), got one about 0.00 rad"):
        convert(multiarm_file(tmp_path / "c.mat", middle=0.0))
    with pytest.raises(InputError, match=r"d.mat: expected variable 'Y_vad', got dt, Time_id, Y_id, Time_vad"):
        convert(multiarm_file(tmp_path / "d.mat", leave_out=("Y_vad",)))
    (tmp_path / "e.mat").write_text("time,angle\n0,1\n")
    with pytest.raises(InputError, match=r"e.mat: expected a MATLAB 5 .mat file, got one of 15 bytes"):
        convert(tmp_path / "e.mat")


# --- all of them ---


@pytest.mark.parametrize("name", CONVERTERS)
def test_option_table_matches_the_function(name):
    converter = CONVERTERS[name]
    parameters = list(inspect.signature(converter.convert).parameters.values())
    assert converter.name == name and converter.summary and parameters[0].name == "source"
    assert [p.name for p in parameters[1:]] == list(converter.options)
    for parameter in parameters[1:]:
        assert converter.default(parameter.name) == parameter.default != inspect.Parameter.empty
        assert converter.options[parameter.name].help


def test_gyro_delay_has_the_sign_of_a_late_gyroscope():
    t = np.arange(1000) / 100
    gyro, accel = readings(t, 0, delay=0.02)  # at stamp t it shows the world of t - 0.02 s
    delay, misfit = gyro_delay(Imu("imu1", t, gyro, accel, 100.0), t, base_quaternion(t))
    assert delay == pytest.approx(0.02, abs=1e-4)  # s: what 100 Hz interpolation allows
    assert misfit < 0.01  # rad/s, of 2: the chord of a turn against the mean of its rate
