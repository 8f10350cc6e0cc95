"""A mount that is turned far from how it is declared: found where gyroscopes say that the joint's axis is."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from imubench import rotations
from imubench.diagnosis.candidates.mount_lever_arm import far_lever_arm
from imubench.diagnosis.candidates.mount_start import axis_in, far_turns, placed, with_turned_mount
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.pipeline import diagnose
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.solve.initialize import model_of
from imubench.diagnosis.solve.refit import log_evidence, refit
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case

FLIPPED, ACROSS, FAR = [0.0, 0.0, np.pi], [np.pi / 2, 0.0, 0.0], [1.2, -2.0, 0.5]
Y = np.array([0.0, 1.0, 0.0])


def recorded(tmp_path, effects, seed=65, **options):
    make_case(tmp_path / "r", "hinge", effects, seed, **{"seconds": 8.0} | options)
    return read(tmp_path / "r")[0]


def fit_of(tmp_path, effects, seed=65):
    return nominal_fit(recorded(tmp_path, effects, seed))


def posed(at, rotation):
    return ("mount_pose", at, {"rotation": rotation, "translation": [0.02, -0.01, 0.01]})


def test_the_axis_is_what_turns_across_it_leaves_equal():
    """Rates drawn at random; those of the other sensor by vector algebra alone."""
    rng = np.random.default_rng(4)
    w = rng.normal(size=(400, 3))
    for _ in range(10):
        j = rng.normal(size=3)
        j /= np.linalg.norm(j)
        found = axis_in(w, np.sum(np.cross(w, j) ** 2, axis=1))
        assert abs(found @ j) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize(
    ("at", "turn", "options"),
    [
        ("imu2", ACROSS, {}),
        ("imu1", FLIPPED, {}),
        ("imu2", FLIPPED, {"base": "fixed"}),
        ("imu1", ACROSS, {"encoder": True}),
        ("imu2", FAR, {}),
    ],
)
def test_a_far_turn_takes_the_axis_to_where_it_is_in_the_sensor(tmp_path, at, turn, options):
    """One of both signs does; a turn about the axis itself is the angle's."""
    model = model_of(recorded(tmp_path, [posed(at, turn)], **options))
    in_sensor = rotations.to_matrix(model.recording.imu(at).mount_quaternion).T @ Y
    true = Rotation.from_rotvec(turn).inv().apply(in_sensor)
    off = [Rotation.from_rotvec(t).inv().apply(in_sensor) @ true for t in far_turns(model, at)]
    assert max(off) > np.cos(0.1)


@pytest.mark.parametrize("effects", [[], [posed("imu2", [0.1, -0.05, 0.1])], [("rocking_mount", "imu2")]])
@pytest.mark.parametrize("base", ["free", "fixed"])
def test_where_gyroscopes_agree_nothing_is_begun_anew(tmp_path, effects, base):
    model = model_of(recorded(tmp_path, effects, base=base))
    assert far_turns(model, "imu1") == far_turns(model, "imu2") == []


@pytest.mark.parametrize(("at", "way"), [("imu2", [-0.4, 0.3, -0.2]), ("imu1", [0.3, 0.0, 0.4]), ("imu2", [0.0] * 3)])
def test_where_a_far_mount_is_the_joints_centre_reads_as_long_from_both(tmp_path, at, way):
    """Told how it is turned: where it is follows, whatever the joint's angle and however far it is away."""
    pose = ("mount_pose", at, {"rotation": FAR, "translation": way})
    model = model_of(recorded(tmp_path, [pose], vigour=1.5))
    found = far_lever_arm(placed(model, at, np.array(FAR), np.zeros(3)), at)
    assert found == pytest.approx(way, abs=0.03)


def test_without_the_other_imu_no_arm_is_sought(tmp_path):
    assert far_lever_arm(model_of(recorded(tmp_path, [], base="fixed")), "imu2") is None


@pytest.mark.slow
def test_begun_anew_a_far_turned_mount_is_where_it_is(tmp_path):
    """Begun as declared its fit goes astray; a turn about the axis, which the angle takes, is left out."""
    fit = fit_of(tmp_path, [posed("imu2", FAR)], seed=66)
    h = Hypothesis(EFFECTS["mount_pose"], "imu2")
    new, old = with_turned_mount(fit, h), refit(fit, (*fit.model.hypotheses, h))
    assert log_evidence(new) > log_evidence(old) + 1000
    told, true = (Rotation.from_rotvec(r) for r in (new.state.values[h.key("rotation")], FAR))
    in_sensor = fit.model.mounts["imu2"].turn.T @ Y
    assert told.inv().apply(in_sensor) @ true.inv().apply(in_sensor) > np.cos(0.05)


@pytest.mark.long
def test_what_is_no_pose_or_on_no_hinge_is_not_begun_anew(tmp_path):
    fit = fit_of(tmp_path, [posed("imu2", FLIPPED)])
    assert with_turned_mount(fit, Hypothesis(EFFECTS["gyro_scale"], "imu2")) is None
    make_case(tmp_path / "free", "free", [posed("imu1", FLIPPED)], 65, seconds=8.0)
    assert with_turned_mount(nominal_fit(read(tmp_path / "free")[0]), Hypothesis(EFFECTS["mount_pose"], "imu1")) is None


@pytest.mark.long
@pytest.mark.parametrize(
    ("at", "turn", "options"),
    [
        ("imu2", [0.0, 0.0, np.pi / 2], {"base": "fixed"}),
        pytest.param("imu2", ACROSS, {}, marks=pytest.mark.slow),
        pytest.param("imu1", FLIPPED, {}, marks=pytest.mark.slow),
    ],
)
def test_a_far_turned_mount_is_named_at_its_imu_alone(tmp_path, at, turn, options):
    make_case(tmp_path / "r", "hinge", [posed(at, turn)], 67, seconds=15.0, **options)
    found = diagnose(read(tmp_path / "r")[0])[0].findings
    assert [(f.effect, f.at, f.confidence > 0.9) for f in found] == [("mount_pose", at, True)]
