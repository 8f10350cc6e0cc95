"""IMUs screwed on: what is found is small, and the optical record or the other joint says the same.

The optical record's say is a regression that knows nothing of the diagnosis: mean rates between its frames against the
gyroscope, and its markers' second derivative under 2 Hz against the accelerometer.
"""

import numpy as np
import pytest
from scipy.interpolate import make_lsq_spline
from scipy.signal import butter, sosfiltfilt
from scipy.spatial.transform import Rotation, Slerp

from imubench.alignment import optical_rate
from imubench.convert import CONVERTERS
from imubench.diagnosis.pipeline import diagnose
from imubench.diagnosis.solve.subset import cut
from imubench.jets import skew

pytestmark = pytest.mark.slow
SMALL = {"accel_bias": 0.15, "gyro_bias": 0.02, "accel_scale": 0.01, "gyro_scale": 0.02, "clock_skew": 3e-5}
JOINTS = ("3-4", "4-5")
START, END = 20.0, 45.0  # s, what is diagnosed
SLOW = 2.0  # Hz
UP = np.array([0.0, 0.0, 9.81])  # m/s^2


def optical_biases(imu, time, quaternion, markers):
    """Return the biases of gyroscope (3,) rad/s and accelerometer (3,) m/s^2 that the optical record says."""
    start, end, rate = optical_rate(time, quaternion, 2)
    middle = (start + end) / 2
    inside = (middle > imu.time[0]) & (middle < imu.time[-1])
    read = np.stack([np.interp(middle[inside], imu.time, x) for x in imu.gyro.T], axis=1)
    line = np.linalg.lstsq(np.c_[rate[inside], np.ones(inside.sum())], read, rcond=None)[0]
    left, _, right = np.linalg.svd(line[:3])
    turn = left @ right  # a row in segment axes, times this, is one in sensor axes

    seen = np.isfinite(markers).all(axis=1) & np.isfinite(quaternion).all(axis=1)
    stamps, knots = time[seen], time[seen][3:-3:3]
    spline = make_lsq_spline(stamps, markers[seen], np.r_[[stamps[0]] * 6, knots, [stamps[-1]] * 6], 5)
    attitude = Slerp(stamps, Rotation.from_quat(quaternion[seen], scalar_first=True))
    near = np.abs(stamps[np.clip(np.searchsorted(stamps, imu.time), 1, stamps.size - 1)] - imu.time) < 0.07
    t = imu.time[near & (imu.time > stamps[0] + 0.3) & (imu.time < stamps[-1] - 0.3)]
    force, rate = (np.stack([np.interp(t, imu.time, x) for x in y.T], axis=1) for y in (imu.accel, imu.gyro))
    felt = attitude(t).inv().apply(spline.derivative(2)(t) + UP) @ turn
    lever = skew(np.gradient(rate, t, axis=0)) + skew(rate) @ skew(rate)
    ones = np.broadcast_to(np.eye(3), (t.size, 3, 3))
    columns = np.concatenate([ones, lever, skew(felt), felt[:, :, None] * np.eye(3)], axis=2)
    slow = butter(3, SLOW, fs=1 / float(np.median(np.diff(t))), output="sos")
    A, b = (sosfiltfilt(slow, x, axis=0) for x in (columns, force - felt))
    return line[3], np.linalg.lstsq(A.reshape(-1, 12), b.ravel(), rcond=None)[0][:3]


@pytest.fixture(scope="module")
def found(recordings):
    """For each joint what is found, and the optical biases of its two IMUs."""
    file = recordings / "diodem" / "trial1" / "omc.csv"
    names = file.read_text(encoding="utf-8").splitlines()[2].split(",")
    table = np.genfromtxt(file, delimiter=",", skip_header=3)
    out = {}
    for joint in JOINTS:
        (made,) = CONVERTERS["diodem"](file.parent, segments=joint, imu="rigid")
        reference = made.reference
        optical = []
        for imu, q, segment in zip(
            made.recording.imus, (reference.quaternion1, reference.quaternion2), joint.split("-"), strict=True
        ):
            four = [[names.index(f"seg{segment}_marker{m}_{axis}") for axis in "xyz"] for m in (1, 2, 3, 4)]
            optical.append(optical_biases(imu, reference.time, q, table[:, four].mean(axis=1)))
        out[joint] = {f.effect + "@" + f.at: f for f in diagnose(cut(made.recording, START, END))[0].findings}, optical
    return out


def bias(found, joint, name):
    return np.asarray(found[joint][0][name].parameters["bias"].value)


@pytest.mark.parametrize("joint", JOINTS)
def test_only_small_things_are_named(found, joint):
    for f in found[joint][0].values():
        if f.named:
            value = f.parameters[f.effect.split("_")[1]]
            sure = np.abs(value.value) > 2 * np.asarray(value.std)
            assert np.all(np.abs(value.value)[sure] < SMALL[f.effect]), f.effect


@pytest.mark.parametrize(("joint", "imu"), [("3-4", "imu1"), ("3-4", "imu2"), ("4-5", "imu1")])
def test_accelerometers_are_biased_as_the_optical_record_says(found, joint, imu):
    """Along z, where the bias is largest: across it a mount within its declared 0.02 rad takes a part."""
    optical = found[joint][1][int(imu[-1]) - 1][1]
    assert bias(found, joint, f"accel_bias@{imu}")[2] == pytest.approx(optical[2], abs=0.04)


def test_two_joints_say_the_same_of_the_imu_between_them(found):
    one, other = bias(found, "3-4", "accel_bias@imu2"), bias(found, "4-5", "accel_bias@imu1")
    assert one[2] == pytest.approx(other[2], abs=0.02)


def test_two_gyroscopes_differ_as_the_optical_record_says(found):
    """A hinge shows the difference of both biases; their axes are parallel to some hundredths of a radian."""
    (first, _), (second, _) = found["4-5"][1]
    assert bias(found, "4-5", "gyro_bias@imu2") == pytest.approx(second - first, abs=3e-3)
