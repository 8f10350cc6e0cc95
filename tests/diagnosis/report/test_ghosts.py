"""Simulated rigs in the world of what is drawn: the heading and the place that nobody measured are taken from there."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from rerun.chunk import RrdReader

from imubench.diagnosis.evidence import Posed
from imubench.diagnosis.report.ghosts import laid_on
from imubench.diagnosis.report.rerun_log import log_diagnosis
from imubench.log.scene import Motion
from imubench.recording import Pose
from imubench.reference import Reference
from imubench.rotations import exp, from_axis_angle, multiply, rotate
from tests.diagnosis.test_diagnosis_result import TIME, diagnosis, evidence

ROWS = slice(None, None, 4)
X, Y, Z = np.eye(3)


def drawn_motion():
    turn = np.stack([0.2 * np.sin(TIME), 0.1 * np.cos(TIME), 0.3 * TIME / TIME[-1]], axis=1)
    return Motion(TIME[ROWS], np.stack([TIME, 0 * TIME, 1 + 0 * TIME], axis=1)[ROWS] / 100, exp(turn)[ROWS])


def posed(motion, heading=0.0, away=(0.0, 0.0, 0.0)):
    """A hinge bent by 0.4 rad that moves like another, in a world that is turned and shifted."""
    yaw = from_axis_angle(Z, heading)
    place, turn = rotate(yaw, motion.position) + away, multiply(yaw, motion.quaternion)
    second = multiply(turn, from_axis_angle(Y, 0.4))
    sensor = place + rotate(second, 0.1 * X)
    return Posed(motion.time, {"segment1": (place, turn), "segment2": (place, second)}, {"imu2": (sensor, second)})


def test_a_heading_and_a_place_that_nobody_measured_are_those_that_are_drawn():
    drawn = drawn_motion()
    segments, sensors = laid_on(posed(drawn, 1.1, (3.0, -2.0, 0.5)), evidence().recording, drawn)
    assert_allclose(segments["segment1"].position, drawn.position, atol=1e-9)
    assert_allclose(np.abs(np.sum(segments["segment1"].quaternion * drawn.quaternion, axis=1)), 1.0)
    away = sensors["imu2"].position - segments["segment2"].position
    assert_allclose(away, rotate(segments["segment2"].quaternion, 0.1 * X), atol=1e-9)


def test_a_measured_pose_is_left_as_it_is_simulated():
    drawn = drawn_motion()
    still = np.tile([1.0, 0, 0, 0], (TIME.size, 1))
    recording = replace(evidence().recording, poses=(Pose("segment1", TIME, np.zeros((TIME.size, 3)), still),))
    segments, _ = laid_on(posed(drawn, 0.3, (0.02, 0.0, 0.0)), recording, drawn)
    assert_allclose(segments["segment1"].position, rotate(from_axis_angle(Z, 0.3), drawn.position) + 0.02 * X)


def logged(tmp_path, shown, reference=None):
    log_diagnosis(tmp_path / "d.rrd", diagnosis(), shown, reference)
    chunks = RrdReader(str(tmp_path / "d.rrd")).stream().collect()

    def read(path, component):
        table = chunks.reader(index="sim_time", contents=path).to_pandas()
        names = [c for c in table.columns if c.endswith(component)]
        return np.array([list(v) for v in table[names[0]].dropna()]) if names else np.zeros(0)

    return read


@pytest.mark.parametrize("measured", [False, True])
def test_both_models_are_drawn_beside_the_motion(measured, tmp_path):
    drawn, shown = drawn_motion(), evidence()
    played = (posed(drawn, 0.2), posed(drawn, -0.5))
    (one,) = shown.comparisons[0]
    shown = replace(shown, posed=played, simulated=(one,))
    second = multiply(drawn.quaternion, from_axis_angle(Y, 0.4))
    seen = Reference(drawn.time, np.full(drawn.time.size, 0.4), drawn.quaternion, second, drawn.position)
    read = logged(tmp_path, shown, seen if measured else None)
    for name in ("declared_model", "with_the_findings"):
        for part in ("segment1", "segment2", "imu2"):
            assert read(f"/world/{name}/{part}", "Transform3D:quaternion").size
    if measured:  # drawn as it was measured, the simulated ones laid on it
        turns = read("/world/segment1", "Transform3D:quaternion")[:, 0]
        beside = read("/world/with_the_findings/segment1", "Transform3D:quaternion")[:, 0]
        assert_allclose(np.abs(np.sum(turns[: len(beside)] * beside, axis=1)), 1.0, atol=1e-6)
    for name, values in (("declared_model", one.before), ("with_the_findings", one.after)):
        assert_allclose(read(f"/simulated/imu2/acc_x/{name}", "scalars")[:, 0], values)
        assert_allclose(read(f"/off/imu2/acc_x/{name}", "scalars")[:, 0], one.measured - values)


def test_where_nothing_was_found_one_simulation_is_drawn(tmp_path):
    drawn, shown = drawn_motion(), evidence()
    read = logged(tmp_path, replace(shown, posed=(posed(drawn),), simulated=shown.comparisons[0]))
    assert read("/world/with_the_findings/segment1", "Transform3D:quaternion").size
    assert not read("/world/declared_model/segment1", "Transform3D:quaternion").size
    assert not read("/off/imu2/acc_x/declared_model", "scalars").size
