"""Imperfect rigs: the kinematics of joint play, zero imperfection is no imperfection, errors as physics wants them."""

from dataclasses import replace

import numpy as np
import pytest

from imubench import rotations
from imubench.errors import InputError
from imubench.estimators import banded
from imubench.reproduce.olsson2020 import imperfection_results, joint_play, robustness, robustness_exhibits
from imubench.reproduce.olsson2020.imperfection_exhibits import exhibits as imperfection_exhibits
from imubench.reproduce.olsson2020.imperfection_runs import SHAPES, end_axes, sweep, table_at_end
from imubench.reproduce.olsson2020.imperfections import (
    IMPERFECTIONS,
    NOMINAL,
    crossing,
    record_with,
    soft_mounts,
)
from imubench.reproduce.olsson2020.robustness_exhibits import exhibits as map_exhibits
from imubench.scenarios.olsson2020.motions import MOTIONS, paper_rig
from imubench.scenarios.olsson2020.plan import SEQUENCES as PLANS
from imubench.scenarios.olsson2020.sequences import assemble, join
from imubench.scenarios.olsson2020.session import record
from imubench.score import axis_deviation, rmsae
from imubench.sim.play import play
from imubench.sim.rigs import springs
from imubench.sim.sprung import UnheldSensorError

BRIEF = dict.fromkeys(range(1, 15), 10.0) | {6: 20.0}
RATE = 2000.0  # Hz, of the truth that is differentiated
LIMIT = 0.03  # rad
HOOKS = {
    "load": joint_play.play_under_load(paper_rig(), LIMIT),
    "hands": joint_play.play_under_hands(paper_rig(), LIMIT),
    "coupling": joint_play.axis_coupling(paper_rig(), np.array([0.02, -0.03])),
}


@pytest.fixture(scope="module")
def ideal():
    motion = MOTIONS[14].motion(np.random.default_rng(1), 10.0)
    return play(paper_rig(), motion, 12.0, RATE)


@pytest.fixture(scope="module", params=HOOKS)
def loose(request, ideal):
    return HOOKS[request.param](MOTIONS[14], ideal, np.random.default_rng(2))


def test_the_gyro_of_a_loose_segment_is_the_derivative_of_its_pose(loose):
    segment, sensor = loose.segments[1], loose.sensors[1]
    q = segment.quaternion
    between = rotations.log(rotations.multiply(rotations.conjugate(q[:-2]), q[2:])) * RATE / 2
    # Central differences of a rate up to 10 rad/s at 2 kHz: h^2/6 w'' is 1e-4.
    np.testing.assert_allclose(segment.rate[1:-1], between, atol=3e-4)
    np.testing.assert_allclose(sensor.gyro, segment.rate, atol=1e-12)  # identity mount: rounding only


def test_angular_and_linear_acceleration_are_derivatives_too(loose):
    segment, sensor, h = loose.segments[1], loose.sensors[1], 1 / RATE
    mean = (segment.angular_acceleration[1:] + segment.angular_acceleration[:-1]) / 2
    # The drive of the play under load is linear between samples: its second derivative has kinks, error h p''' ~ 5e-3.
    np.testing.assert_allclose(np.diff(segment.rate, axis=0) / h, mean, atol=5e-3)
    second = (sensor.position[2:] - 2 * sensor.position[1:-1] + sensor.position[:-2]) / h**2
    # h^2/12 of the fourth derivative, 1e-4, and h p''' times the 6 cm arm, 3e-4.
    np.testing.assert_allclose(sensor.acceleration[1:-1], second, atol=1e-3)


def test_specific_force_is_acceleration_minus_gravity(loose):
    sensor = loose.sensors[1]
    felt = rotations.rotate_back(sensor.quaternion, sensor.acceleration + np.array([0, 0, loose.gravity]))
    np.testing.assert_allclose(sensor.specific_force, felt, atol=1e-11)  # rounding of forces of up to 50 m/s^2


