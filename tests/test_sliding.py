"""An r that slides or hangs on a spring: equations, derivatives, evidence, recovery in batch and on a stream.

The limb here is NumPy alone: Euler angles, and accelerations by differences of where the sensor is.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar
from scipy.stats import chi2, multivariate_normal

from imubench.errors import InputError
from imubench.estimators import sliding, sliding_ekf, sliding_lines, sliding_search, sliding_spring
from imubench.estimators.centre_ekf import covariances_of
from imubench.estimators.centre_runs import track
from imubench.estimators.sliding import SlidingStream, answer, best
from imubench.estimators.sliding_rows import Rows
from imubench.estimators.sliding_splines import smoothed
from imubench.estimators.sliding_spring_model import Oscillators, SpringModel
from imubench.recording import Imu, Recording

RATE, NOISE = 100.0, (0.0017, 0.02)
R0 = np.array([-0.06, 0.02, 0.2])
G = np.array([0.0, 0.0, 9.81])
FINE = 1e-3  # s, of differences


def turned(t):
    """R (n, 3, 3), limb to world, of the paper's ellipse: Rz Rx Ry."""
    x, y, z = (
        np.deg2rad(d) * np.sin(2 * np.pi * f * t + p) for d, f, p in ((17, 1, 0), (9, 1, np.pi / 2), (3, 2 / 3, 0))
    )
    zero, one = np.zeros_like(t), np.ones_like(t)

    def matrix(*rows):
        return np.stack([np.stack(row, -1) for row in rows], -2)

    rx = matrix((one, zero, zero), (zero, np.cos(x), -np.sin(x)), (zero, np.sin(x), np.cos(x)))
    ry = matrix((np.cos(y), zero, np.sin(y)), (zero, one, zero), (-np.sin(y), zero, np.cos(y)))
    rz = matrix((np.cos(z), -np.sin(z), zero), (np.sin(z), np.cos(z), zero), (zero, zero, one))
    return rz @ rx @ ry


def first_difference(f, t):
    return sum(c * (f(t + k * FINE) - f(t - k * FINE)) for k, c in ((1, 3 / 4), (2, -3 / 20), (3, 1 / 60))) / FINE


def second_difference(f, t):
    pairs = ((1, 3 / 2), (2, -3 / 20), (3, 1 / 90))
    return (sum(c * (f(t + k * FINE) + f(t - k * FINE)) for k, c in pairs) - 49 / 18 * f(t)) / FINE**2


def rates(t):
    spin = np.swapaxes(turned(t), 1, 2) @ first_difference(turned, t)
    return np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=1)


def slide(t, *parts):
    """r(t): R0 and, of each part, amplitude (3,) m times sin(2 pi Hz t + phase)."""
    rest = np.broadcast_to(R0, (t.size, 3))
    return rest + sum(np.multiply.outer(np.sin(2 * np.pi * f * t + p), np.asarray(a)) for a, f, p in parts)


def recorded(r, felt=True, seed=None, duration=10.0, noise=NOISE):
    """Rows and true r (n, 3) of a sensor whose vector to the centre is the function r; no seed: no noise."""
    t = np.arange(round(duration * RATE)) / RATE
    R, w = turned(t), rates(t)
    Rt = np.swapaxes(R, 1, 2)

    def place(s):
        return -np.einsum("nij,nj->ni", turned(s), r(s))

    if felt:
        a = np.einsum("nij,nj->ni", Rt, second_difference(place, t))
    else:
        dw = first_difference(rates, t)
        a = -np.cross(dw, r(t)) - np.cross(w, np.cross(w, r(t)))
    if seed is not None:
        rng = np.random.default_rng(seed)
        w, a = w + noise[0] * rng.normal(size=w.shape), a + noise[1] * rng.normal(size=a.shape)
    return Rows(t, w, a + Rt @ G, Rt @ G, *noise), r(t)


