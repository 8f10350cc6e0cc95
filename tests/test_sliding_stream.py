"""The parts that make `sliding-stream` fast, each against the slow way to the same numbers."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.interpolate import make_lsq_spline

from imubench.errors import InputError
from imubench.estimators import sliding_search, sliding_spring
from imubench.estimators.gravity import GravityUkf
from imubench.estimators.sliding import SlidingStream
from imubench.estimators.sliding_lines import evidence
from imubench.estimators.sliding_rows import Rows, running
from imubench.estimators.sliding_search import Search
from imubench.estimators.sliding_splines import Basis, noise_of_sums, smoothed, splines
from imubench.estimators.sliding_spring_model import inverted
from imubench.estimators.sliding_stream import Window
from imubench.estimators.sliding_waves import Waves, oscillations
from tests.swinging_limb import BIG, NOISE, RATE, G, recorded, slide, sprung


def part(rows, first, last):
    """Rows of some of the samples."""
    return Rows(*(x[first:last] for x in (rows.time, rows.gyro, rows.accel, rows.up)), *NOISE)


# --- splines, turns ---


@pytest.mark.parametrize("uneven", [0.0, 0.2])
def test_rates_are_smoothed_as_scipy_does_whether_stamps_are_even_or_not(uneven):
    rows, _ = recorded(lambda t: slide(t), seed=3, duration=4.0)
    time = rows.time + uneven / RATE * np.random.default_rng(0).uniform(-1, 1, rows.time.size)
    found = smoothed(time, rows.gyro)
    since = time - time[0]
    scipys = make_lsq_spline(since, rows.gyro, found.basis.knots, 7)
    for k in range(5):
        theirs = scipys(since, k)
        assert_allclose(
            found.spline(since, k), theirs, atol=1e-9 * np.abs(theirs).max()
        )  # normal equations, 1e6 by 1e-16


def test_what_smoothing_keeps_of_noise_is_a_projection():
    basis = Basis.even(200, 0.01, 20)
    Q = np.linalg.qr(basis.design.toarray())[0]
    left = splines(200, 0.01)[1] @ Q
    assert_allclose(basis.kept, left @ left.T, atol=1e-9 * np.abs(basis.kept).max())  # rounding
    b = splines(200, 0.01)[0]
    assert_allclose(noise_of_sums(200, 0.01), (b @ b.T).toarray(), atol=1e-15)


def test_running_products_are_those_one_by_one():
    turns = np.linalg.qr(np.random.default_rng(0).normal(size=(37, 3, 3)))[0]
    expected = [np.eye(3)]
    for turn in turns:
        expected.append(expected[-1] @ turn)
    assert_allclose(running(turns), expected, atol=1e-14)  # rounding


def test_inverses_of_three_by_three():
    M = np.random.default_rng(0).normal(size=(50, 3, 3)) + 3 * np.eye(3)
    assert_allclose(inverted(M) @ M, np.broadcast_to(np.eye(3), M.shape), atol=1e-12)  # rounding


# --- oscillations ---


@pytest.mark.parametrize("felt", [True, False])
@pytest.mark.parametrize("rate", [50.0, 100.0, 200.0])
def test_waves_are_the_columns_that_any_r_has(felt, rate):
    fine, _ = recorded(lambda t: slide(t, BIG), felt, seed=1, duration=3.0)
    time = np.arange(round(3.0 * rate)) / rate
    rows = Rows(
        time,
        *(np.stack([np.interp(time, fine.time, x) for x in y.T], 1) for y in (fine.gyro, fine.accel, fine.up)),
        *NOISE,
    )
    frequency = np.array([0.3, 1.0, 5.7])
    value, change, _, _ = oscillations(time, frequency)
    r, dr = (np.einsum("nls,ia->nilas", x, np.eye(3)).reshape(time.size, 3, 18) for x in (value, change))
    expected = rows.predicted(r, dr, felt).reshape(-1, 3, 6)
    columns, slopes = Waves(rows).slopes(frequency, felt)
    assert_allclose(columns, expected, atol=1e-10 * np.abs(expected).max())  # rounding
    single = Waves(rows).scanned(frequency, felt).transpose(2, 0, 1)
    assert_allclose(single, expected, atol=2e-5 * np.abs(expected).max())  # single precision, sums of some hundred
    h = 1e-5
    later, earlier = (Waves(rows).slopes(frequency + e, felt)[0] for e in (h, -h))
    assert_allclose(slopes, (later - earlier) / (2 * h), atol=1e-6 * np.abs(slopes).max())  # (2 pi 3 s h)^2 / 6


def test_slope_and_curvature_are_those_of_the_evidence():
    rows, _ = recorded(lambda t: slide(t, BIG, ([0.004, -0.006, 0.003], 2.6, 1.0)), seed=2, duration=5.0)
    search, h = Search(rows, True), 1e-6
    at = np.array([1.0, 2.6])

    def bend(frequency):
        return search._bend(search._tried(np.zeros(0), frequency), 0)[0]

    def weight(frequency):
        return search._tried(np.zeros(0), frequency).evidence

    slope, curvature = search._bend(search._tried(np.zeros(0), at), 0)
    by = [(weight(at + e) - weight(at - e)) / (2 * h) for e in h * np.eye(2)]
    assert_allclose(slope, by, rtol=1e-3)  # the power is a fixed point of six rounds
    turns = [(bend(at + e) - bend(at - e)) / (2 * h) for e in h * np.eye(2)]
    assert_allclose(curvature, -np.array(turns), atol=0.03 * np.abs(turns).max())  # Gauss and Newton's, near the top


def test_a_frequency_that_is_no_longer_worth_it_is_left_out():
    rows, _ = recorded(lambda t: slide(t, BIG), seed=2, duration=6.0)
    search = Search(rows, True)
    search.start(np.array([1.0, 3.3]))
    search.prune()
    assert_allclose(search.found.frequency, [1.0], atol=0.01)  # Hz, three sigma of 6 s
    constant, _ = recorded(lambda t: slide(t), seed=2, duration=6.0)
    search = Search(constant, True)
    search.start(np.array([1.0, 3.3]))
    search.prune()
    assert search.found.frequency.size == 0


def test_samples_too_far_apart_to_smooth_are_refused():
    rows, _ = recorded(lambda t: slide(t), seed=2, duration=1.0)
    rare = Rows(500 * rows.time, rows.gyro / 500, rows.accel, rows.up, *NOISE)
    with pytest.raises(InputError, match=r"sliding: expected samples 0.125 s apart or closer, got 5 s"):
        sliding_search.fit(rare, True)


def test_a_record_too_short_for_its_equations_is_refused():
    rows, _ = recorded(lambda t: slide(t), seed=2, duration=0.5)
    with pytest.raises(InputError, match=r"sliding: expected 0.399 s or more, got 0.05 s"):
        Rows(rows.time / 10, rows.gyro, rows.accel, rows.up, *NOISE)


def test_a_rival_that_cannot_be_reached_ends_the_search():
    rows, _ = recorded(lambda t: slide(t, BIG, ([0.004, -0.006, 0.003], 2.6, 1.0)), seed=2, duration=5.0)
    whole, hopeless = sliding_search.fit(rows, False), sliding_search.fit(rows, False, rival=0.0)
    assert hopeless.frequency.size < whole.frequency.size
    assert hopeless.evidence < 0.0


# --- from one window to the next ---


def apart(one, other, covariance):
    """The distance of two r in standard deviations."""
    e = one - other
    return float(np.sqrt(e @ np.linalg.solve(covariance, e)))


@pytest.mark.parametrize("felt", [True, False])
def test_a_window_followed_has_the_fit_from_scratch_of_oscillations(felt):
    rows, _ = recorded(lambda t: slide(t, BIG, ([0.004, -0.006, 0.003], 2.6, 1.0)), felt, seed=2)
    before, now = sliding_search.fit(part(rows, 0, 800), felt), part(rows, 50, 850)
    scratch, followed = sliding_search.fit(now, felt), sliding_search.followed(now, before)
    assert followed.frequency.size == scratch.frequency.size
    assert followed.evidence > scratch.evidence - 0.2  # nat: NEAR, twice
    # A step may be left to what is straight: of a standard deviation, by what a frequency bends in it, some percent.
    assert apart(followed.at(8.5), scratch.at(8.5), scratch.covariance_at(8.5)) < 0.05


@pytest.mark.parametrize("tilt", [0.0, 0.3])
def test_a_window_followed_has_the_fit_from_scratch_of_a_spring(tilt):
    rows, _ = sprung(3.7, 0.2, seed=4)
    off = tilt * np.sin(rows.time / 3)[:, None] * np.array([1.0, 0.5, 0.0])  # m/s^2 that a filter may leave of gravity
    rows = Rows(rows.time, rows.gyro, rows.accel, rows.up + off, *NOISE)
    before, now = sliding_spring.fit(part(rows, 0, 800)), part(rows, 50, 850)
    scratch, followed = sliding_spring.fit(now), sliding_spring.followed(now, before, 50)
    # as above; the error of gravity is turned into the axes of the new first sample, without which it is 0.7
    assert apart(followed.values[-1], scratch.values[-1], scratch.last_covariance) < 0.1
    assert_allclose(followed.frequency, scratch.frequency, atol=0.004)  # Hz, a tenth of a standard deviation


def test_a_stream_answers_from_the_window_alone():
    rows, _ = recorded(lambda t: slide(t, BIG), seed=5, duration=9.5)
    stream = SlidingStream(*NOISE)
    for sample in zip(rows.gyro, rows.accel, rows.accel - rows.up, strict=True):
        r = stream.update(*sample, 1 / RATE)
    scratch = sliding_search.fit(part(rows, 100, 901), True)
    assert stream.fit.name == "felt"
    assert apart(r, scratch.at(9.49), scratch.covariance_at(9.49)) < 0.05  # as above
    assert_allclose(stream.covariance, scratch.covariance_at(9.49), rtol=0.02)  # the power of the noise in both


def test_covariances_at_one_time_are_those_over_many():
    rows, _ = recorded(lambda t: slide(t, BIG, ([0.004, -0.006, 0.003], 2.6, 1.0)), seed=2, duration=6.0)
    fit = sliding_search.fit(rows, True)
    r, covariance = fit.r(np.array([1.2, 7.0]))
    for k, time in enumerate((1.2, 7.0)):
        assert_allclose(fit.at(time), r[k], atol=1e-14)  # rounding
        assert_allclose(fit.covariance_at(time), covariance[k], rtol=1e-9)  # rounding


def test_another_kind_of_r_is_found_when_the_sensor_changes():
    still, _ = recorded(lambda t: slide(t), seed=5, duration=9.0)
    moved, r = recorded(lambda t: slide(t, BIG), seed=6, duration=12.0)
    stream = SlidingStream(*NOISE)
    names = []
    for rows in (still, moved):
        for sample in zip(rows.gyro, rows.accel, rows.accel - rows.up, strict=True):
            found = stream.update(*sample, 1 / RATE)
        names.append(stream.fit.name)
    assert names == ["constant", "felt"]
    assert np.linalg.norm(found - r[-1]) < 0.003  # m, as in test_sliding.py once the window is all of the new kind


# --- samples ---


def test_a_window_holds_the_last_seconds_in_order():
    window = Window(1.0)
    for k in range(3000):
        window.add(0.01 * k, [k, 0, 0], [0, k, 0], [0, 0, k])
    samples = window.samples
    assert_allclose(samples[:, 0], 0.01 * np.arange(2899, 3000), atol=1e-12)  # rounding of stamps
    assert_allclose(samples[:, [1, 5, 9]], np.repeat(np.arange(2899, 3000)[:, None], 3, axis=1))
    assert window.dropped == 2899


@pytest.mark.parametrize(
    ("gyro", "accel", "message"),
    [
        ([0.0, np.nan, 0.0], G, "gyro: expected finite numbers"),
        ([0.0, 0.0, 0.0], [0.0, 0.0, np.inf], "accel: expected finite numbers"),
        ([0.0, 0.0], G, r"gyro: expected shape \(3\), got \(2,\)"),
    ],
)
def test_a_bad_sample_leaves_the_stream_as_it_was(gyro, accel, message):
    rows, _ = recorded(lambda t: slide(t), seed=5, duration=3.0)
    streams = SlidingStream(*NOISE), SlidingStream(*NOISE)
    for k, sample in enumerate(zip(rows.gyro, rows.accel, rows.accel - rows.up, strict=True)):
        if k == 150:
            with pytest.raises(InputError, match=message):
                streams[0].update(gyro, accel, np.zeros(3), 0.01)
        one, other = (stream.update(*sample, 0.01) for stream in streams)
    assert_allclose(one, other, atol=0)


def test_a_gravity_filter_refuses_what_is_not_finite_and_stays_as_it_was():
    rows, _ = recorded(lambda t: slide(t), seed=5, duration=1.0)
    filters = GravityUkf(), GravityUkf()
    for k, (w, f) in enumerate(zip(rows.gyro, rows.accel, strict=True)):
        if k == 50:
            with pytest.raises(InputError, match="gravity filter: expected finite samples and steps, got gyro"):
                filters[0].update([0.0, np.inf, 0.0], f, 0.01)
        one, other = (x.update(w, f, 0.01) for x in filters)
    assert_allclose(one, other, atol=0)


def test_evidence_of_many_is_that_of_each():
    rng = np.random.default_rng(0)
    A, y = rng.normal(size=(3, 40, 5)), rng.normal(size=40)
    together = evidence(np.swapaxes(A, 1, 2) @ A, np.swapaxes(A, 1, 2) @ y, float(y @ y), 40)[0]
    for one, alone in zip(A, together, strict=True):
        assert evidence(one.T @ one, one.T @ y, float(y @ y), 40)[0] == pytest.approx(alone, abs=1e-9)  # rounding