def test_no_turn_leaves_the_truth_as_mujoco_has_it(ideal):
    still = joint_play.axis_coupling(paper_rig(), np.zeros(2))(MOTIONS[14], ideal, np.random.default_rng(0))
    for key in ("gyro", "specific_force", "acceleration", "angular_acceleration", "position", "joint_axis"):
        # Two computations of the same kinematics: rounding of accelerations of up to 100 m/s^2.
        np.testing.assert_allclose(getattr(still.sensors[1], key), getattr(ideal.sensors[1], key), atol=1e-11)


def test_a_turned_mount_on_a_loose_segment_reads_the_same_vectors_in_its_own_axes(ideal):
    turn = joint_play.coupled(ideal, np.array([0.02, -0.03]))
    mount, q = paper_rig().mounts[1], rotations.random(np.random.default_rng(3))
    plain = joint_play.turned(ideal, mount, turn).sensors[1]
    other = joint_play.turned(ideal, replace(mount, quaternion=q), turn).sensors[1]
    for key in ("gyro", "specific_force", "joint_axis"):
        expected = rotations.rotate_back(q, getattr(plain, key))
        np.testing.assert_allclose(getattr(other, key), expected, atol=1e-11)  # rounding of up to 50 m/s^2


def test_play_stays_within_its_range_and_uses_it(ideal):
    for turn in (
        joint_play.loaded(ideal, paper_rig().segments[1], LIMIT),
        joint_play.pushed(ideal, np.random.default_rng(4), LIMIT, 1.0),
    ):
        size = np.linalg.norm(turn.angle, axis=1)
        assert size.max() <= LIMIT * (1 + 1e-12)  # critically damped: no overshoot; rounding
        assert size.max() > 0.5 * LIMIT  # hands and weight reach the outer half within 12 s


def test_a_limb_gives_way_downwards():
    motion = MOTIONS[6].motion(np.random.default_rng(5), 10.0)  # the axis tilts by 45 deg, so weight pulls across it
    ideal = play(paper_rig(), motion, 12.0, 50.0)
    loose = joint_play.play_under_load(paper_rig(), LIMIT)(MOTIONS[6], ideal, np.random.default_rng(0))
    com = paper_rig().segments[1].com
    height = [rotations.rotate(t.segments[1].quaternion, com)[:, 2].mean() for t in (ideal, loose)]
    # The moment is that of a weight at the 5.5 cm arm: cos 45 deg of it across the axis, so most of LIMIT is used.
    assert height[1] - height[0] < -0.2 * LIMIT * np.linalg.norm(com)


def test_a_tight_screw_closes_the_play_and_not_the_geometry(ideal):
    for name in ("load", "hands"):
        assert HOOKS[name](MOTIONS[9], ideal, np.random.default_rng(0)) is ideal
    assert HOOKS["coupling"](MOTIONS[9], ideal, np.random.default_rng(0)) is not ideal


def test_play_under_a_sprung_mount_is_refused(ideal):
    mount = paper_rig().mounts[1]
    soft = type(mount)(position=mount.position, translation=springs(30.0, 0.1))
    with pytest.raises(InputError, match=r"mount of imu2: expected a rigid one under joint play, got springs"):
        joint_play.turned(ideal, soft, joint_play.coupled(ideal, np.zeros(2)))


@pytest.fixture(scope="module")
def clean():
    return record(3, durations=BRIEF).recording


@pytest.mark.parametrize("name", IMPERFECTIONS)
def test_none_of_an_imperfection_is_the_clean_rig_bit_by_bit(name, clean):
    recording = record_with(name, 0.0, 3, BRIEF).recording
    for imu, expected in zip(recording.imus, clean.imus, strict=True):
        for key in ("time", "gyro", "accel"):
            np.testing.assert_array_equal(getattr(imu, key), getattr(expected, key))


@pytest.mark.parametrize("name", [n for n, i in IMPERFECTIONS.items() if n != "soft socket"])
def test_some_of_an_imperfection_changes_the_samples(name, clean):
    recording = record_with(name, IMPERFECTIONS[name].levels[-1], 3, BRIEF).recording
    moved = [
        not np.array_equal(getattr(imu, key), getattr(expected, key))
        for imu, expected in zip(recording.imus, clean.imus, strict=True)
        for key in ("time", "gyro", "accel")
        if getattr(imu, key).shape == getattr(expected, key).shape
    ]
    assert any(moved) or recording.imus[1].time.size != clean.imus[1].time.size