def sprung(frequency, damping, seed=None, duration=10.0):
    """The same for a sensor on a spring and damper that pulls alike along all axes; it does not turn on the limb."""
    m, n, h = 2 * np.pi * frequency, round(duration * RATE), 0.25 / RATE
    halves = np.arange(8 * n) * h / 2
    R, dR, ddR = turned(halves), first_difference(turned, halves), second_difference(turned, halves)
    Rt = np.swapaxes(R, 1, 2)
    gravity, turning, carried = Rt @ G, 2 * Rt @ dR, Rt @ ddR

    def slope(k, x):
        inertial = -gravity[k] - carried[k] @ (x[0] - R0) - turning[k] @ x[1]
        return np.stack([x[1], inertial - m**2 * x[0] - 2 * damping * m * x[1]])

    x = np.empty((4 * n, 2, 3))
    x[0] = -gravity[0] / m**2, np.zeros(3)
    for k in range(4 * n - 1):  # Runge and Kutta's, four steps a sample
        k1 = slope(2 * k, x[k])
        k2 = slope(2 * k + 1, x[k] + h / 2 * k1)
        k3 = slope(2 * k + 1, x[k] + h / 2 * k2)
        x[k + 1] = x[k] + h / 6 * (k1 + 2 * k2 + 2 * k3 + slope(2 * k + 2, x[k] + h * k3))
    x, t = x[::4], np.arange(n) / RATE
    up = np.swapaxes(turned(t), 1, 2) @ G
    a, w = -(m**2) * x[:, 0] - 2 * damping * m * x[:, 1] - up, rates(t)
    if seed is not None:
        rng = np.random.default_rng(seed)
        w, a = w + NOISE[0] * rng.normal(size=w.shape), a + NOISE[1] * rng.normal(size=a.shape)
    return Rows(t, w, a + up, up, *NOISE), R0 - x[:, 0]


def mean_error(fit, rows, r):
    return np.linalg.norm(answer(fit, rows.time)[0] - r, axis=1).mean()


BIG = ([0.02, 0.005, 0.02], 1.0, 0.3)


# --- equations ---


@pytest.mark.parametrize("felt", [True, False])
def test_the_rows_say_what_the_accelerometer_reads(felt):
    def r(t):
        return slide(t, BIG, ([0.003, 0.01, -0.004], 2.3, 1.0))

    rows, truth = recorded(r, felt)
    off = rows.predicted(truth[..., None], first_difference(r, rows.time)[..., None], felt)[:, 0] - rows.measured
    # In units of noise; what is left is the smoothed rate's own error. Of the other kind it would be hundreds.
    assert np.abs(off).max() < 0.05


def test_a_vector_that_rests_in_the_world_can_be_added_to_any_felt_r():
    rows, _ = recorded(lambda t: slide(t, BIG))

    def added(t):
        return np.swapaxes(turned(t), 1, 2) @ np.array([0.05, -0.08, 0.1])

    c, rate = added(rows.time), first_difference(added, rows.time)
    unseen = rows.predicted(c[..., None], rate[..., None])
    seen = rows.predicted(c[..., None], 0 * rate[..., None])
    assert np.abs(unseen).max() < 0.05  # of the noise, as above
    assert np.abs(seen).max() > 20  # were it fixed to the sensor, 10 cm could not be overlooked


def test_the_smoothed_rate_is_nearer_to_the_truth_than_the_gyroscope():
    rows, _ = recorded(lambda t: slide(t), seed=3)
    spline, true = smoothed(rows.time, rows.gyro).spline, rates(rows.time)
    assert np.std(spline(rows.time) - true) < 0.4 * NOISE[0]  # 0.25 measured
    second = first_difference(lambda t: first_difference(rates, t), rows.time)
    assert np.std((spline(rows.time, 2) - second)[50:-50]) < 0.02 * np.std(second)  # at the ends it is free


def test_an_oscillator_does_what_the_solution_says():
    step, m, z = 0.01, 2 * np.pi * 3, 0.2
    t = np.arange(300) * step
    springs = Oscillators(np.full(3, m), z, np.zeros((300, 3, 6)), step)
    state = springs.under(np.tile(5 + 2 * t, (3, 1)).T[..., None], np.repeat([0.1, 0.3], 3)[:, None])[..., 0]
    found = solve_ivp(
        lambda s, y: [y[1], 5 + 2 * s - 2 * z * m * y[1] - m**2 * y[0]],
        (0, t[-1]),
        [0.1, 0.3],
        t_eval=t,
        rtol=1e-10,
        atol=1e-13,
    )
    assert_allclose(state[:, 0], found.y[0], atol=1e-9)  # exact for a straight u; the integration has 1e-10
    assert_allclose(state[:, 3], found.y[1], atol=1e-8)


