"""The 14 motions of Olsson et al. 2020: what the paper says of each is measured on the truth."""

from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose

from imubench import rotations
from imubench.errors import InputError
from imubench.scenarios.olsson2020.motions import CHANGE, MARGIN, MOTIONS, paper_rig
from imubench.scenarios.olsson2020.session import Session, record
from imubench.scenarios.olsson2020.strokes import Clock, Composed, Product, Step, Sum, strokes, wander
from imubench.sim.signals import Sines, hand
from imubench.truth import Truth

SEEDS = (0, 1, 2, 3)
Y = np.array([0.0, 1.0, 0.0])
ROUNDING = 1e-12  # rates of 20 rad/s pass a few products of unit quaternions: some 1e-15 each
SEQUENTIAL, PLANAR, FREE, STIFF, STILL = (3, 4, 10, 11), (5, 6, 12, 13), (7, 14), (2, 9), (1, 8)

session = cache(record)


class Part:
    """The truth of one motion proper."""

    def __init__(self, of: Session, number: int) -> None:
        self.truth: Truth = of.truth
        first, last = np.searchsorted(of.truth.time, np.array(of.spans[number]) - 1e-6)
        self.rows = slice(int(first), int(last))
        self.time = of.truth.time[self.rows] - of.spans[number][0]
        self.gyro = [s.gyro[self.rows] for s in of.truth.sensors]
        self.accel = [s.specific_force[self.rows] for s in of.truth.sensors]
        self.joint_rate, self.joint_angle = of.truth.joint_rate[self.rows], of.truth.joint_angle[self.rows]
        self.axis = rotations.rotate(of.truth.segments[0].quaternion[self.rows], Y)  # world

    @property
    def speed(self) -> np.ndarray:
        return np.linalg.norm(self.gyro, axis=-1)  # (2, n) rad/s

    @property
    def axis_to_gravity(self) -> np.ndarray:
        return np.rad2deg(np.arccos(np.abs(self.axis[:, 2])))  # of a line without direction: 0 to 90 deg

    def lever_arm_terms(self) -> np.ndarray:
        """The right-hand side of eq. (17) from rates and lever arms alone, m/s^2."""
        terms = []
        for s in self.truth.sensors:
            w, dw, r = s.gyro[self.rows], s.angular_acceleration[self.rows], -s.joint_vector[self.rows]
            terms.append(np.sum(s.joint_axis[self.rows] * (np.cross(dw, r) + np.cross(w, np.cross(w, r))), axis=1))
        return terms[0] - terms[1]


def rms(x: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(x))))


def part(seed: int, number: int) -> Part:
    return Part(session(seed), number)


@pytest.mark.parametrize(
    "signal",
    [
        Sum(((2.0, Sines(1.0, 0.5)), (-0.5, hand(np.random.default_rng(1), 10, 1.0, 1.0)))),
        Product(hand(np.random.default_rng(2), 10, 1.0, 1.0), Sines(1.0, 0.3, 0.2, offset=2.0)),
        Composed(Sines([1.0, 0.5], [0.3, 0.7]), hand(np.random.default_rng(3), 10, 1.0, 1.0)),
        Step(2.0, 5.0),
        Clock(1.0, 9.0, 2.0),
        wander(np.random.default_rng(4), 10, 0.1, 0.5, 0.7),
        strokes(np.random.default_rng(5), 10, 2.0, 0.6),
    ],
    ids=("sum", "product", "composed", "step", "clock", "wander", "strokes"),
)
def test_derivatives_are_those_of_the_value(signal):
    time, h = np.linspace(0.1, 9.9, 2000), 1e-4
    before, at, after = signal(time - h), signal(time), signal(time + h)
    # Central differences err by h^2 / 6 times two derivatives more; no signal here is faster than 30 rad/s.
    assert_allclose((after[0] - before[0]) / (2 * h), at[1], atol=2e-6 * np.abs(at[1]).max())
    assert_allclose((after[1] - before[1]) / (2 * h), at[2], atol=5e-6 * np.abs(at[2]).max())


def test_a_clock_rests_exactly_and_runs_at_one():
    value, rate, change = Clock(2.0, 8.0, 1.0)(np.array([0.0, 2.0, 3.0, 5.0, 7.0, 8.0, 11.0]))
    assert rate.tolist() == [0, 0, 1, 1, 1, 0, 0]
    assert change.tolist() == [0] * 7
    assert_allclose(value, [0, 0, 0.5, 2.5, 4.5, 5, 5], atol=1e-12)  # rounding of sums of a few seconds