@pytest.mark.parametrize("level", [0.5, 2.0])
def test_the_error_of_a_tilted_socket_is_the_tilt(level):
    found = np.rad2deg(sweep("socket tilt", (level,), 0)["deviation"])
    np.testing.assert_allclose(found, level, atol=0.06)  # the clean rig errs by up to 0.04 deg, see the module's sweep


@pytest.mark.long
def test_larger_play_coupling_and_misalignment_err_more():
    for name in ("play under load", "axis coupling", "gyro misalignment"):
        found = sweep(name, IMPERFECTIONS[name].levels[1:5:3], 1)["deviation"]
        errors = [rmsae(d) for d in found]
        assert errors == sorted(errors)


@pytest.mark.long
def test_the_same_seed_gives_the_same_numbers():
    first, again = (sweep("play under hands", (1.0,), 2)["deviation"] for _ in range(2))
    np.testing.assert_array_equal(first, again)
    first, again = (table_at_end("socket tilt", 1.0, 1, 2, True)["deviation"] for _ in range(2))
    np.testing.assert_array_equal(first, again)


def test_the_levels_of_the_tables_are_levels_of_known_imperfections():
    for name, level in SHAPES.items():
        what = IMPERFECTIONS[name]
        assert min(what.levels) <= level <= max(what.levels)


def test_bad_names_and_levels_are_refused():
    with pytest.raises(InputError, match=r"unknown imperfection 'rust'; known: socket tilt, "):
        record_with("rust", 1.0, 0)
    with pytest.raises(InputError, match=r"socket tilt: expected a level of 0 deg or more, got -1"):
        record_with("socket tilt", -1.0, 0)


def test_a_crossing_is_interpolated_in_the_logarithms():
    levels = np.array([1.0, 10.0, 100.0])
    assert crossing(levels, 0.1 * levels, 3.0) == pytest.approx(30.0)
    assert np.isnan(crossing(levels, 0.01 * levels, 3.0))
    assert crossing(levels, 5.0 * levels, 3.0) == 1.0


def test_a_map_computes_only_where_the_limit_is_open():
    asked = []

    def at(x, y):
        asked.append((x, y))
        return np.full(2, robustness.LIMIT * x / 10.0)  # crosses the limit at x = 10, a power law

    x, y = np.array([0.1, 0.3, 1.0, 3.0, 9.0, 27.0, 81.0]), np.array([1.0, 2.0, 4.0])
    found = robustness.coarse_to_fine(at, x, y)
    np.testing.assert_allclose(found["error"], found["error"][:, :, :1] * np.ones(3), rtol=1e-12)  # the same for all y
    expected = robustness.LIMIT * x / 10.0
    np.testing.assert_allclose(
        found["error"][0, :, 0], expected, rtol=1e-2
    )  # 0.3 and 1 are not evenly spaced in the log
    assert len(asked) == found["computed"].sum() < x.size * y.size
    assert found["computed"][1].sum() == 0 and found["computed"][3].all()


@pytest.mark.long
def test_the_banded_map_is_of_the_banded_estimate():
    found = robustness.banded_map(1, (4.2, 8.5), (0.05, 0.2))
    assert np.isnan(found["error"][:, 0, 0]).all()  # springs that do not hold the sensor
    session = record(1, paper_rig(mounts=soft_mounts(8.5, 0.2)), durations=robustness.SHORTEST)
    recording = join(PLANS["sequence1"], session).recording
    expected = rmsae(axis_deviation(banded.estimate(recording).value, NOMINAL))
    assert found["error"][0, 1, 1] == expected


def test_an_offset_of_nothing_is_the_plain_sequence():
    line = robustness.offset_line(4, (0.0,))
    sequence = assemble("sequence1", 4, durations=robustness.SHORTEST)
    axes = end_axes(sequence.recording, np.random.default_rng([4, 6]), 3)
    assert line["error"][0, 0, 0] == rmsae(axis_deviation(axes, NOMINAL))


