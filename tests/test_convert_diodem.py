"""The converter of diodem on miniature trials of a made-up chain."""

import numpy as np
import pytest

from imubench.alignment import gyro_delay
from imubench.convert import CONVERTERS
from imubench.errors import InputError
from imubench.rotations import conjugate, from_axis_angle, log, multiply, rotate
from tests.chain import AXES, constraint_rms, diodem_trial, joint_angle


@pytest.mark.parametrize("segments", AXES)
def test_diodem_turns_the_hinge_axis_onto_y(tmp_path, segments):
    trial = diodem_trial(tmp_path / "trial9")
    (out,) = CONVERTERS["diodem"](trial, segments=segments, imu="rigid", optical_delay=0.0)
    first, second = out.recording.imus
    assert (out.recording.name, out.recording.rig) == (f"diodem-trial9-{segments}-rigid", "hinge")
    assert first.rate == 40 and first.mount_rotation_std == 0.02 and first.mount_position_std is None
    axis = np.eye(3)[AXES[segments]]
    # the fixed frames are exact to the 16 digits of sqrt(1/2)
    np.testing.assert_allclose(rotate(first.mount_quaternion, axis), [0, 1, 0], atol=1e-12)
    if segments != "2-3":  # the stretched chain runs along our x, unless the hinge turns about it
        np.testing.assert_allclose(rotate(first.mount_quaternion, [1.0, 0, 0]), [1, 0, 0], atol=1e-12)
    np.testing.assert_array_equal(first.mount_quaternion, second.mount_quaternion)
    seen = np.isfinite(out.reference.hinge_angle)
    assert (~seen).sum() == 10 and not seen[100:110].any()
    expected = joint_angle(out.reference.time, AXES[segments])
    # double precision through a table of full-length numbers
    np.testing.assert_allclose(out.reference.hinge_angle[seen], expected[seen], atol=1e-9)
    q1, q2 = out.reference.quaternion1[seen], out.reference.quaternion2[seen]
    relative = multiply(q1, from_axis_angle([0, 1.0, 0], expected[seen]))
    np.testing.assert_allclose(log(multiply(conjugate(relative), q2)), 0, atol=1e-9)  # the same


def test_diodem_constraint_holds_about_the_declared_axis(tmp_path):
    (out,) = CONVERTERS["diodem"](diodem_trial(tmp_path / "t"), segments="4-5")
    assert constraint_rms(out.recording) < 1e-6  # rad/s: central differences over 0.1 ms


def test_diodem_blanks_the_filled_segment(tmp_path):
    (out,) = CONVERTERS["diodem"](diodem_trial(tmp_path / "t"), segments="3-4")
    assert np.isnan(out.reference.quaternion2[100:110]).all() and np.isfinite(out.reference.quaternion2[110:]).all()
    assert "10 gap-filled frames" in out.note


@pytest.mark.parametrize("late", [0.016, -0.0023])
@pytest.mark.parametrize("imu", ["rigid", "nonrigid"])
def test_diodem_times_the_reference_by_the_gyroscopes(tmp_path, imu, late):
    """No constant of a trial: whatever the stamps are late by, of either sign, is found and taken out, gaps or not."""
    trial = diodem_trial(tmp_path / "t", optical_late=late)
    (out,) = CONVERTERS["diodem"](trial, imu=imu)
    for one, q in zip(out.recording.imus, (out.reference.quaternion1, out.reference.quaternion2), strict=True):
        delay, _ = gyro_delay(one, out.reference.time, q)
        assert abs(delay) < 3e-4  # s: what 40 Hz interpolation allows
    assert out.reference.time[0] == pytest.approx(-late, abs=3e-4)
    assert "by 5 gyroscopes" in out.note
    # what is left of the hinge angle is what the optical record has without noise: 0.3 ms of 1.5 rad/s
    expected = joint_angle(out.reference.time, AXES["3-4"])
    seen = np.isfinite(out.reference.hinge_angle)
    off = out.reference.hinge_angle[seen] - expected[seen]
    assert np.degrees(off.std()) < 0.05