def test_a_wander_stays_within_its_limit():
    value, _, _ = wander(np.random.default_rng(0), 1000.0, 0.1, 0.5, 0.7)(np.linspace(0, 1000, 20000))
    assert np.abs(value - 0.7).max() < 0.1
    assert 0.3 < rms(value - 0.7) / 0.1 < 0.7  # "an rms of about half of it"


def test_the_list_is_the_papers():
    assert list(MOTIONS) == list(range(1, 15))
    for number in range(1, 8):
        slow, fast = MOTIONS[number], MOTIONS[number + 7]
        assert (slow.number, fast.number) == (number, number + 7)
        assert (slow.build, slow.tilt, slow.screw) == (fast.build, fast.tilt, fast.screw)
    assert [m.screw for m in MOTIONS.values()] == [n in (1, 2, 8, 9) for n in MOTIONS]


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("number", STILL)
def test_stationary_means_at_rest(seed, number):
    p = part(seed, number)
    assert not p.speed.any()
    assert not p.joint_rate.any()
    for accel in p.accel:
        assert (accel == accel[0]).all()
        assert np.linalg.norm(accel[0]) == pytest.approx(9.81, abs=1e-9)  # as test_play's


def test_the_two_stationary_motions_are_different_attitudes():
    for seed in SEEDS:
        assert rotations.angle_between(part(seed, 1).accel[0][0], part(seed, 8).accel[0][0]) > 0.05


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("number", STIFF)
def test_a_stiff_joint_does_not_turn_but_its_axis_does(seed, number):
    p = part(seed, number)
    assert np.abs(p.joint_rate).max() < ROUNDING
    assert np.ptp(p.joint_angle) < ROUNDING
    assert rms(p.speed) > 1.0
    assert np.ptp(np.rad2deg(np.arcsin(p.axis[:, 2]))) > 60.0  # freely: up and down ...
    assert np.linalg.norm(p.axis[:, :2].mean(axis=0)) < 0.9  # ... and round


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("number", SEQUENTIAL)
def test_sequential_means_segment_1_first_and_the_other_at_rest(seed, number):
    p = part(seed, number)
    first, second = p.time <= 25.0 - CHANGE / 2, p.time >= 25.0 + CHANGE / 2
    for phase, moving in ((first, 0), (second, 1)):
        assert p.speed[1 - moving, phase].max() < ROUNDING
        assert rms(p.speed[moving, phase]) > 1.5
        assert np.abs(np.cross(p.gyro[moving][phase], Y)).max() < ROUNDING  # about the hinge and nothing else
        assert np.ptp(p.axis[phase], axis=0).max() < ROUNDING
        assert np.ptp(p.accel[1 - moving][phase], axis=0).max() < 1e-9  # at rest: test_play's EXACT
    change = ~(first | second)
    assert change.sum() == round(CHANGE * 50) - 1
    assert p.speed[:, change].max() < 0.5  # rad/s, the change of grip is gentle
    assert np.abs(p.joint_rate[change]).max() < ROUNDING


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(("numbers", "angle"), [((3, 5, 10, 12), 90.0), ((4, 6, 11, 13), 45.0)])
def test_the_axis_stays_in_its_band_and_not_on_one_value(seed, numbers, angle):
    for number in numbers:
        p = part(seed, number)
        signed = np.rad2deg(np.arccos(-p.axis[:, 2])) if angle == 90.0 else p.axis_to_gravity
        assert np.abs(signed - angle).max() <= 5.0
        assert np.ptp(signed) > (5.0 if number in PLANAR else 0.01)  # sequential: two values, which may be close


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("number", PLANAR)
def test_planar_means_nearly_all_rotation_about_the_hinge(seed, number):
    for gyro in part(seed, number).gyro:
        assert 0.0 < rms(np.cross(gyro, Y)) < 0.1 * rms(gyro)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("number", PLANAR + FREE)
def test_simultaneous_means_that_both_segments_turn_each_in_its_own_way(seed, number):
    p = part(seed, number)
    assert min(rms(s) for s in p.speed) > 1.5
    assert np.mean(np.abs(p.speed[0] - p.speed[1]) > 0.1) > 0.75
    # Different beats leave chance correlation, of std 1/sqrt(30 strokes) or 0.18. Free: of the hinge's own rate.
    other = p.gyro[1][:, 1] if number in PLANAR else p.joint_rate
    assert abs(np.corrcoef(p.gyro[0][:, 1], other)[0, 1]) < 0.5


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("number", FREE)
def test_a_free_axis_goes_everywhere(seed, number):
    p = part(seed, number)
    assert np.ptp(np.rad2deg(np.arcsin(p.axis[:, 2]))) > 60.0
    assert rms(np.cross(p.gyro[0], Y)) > 0.5 * rms(p.gyro[0])