def _done(parts):
    return {p.name: {k: np.asarray(v) for k, v in p.run(**p.arguments).items()} for p in parts}


def _law(power, level_at_target, spread=1.0):
    """Return deviations (1 seed, k levels, 4, 2, 1, 2) in rad of an imperfection that follows a power law."""

    def of(what):
        errors = np.deg2rad(1.5) * (np.array(what.levels) / level_at_target) ** power
        by_sequence = errors[:, None] * np.array([1.0, 1.0, spread, spread])
        return by_sequence[None, :, :, None, None, None] * np.ones((1, 1, 1, 2, 1, 2))

    return of


def _swept(name, deviation):
    what = IMPERFECTIONS[name]
    return imperfection_results.Swept(what, np.array(what.levels), deviation(what))


def test_only_what_reaches_the_level_in_range_and_alike_counts_as_an_explanation():
    sweeps = {
        "socket tilt": _swept("socket tilt", _law(1, 1.5)),
        "gyro misalignment": _swept("gyro misalignment", _law(1, 1.9)),  # in all sequences alike, but out of range
        "play under load": _swept("play under load", _law(1, 1.0, spread=2.0)),  # in range, but not alike
        "soft socket": _swept("soft socket", _law(-2, 20.0)),  # in range: stiffer than the softest that is plausible
        "accel bias": _swept("accel bias", _law(1, 100.0)),  # never
    }
    row = imperfection_results.Row("clean rig", 0.0, False, np.full((1, 4, 2, 2), 0.01))
    biased = imperfection_results.Row("clean rig", 0.0, True, np.full((1, 4, 2, 2), 0.02), np.ones((1, 4, 2)))
    study = imperfection_results.Imperfect(sweeps, (row, replace(biased, seconds=None)), (biased,))
    shown = imperfection_exhibits(study)
    assert shown[0].finding == (
        "Of 5 imperfections, within plausible limits only socket tilt and soft socket bring all four sequences to 1.5 "
        "deg alike"
    )
    assert shown[0].draw().axes
    assert [row[5] for row in shown[1].rows] == ["yes", "no", "yes", "yes", "no"]
    assert "by +0.57 to +0.57 deg" in shown[2].finding
    assert all(len(row) == len(table.columns) for table in shown[1:] for row in table.rows)


def test_maps_say_where_they_cross_the_limit():
    x, y = np.array([1.0, 4.0, 16.0]), np.array([0.5, 2.0, 8.0])

    def drawn(name, x, y, errors):
        return robustness.Map(name, x, y, np.array([errors, errors]), np.ones(errors.shape))

    maps = {
        "bias": drawn("bias", x, y, robustness.LIMIT * np.hypot(x[:, None] / 8.0, y / 100.0)),
        "soft": drawn("soft", x, y, robustness.LIMIT * (6.0 / x[:, None]) ** 2 * np.ones(3)),
        "banded": drawn("banded", x[::2], y[::2], robustness.LIMIT * (3.0 / x[::2, None]) ** 2 * np.ones(2)),
        "offset": drawn(
            "offset", np.array([-40.0, 0.0, 40.0]), np.zeros(1), robustness.LIMIT * np.array([[2], [0], [1.6]])
        ),
    }
    bias, soft, below, offset = map_exhibits(maps)
    assert bias.finding == (
        "Alone, a gyroscope bias stops it from 8 deg/s on, an accelerometer bias from more than 8 m/s² on"
    )
    assert soft.finding.startswith("A mount must be stiffer than about 6.0 Hz, or about 6.0 Hz")
    assert below.finding.startswith("Below a band that the data choose the error of soft mounts is 0.25 times as large")
    assert offset.finding.startswith("A time offset is harmless up to 20 ms with all motions, and up to 20 ms")
    for figure in (bias, soft, below, offset):
        assert figure.draw().axes