# --- derivatives ---


def test_derivatives_of_the_oscillations():
    t, f = np.linspace(0, 5, 40), np.array([0.7, 2.3])
    sizes = np.random.default_rng(0).normal(size=21)
    h = 1e-6

    def parts(q):
        r, rate = sliding_lines.design(t, q[21:], q[:21])
        return np.stack([r[..., :21] @ q[:21], rate[..., :21] @ q[:21]])

    q = np.concatenate([sizes, f])
    J = np.stack(sliding_lines.design(t, f, sizes))
    for i in range(23):
        step = h * (np.arange(23) == i)
        assert_allclose(J[..., i], (parts(q + step) - parts(q - step)) / (2 * h), atol=1e-5)  # h^2 times 2 pi f t cubed
    later = sliding_lines.design(t + h, f, sizes)[0][..., :21] @ sizes
    earlier = sliding_lines.design(t - h, f, sizes)[0][..., :21] @ sizes
    assert_allclose(parts(q)[1], (later - earlier) / (2 * h), atol=1e-6)  # r' is the derivative of r


def test_derivatives_of_the_spring():
    rows, _ = sprung(3.7, 0.2, duration=3.0)
    model = SpringModel(rows)
    p = sliding_spring.MEAN + sliding_spring.STD * np.random.default_rng(1).normal(size=21) * 0.3
    moved = model.moved(p)
    for i in range(21):
        h = 1e-3 * sliding_spring.STD * (np.arange(21) == i)
        later, earlier = model.moved(p + h), model.moved(p - h)
        for ours, two, straight in (
            (moved.r_by()[..., i], (later.r, earlier.r), 0.01),
            (moved.by[:, i], (later.predicted, earlier.predicted), 0.02),
        ):
            numbers = (two[0] - two[1]) / (2 * h[i])
            # m and z: forces between samples are taken as straight, which is an error of (m step)^2 / 12 = 0.5 %, and
            # of twice that in the rows, which hold r'
            assert np.abs(ours - numbers).max() / np.abs(numbers).max() < (straight if 3 <= i <= 6 else 1e-6)


def test_the_springs_r_makes_the_rows_that_any_r_makes():
    rows, _ = sprung(3.7, 0.2, duration=3.0)
    p = sliding_spring.MEAN + 0.2 * sliding_spring.STD * (np.arange(21) < 12)
    moved = SpringModel(rows).moved(p)
    numbers = np.gradient(moved.r, 1 / RATE, axis=0, edge_order=2)
    of_any = rows.predicted(moved.r[..., None], numbers[..., None])[:, 0]
    # (2 pi 5 Hz step)^2 / 6 = 2 % of r', by the differences
    assert np.abs(moved.predicted - of_any).max() < 0.03 * np.abs(of_any).max()


@pytest.mark.parametrize("part", ["predicted", "measured"])
def test_derivatives_of_the_filter(part):
    x = np.random.default_rng(2).normal(size=sliding_ekf.STATES)
    step = {"predicted": lambda y: sliding_ekf.predicted(y, 0.013), "measured": sliding_ekf.measured}[part]
    h = 1e-6 * np.eye(x.size)
    numbers = np.stack([(step(x + e)[0] - step(x - e)[0]) / 2e-6 for e in h], axis=1)
    assert_allclose(step(x)[1], numbers, atol=1e-7)  # rounding over 1e-6, and its square


# --- evidence ---


def test_the_evidence_is_the_largest_likelihood_of_the_integrated_model():
    rng = np.random.default_rng(0)
    A, y = rng.normal(size=(30, 4)), 1.7 * rng.normal(size=30)
    ours, _, power = sliding_lines.evidence(A.T @ A, A.T @ y, float(y @ y), 30)

    def minus(logarithm):
        return -multivariate_normal(np.zeros(30), A @ A.T + np.exp(logarithm) * np.eye(30)).logpdf(y)

    found = minimize_scalar(minus, bounds=(-3, 4), method="bounded")
    assert power == pytest.approx(np.exp(found.x), rel=0.02)  # four rounds of a fixed point
    assert ours == pytest.approx(-found.fun + 15 * np.log(2 * np.pi), abs=0.05)  # the constant is left out