@pytest.mark.parametrize("seed", SEEDS)
def test_fast_means_about_twice_the_angular_rate(seed):
    for number in range(2, 8):
        slow, fast = part(seed, number), part(seed, number + 7)
        for segment in range(2):
            assert 1.6 < rms(fast.speed[segment]) / rms(slow.speed[segment]) < 2.4


@pytest.mark.parametrize("seed", SEEDS)
def test_nothing_leaves_the_range_of_an_mtw(seed):
    for sensor, imu in zip(session(seed).truth.sensors, session(seed).recording.imus, strict=True):
        assert np.abs(sensor.gyro).max() < 0.95 * imu.gyro_range  # 20 of 21 rad/s
        assert np.abs(sensor.specific_force).max() < 0.5 * imu.accel_range


@pytest.mark.parametrize("seed", SEEDS)
def test_motion_is_band_limited_and_no_sine(seed):
    for number in (2, 3, 5, 6, 7, 9, 10, 12, 13, 14):
        p = part(seed, number)
        still_part = number in SEQUENTIAL
        rate = p.gyro[0][p.time < 24.0, 1] if still_part else p.gyro[0][:, 1]
        power = np.abs(np.fft.rfft((rate - rate.mean()) * np.hanning(rate.size))) ** 2
        frequency = np.fft.rfftfreq(rate.size, 0.02)
        peak = int(np.argmax(power))
        # A windowed sine would have all of its power in the five lines around its peak.
        assert power[max(peak - 2, 0) : peak + 3].sum() < (0.9 if still_part else 0.75) * power.sum()
        assert power[frequency > 4 * MOTIONS[number].pace].sum() < 1e-3 * power.sum()


@pytest.mark.parametrize("seed", SEEDS)
def test_the_hinge_constraint_holds_throughout(seed):
    one, two = session(seed).truth.sensors
    across = [np.linalg.norm(np.cross(s.gyro, s.joint_axis), axis=1) for s in (one, two)]
    assert_allclose(across[0], across[1], atol=ROUNDING)  # eq. (14)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_acceleration_constraint_fails_where_the_axis_is_free(seed):
    violation = {}
    for number in MOTIONS:
        p = part(seed, number)
        assert_allclose(p.accel[0][:, 1] - p.accel[1][:, 1], p.lever_arm_terms(), atol=1e-9)  # test_play's EXACT
        violation[number] = rms(p.lever_arm_terms())
    for group, free in (((3, 4, 5, 6), 7), ((10, 11, 12, 13), 14)):
        assert max(violation[n] for n in group) < violation[free] / 20
    assert all(violation[n] < 1e-9 for n in STILL)
    assert 0.4 < violation[7] < 1.5 < violation[14] < 6.0  # m/s^2: lever arms of 6 cm times some 2 and 4 rad/s squared
    # A stiff joint that turns freely violates it as much: its lever arms differ all the same (docs).
    assert 0.5 < violation[2] / violation[7] < 1.5
    assert 0.5 < violation[9] / violation[14] < 1.5


@pytest.mark.parametrize("seed", SEEDS)
def test_the_joint_centre_moves_when_a_hand_carries_it(seed):
    for number in (*PLANAR, *FREE, *STIFF):
        p = part(seed, number)
        assert rms(p.truth.segments[0].acceleration[p.rows]) > 0.1  # m/s^2


def test_the_sockets_put_both_y_axes_along_the_hinge():
    for mount in paper_rig().mounts:
        assert mount.quaternion.tolist() == [1, 0, 0, 0]
    assert session(0).axes.tolist() == [[0, 1, 0], [0, 1, 0]]  # eq. (69)


def test_the_standard_motion_lasts_50_s():
    for start, end in session(0).spans.values():
        assert end - start == pytest.approx(50.0, abs=1e-9)  # sums of steps of 0.02 s
    assert session(0).truth.time.size == 14 * 50 * (50 + 2 * MARGIN)


def test_a_motion_too_short_says_so():
    with pytest.raises(InputError, match="duration of motion 3: expected 10 s or more, got 5 s"):
        MOTIONS[3].motion(np.random.default_rng(0), 5.0)
    with pytest.raises(InputError, match="duration of motion 3: expected a number > 0, got -1"):
        MOTIONS[3].motion(np.random.default_rng(0), -1)