def test_diodem_takes_a_given_delay(tmp_path):
    trial = diodem_trial(tmp_path / "t", optical_late=0.016)
    for given, left in ((0.016, 0.0), (0.0, -0.016)):
        (out,) = CONVERTERS["diodem"](trial, optical_delay=given)
        delay, _ = gyro_delay(out.recording.imus[0], out.reference.time, out.reference.quaternion1)
        assert delay == pytest.approx(left, abs=3e-4)  # s: what 40 Hz interpolation allows
        assert "as told; by the data +16" in out.note
    assert out.reference.time[0] == 0.0


def test_diodem_nonrigid_declares_a_loose_mount(tmp_path):
    (out,) = CONVERTERS["diodem"](diodem_trial(tmp_path / "t"), imu="nonrigid")
    assert out.recording.imus[0].mount_rotation_std == 0.15 and out.recording.name == "diodem-t-3-4-nonrigid"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"segments": "1-2"}, "segments '1-2': expected a hinge, got the chain's ball joint; known: 2-3, 3-4, 4-5"),
        ({"segments": "3-5"}, "unknown segments '3-5'; known: 2-3, 3-4, 4-5"),
        ({"imu": "foam"}, "unknown imu 'foam'; known: rigid, nonrigid"),
        ({"joint": "3-4"}, "unknown option of diodem 'joint'; known: segments, imu, optical_delay"),
        ({"source": "x"}, "unknown option of diodem 'source'; known: segments, imu, optical_delay"),
        ({"optical_delay": "late"}, "optical_delay: expected a number, got 'late'"),
        ({"optical_delay": "nan"}, "optical_delay: expected a number >= 0, got nan"),
    ],
)
def test_diodem_wrong_option(tmp_path, options, message):
    with pytest.raises(InputError, match=f"^{message}$"):
        CONVERTERS["diodem"](tmp_path, **options)


def test_diodem_bad_sources(tmp_path):
    convert = CONVERTERS["diodem"]
    with pytest.raises(InputError, match=r"nowhere: expected a file or folder for converter diodem, got nothing"):
        convert(tmp_path / "nowhere")
    with pytest.raises(InputError, match=r"imu_rigid\.csv: expected a file, got nothing of that name"):
        convert(tmp_path)
    trial = diodem_trial(tmp_path / "degrees", units="seconds/meters/degrees/a.u.")
    with pytest.raises(InputError, match=r"imu_rigid.csv, line 2: expected units seconds/meters/radians, got .*degree"):
        convert(trial)
    trial = diodem_trial(tmp_path / "norate")
    path = trial / "omc.csv"
    text = path.read_text()
    path.write_text(text.replace("# sampling frequency: 30", "# 30"))
    with pytest.raises(InputError, match=r"omc.csv, line 1: expected '# sampling frequency: RATE', got '# 30'"):
        convert(trial)
    path.write_text(text.replace("seg3_quat_w", "seg3_quat_a"))
    with pytest.raises(InputError, match=r"omc.csv: expected column 'seg3_quat_w', got seg1_quat_w, .* and 10 more"):
        convert(trial)
    path.write_bytes(text.encode().replace(b"# units", b"# unit\xe9"))
    with pytest.raises(InputError, match=r"omc.csv, line 2: expected UTF-8 text, got byte 0xe9"):
        convert(trial)
    trial = diodem_trial(tmp_path / "sideways", optical_turn=(np.sqrt(0.5), np.sqrt(0.5), 0, 0))
    with pytest.raises(InputError, match=r"optical record of imu1: expected a world with z up, got .* 90 deg from z"):
        convert(trial)


@pytest.mark.parametrize(("cell", "row"), [("", 3), ("nan", 3), ("inf", 3)])
def test_diodem_hole_in_the_imu_table(tmp_path, cell, row):
    trial = diodem_trial(tmp_path / "t")
    path = trial / "imu_rigid.csv"
    lines = path.read_text().splitlines()
    column = lines[2].split(",").index("seg3_gyr_x")
    cells = lines[3 + row].split(",")
    cells[column] = cell
    lines[3 + row] = ",".join(cells)
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(
        InputError, match=rf"imu_rigid.csv, line {row + 4}, column 'seg3_gyr_x': expected a finite number"
    ):
        CONVERTERS["diodem"](trial)