# --- recovery ---


def test_a_constant_stays_constant():
    rows, r = recorded(lambda t: slide(t), seed=0)
    fit = best(rows)
    a = track(rows.gyro[None], rows.acceleration[None], rows.time, 12, covariances_of("arve-d", "constant"))
    filtered = np.linalg.norm(a.r[0] - r[a.first :], axis=1).mean()
    assert fit.name == "constant"
    assert mean_error(fit, rows, r) < 1.2 * filtered  # asked for; 0.2 to 0.5 mm


def test_without_noise_a_constant_is_exact():
    rows, r = recorded(lambda t: slide(t), noise=(1e-5, 1e-4))
    assert mean_error(best(rows), rows, r) < 1e-4  # m


@pytest.mark.parametrize("frequency", [0.3, 1.0, 2 / 3, 2.7])
@pytest.mark.parametrize("phase", [0.0, 1.5])
def test_a_slide_of_unknown_frequency(frequency, phase):
    rows, r = recorded(lambda t: slide(t, (BIG[0], frequency, phase)), seed=1)
    fit = best(rows)
    assert fit.name == "felt"
    assert_allclose(fit.frequency, [frequency], atol=0.003)  # Hz; a 30th of one over the record
    assert mean_error(fit, rows, r) < 0.0015  # m; asked for are 5 mm, 0.2 to 0.9 are reached


def test_two_slides_at_once():
    rows, r = recorded(lambda t: slide(t, BIG, ([0.004, -0.006, 0.003], 2.6, 1.0)), seed=2)
    fit = best(rows)
    assert_allclose(np.sort(fit.frequency), [1.0, 2.6], atol=0.01)
    assert mean_error(fit, rows, r) < 0.002


@pytest.mark.parametrize("frequency", [0.3, 1.0, 4.0])
def test_a_slide_that_is_not_felt(frequency):
    rows, r = recorded(lambda t: slide(t, (BIG[0], frequency, 0.5)), felt=False, seed=3)
    fit = best(rows)
    assert fit.name == "unfelt"
    assert mean_error(fit, rows, r) < 0.0015


@pytest.mark.parametrize(("frequency", "damping"), [(6.0, 0.2), (3.7, 0.2), (3.0, 0.05), (3.7, 0.6)])
def test_a_spring(frequency, damping):
    rows, r = sprung(frequency, damping, seed=4)
    fit = best(rows)
    assert fit.name == "spring"
    assert fit.frequency == pytest.approx((frequency,) * 3, rel=0.08)  # three sigma of the stiffest
    assert mean_error(fit, rows, r) < 0.0015  # m; asked for are 5 mm


def test_the_covariance_is_right_where_its_model_is():
    squares = []
    for seed in range(24):
        rows, r = recorded(lambda t: slide(t, (BIG[0], 0.7, 0.2)), seed=100 + seed)
        value, covariance = answer(sliding_search.fit(rows, True), rows.time)
        e = value[500] - r[500]
        squares.append(e @ np.linalg.solve(covariance[500], e))
    low, high = chi2.ppf([0.001, 0.999], 3 * 24)
    assert low < np.sum(squares) < high


def recording_of(rows):
    imu = Imu("imu1", rows.time, rows.gyro, rows.accel, RATE, *NOISE)
    return Recording("limb", "pendulum", (imu,))


def test_what_an_orientation_filter_leaves_of_gravity_is_fitted_along():
    rows, r = recorded(lambda t: slide(t, BIG), seed=7)
    found = sliding.estimate(recording_of(rows), "ukf")  # which takes the first, moving, sample for up: 0.2 rad
    assert np.linalg.norm(found.value[:, 0] - r, axis=1).mean() < 0.0015  # m; as with a known orientation
    assert found.covariance is not None
    assert found.details["residual_power"] == pytest.approx(1.0, abs=0.15)  # 741 rows: 0.05 is one sigma


def test_an_r_that_no_kind_explains_has_no_covariance():
    rng = np.random.default_rng(0)
    parts = [(0.004 * rng.normal(size=3), f, rng.uniform(0, 6)) for f in rng.uniform(0.3, 3, size=16)]
    rows, _ = recorded(lambda t: slide(t, *parts), seed=8)
    found = sliding.estimate(recording_of(rows))
    assert found.covariance is None
    assert "no kind of r explains the samples" in found.no_covariance_because