def test_a_point_that_cannot_be_played_has_no_error_and_the_map_goes_on():
    """A map with an unplayed corner computes what lies beside it, as nothing can be interpolated there."""
    asked = []

    def at(x, y):
        asked.append((x, y))
        if x < 2.0 and y < 2.0:
            raise UnheldSensorError("sprung mount: expected springs that hold the sensor")
        return np.full(2, robustness.LIMIT / 100)  # far below: nowhere else is anything open

    x, y = np.array([1.0, 2.0, 3.0, 4.0, 5.0]), np.array([1.0, 2.0, 3.0, 4.0, 5.0])
    found = robustness.coarse_to_fine(at, x, y)
    expected = np.ones((5, 5), dtype=bool)
    expected[0, 0] = False
    np.testing.assert_array_equal(np.isfinite(found["error"]).all(axis=0), expected)
    beside = {(1.0, 2.0), (2.0, 1.0), (2.0, 2.0)}  # the levels between that touch the unplayed corner
    assert set(asked) == {(a, b) for a in x[::2] for b in y[::2]} | beside
    assert found["computed"].sum() == len(asked)


def test_the_soft_mounts_of_the_quick_map_are_played_or_counted(tmp_path, monkeypatch):
    """4.2 Hz, damped by 0.1, lets the sensor fall over: the run ended there, and MuJoCo left its log behind."""
    monkeypatch.chdir(tmp_path)
    found = robustness.soft_map(0, (4.2, 8.5), (0.1,))
    assert np.isnan(found["error"][:, 0]).all() and np.isfinite(found["error"][:, 1]).all()
    assert found["computed"].all()
    assert not list(tmp_path.iterdir())


def test_a_map_says_and_draws_what_cannot_be_played():
    x, y = np.array([4.2, 6.0, 8.5]), np.array([0.1, 0.8])
    error = robustness.LIMIT * (3.0 / x[:, None]) ** 2 * np.ones((2, 3, 2))
    error[:, 0, 0] = np.nan
    figure = robustness_exhibits.soft_figure(robustness.Map("soft", x, y, error, np.ones((3, 2))))
    assert "Of 6 points 5 could be played" in figure.text
    assert figure.finding.startswith("A mount must be stiffer than about 4.2 Hz, or about 4.2 Hz with 20 s")
    (legend,) = figure.draw().legends
    assert [t.get_text() for t in legend.get_texts()] == [
        "cannot be played (1 of 6 points): the sensor leaves its springs' range; hatched: open up to there"
    ]


def test_a_level_that_cannot_be_played_is_left_out_of_a_sweep_and_said():
    found = sweep("soft socket", (15.0, 2.0), 0)["deviation"]
    assert np.isfinite(found[0]).all() and np.isnan(found[1]).all()
    what = IMPERFECTIONS["soft socket"]
    swept = imperfection_results.Swept(what, np.array([15.0, 2.0]), found[None])
    assert swept.at(15.0) == pytest.approx(swept.at(2.0))  # no error there: that of the softest that was played
    row = imperfection_results.Row("clean rig", 0.0, False, np.full((1, 4, 2, 2), 0.01))
    biased = imperfection_results.Row("clean rig", 0.0, True, np.full((1, 4, 2, 2), 0.02))
    figure, table, _ = imperfection_exhibits(imperfection_results.Imperfect({"soft socket": swept}, (row, biased), ()))
    for text in (figure.text, table.text):
        assert "Cannot be played, because the sensor leaves its springs' range: soft socket at 2 Hz." in text
    assert "cannot be played" in [t.get_text() for t in figure.draw().legends[0].get_texts()]


@pytest.mark.slow
def test_a_quick_study_and_quick_maps_run_from_end_to_end():
    e = imperfection_results.QUICK
    shown = imperfection_exhibits(imperfection_results.gather(e, _done(imperfection_results.parts(e))))
    assert shown[0].finding == (
        "Of 3 imperfections, within plausible limits only socket tilt brings all four sequences to 1.5 deg alike"
    )
    maps = robustness.gather(robustness.QUICK, _done(robustness.parts(robustness.QUICK)))
    assert len(map_exhibits(maps)) == 4