# --- on a stream ---


def streamed(rows):
    stream = SlidingStream(*NOISE)
    return np.array(
        [stream.update(*x, 0.01) for x in zip(rows.gyro, rows.accel, rows.accel - rows.up, strict=True)]
    ), stream


@pytest.mark.parametrize("kind", ["constant", "felt", "unfelt", "spring"])
def test_a_stream_converges(kind):
    if kind == "spring":
        rows, r = sprung(3.7, 0.2, seed=5, duration=6.0)
    else:
        parts = () if kind == "constant" else (BIG,)
        rows, r = recorded(lambda t: slide(t, *parts), kind == "felt", seed=5, duration=6.0)
    found, stream = streamed(rows)
    assert np.isnan(found[:200]).all()
    assert np.isfinite(found[200:]).all()
    errors = np.linalg.norm(found - r, axis=1)[400:]
    assert stream.fit.name == kind
    assert errors.mean() < 0.003  # m; asked for are 10 mm, 2 s after the first answer 0.2 to 2 are reached
    assert np.linalg.eigvalsh(stream.covariance).min() > 0


def test_a_filter_bank_follows_a_fast_slide():
    rows, r = recorded(lambda t: slide(t, (BIG[0], 2.7, 0.0)), seed=6, duration=6.0)
    bank = sliding_ekf.SlidingBank()
    found = np.array([bank.update(w, a, 0.01) for w, a in zip(rows.gyro, rows.accel - rows.up, strict=True)])
    assert np.linalg.norm(found - r, axis=1)[400:].mean() < 0.01  # m, what is asked of a stream; 4.7 mm after 4 to 6 s
    with pytest.raises(InputError, match=r"sliding filter: expected a time step > 0 s, got -1\.0"):
        bank.update(rows.gyro[0], rows.accel[0], -1.0)


def test_filters_side_by_side_are_the_filters_one_by_one():
    rows, _ = recorded(lambda t: slide(t, (BIG[0], 2.7, 0.0)), seed=6, duration=1.0)
    starts = (0.5, 2.0)
    bank, alone = sliding_ekf.SlidingBank(starts), [sliding_ekf.SlidingFilter(f) for f in starts]
    for w, a in zip(rows.gyro, rows.accel - rows.up, strict=True):
        bank.update(w, a, 0.01)
        for one in alone:
            one.update(w, a, 0.01)
    for i, one in enumerate(alone):
        assert_allclose(one.x[0], bank.x[i], rtol=1e-9)  # rounding
        assert one.log_likelihood[0] == pytest.approx(bank.log_likelihood[i], rel=1e-9)
    best = int(np.argmax(bank.log_likelihood))
    assert_allclose(bank.update(w, a, 0.01), alone[best].update(w, a, 0.01), rtol=1e-9)


def test_a_stream_refuses_a_time_that_stands():
    stream = SlidingStream()
    stream.update(np.zeros(3), G, np.zeros(3), 0.0)
    with pytest.raises(InputError, match=r"sliding-stream: expected a time step > 0 s, got 0\.0"):
        stream.update(np.zeros(3), G, np.zeros(3), 0.0)


# --- what is refused ---


def test_samples_that_are_not_even_are_refused():
    t = np.arange(100) / RATE
    t[50:] += 0.03
    rate = np.random.default_rng(0).standard_normal((100, 3))
    imu = Imu("imu1", t, rate, np.tile(G, (100, 1)), RATE, *NOISE)
    with pytest.raises(InputError, match=r"sliding: expected samples 0.01 s apart, got 0.04 s before row 50"):
        sliding.estimate(Recording("r", "pendulum", (imu,)))


def test_too_few_samples_are_refused():
    t = np.arange(30) / RATE
    imu = Imu("imu1", t, np.zeros((30, 3)), np.tile(G, (30, 1)), RATE, *NOISE)
    recording = Recording("r", "pendulum", (imu,))
    assert sliding.estimate(recording).status == "not identifiable"
    with pytest.raises(InputError, match=r"r: sliding-stream expected 2 s or more, got 0.29 s"):
        sliding.estimate_stream(recording)
