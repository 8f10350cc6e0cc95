"""A hum whose phase wanders: the error of its frequency, against fits of a straight phase to simulated hums."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from imubench.effects.wander import frequency_error

RATE, FREQUENCY = 200.0, 31.3


def hum(rng: np.random.Generator, walk: float, noise: float, seconds: float, rate: float = RATE, motion: float = 0.0):
    """Return times (n,) and a hum (n,) of amplitude 0.3 with a walking phase, white noise and a slow motion."""
    time = 3.0 + np.arange(0, seconds, 1 / rate)
    phase = np.cumsum(walk / np.sqrt(rate) * rng.standard_normal(time.size)) + rng.uniform(0, 2 * np.pi)
    x = 0.3 * np.sin(2 * np.pi * FREQUENCY * time + phase) + noise * rng.standard_normal(time.size)
    return time, x + motion * np.sin(2 * np.pi * 1.3 * time)


def fitted(time, x):
    """Return the frequency of the sine that explains most, by search."""

    def left(f):
        return -abs(np.sum(x * np.exp(-2j * np.pi * f * time)))

    grid = FREQUENCY + np.linspace(-0.1, 0.1, 81)
    best = grid[np.argmin([left(f) for f in grid])]
    return minimize_scalar(left, bounds=(best - 0.003, best + 0.003), method="bounded", options={"xatol": 1e-7}).x


@pytest.mark.parametrize(("walk", "seconds", "rate"), [(0.05, 15.0, 200.0), (0.2, 15.0, 100.0), (0.05, 60.0, 100.0)])
def test_errors_are_as_large_as_said(walk, seconds, rate):
    rng = np.random.default_rng(5)
    runs = [hum(rng, walk, 0.02, seconds, rate) for _ in range(60)]
    errors = np.array([fitted(*run) - FREQUENCY for run in runs])
    said = np.array([frequency_error(*run, FREQUENCY + e) for run, e in zip(runs, errors, strict=True)])
    assert 0.75 < np.sqrt(np.mean(errors**2) / np.mean(said**2)) < 1.33
    assert np.median(said) > 0.4 * np.sqrt(np.mean(errors**2))


def test_a_walk_is_seen_where_the_loudness_is_noisier_than_the_phase():
    """As with a limit on the samples. Held against that loudness as its noise, none of these walks was seen."""
    rng = np.random.default_rng(8)
    runs = [hum(rng, 0.05, 0.01, 30.0) for _ in range(20)]
    uneven = [x * (1 + 0.15 * np.repeat(rng.standard_normal(30), len(x) // 30)) for _, x in runs]
    said = np.array([frequency_error(t, x, fitted(t, x)) for (t, _), x in zip(runs, uneven, strict=True)])
    true = 0.05 * np.sqrt(1.2 / 30.0) / (2 * np.pi)
    assert np.mean(said > 0) > 0.9
    assert np.sqrt(np.mean(said**2)) == pytest.approx(true, rel=0.3)


@pytest.mark.parametrize(("walk", "noise"), [(0.05, 0.1), (0.05, 0.3), (0.02, 0.1)])
def test_a_walk_that_noise_nearly_hides_is_allowed_for(walk, noise):
    """The likeliest walk was none, and every third frequency more than two standard deviations off."""
    rng = np.random.default_rng(9)
    off = []
    for _ in range(60):
        time, x = hum(rng, walk, noise, 15.0, 100.0)
        found = fitted(time, x)
        white = np.sqrt(6.0 / time.size) * noise / 0.3 / (np.pi * 15.0)
        off.append((found - FREQUENCY) / np.hypot(white, frequency_error(time, x, found)))
    assert np.mean(np.abs(off) < 1.96) > 0.87
    assert 0.3 < np.sqrt(np.mean(np.square(off))) < 1.3


def test_a_steady_hum_is_known_nearly_as_well_as_its_noise_lets_it_be():
    rng = np.random.default_rng(6)
    for noise in (0.01, 0.1, 0.3):
        white = np.sqrt(6.0 / (15.0 * RATE)) * noise / 0.3 / (np.pi * 15.0)
        said = [frequency_error(*hum(rng, 0.0, noise, 15.0, motion=10.0), FREQUENCY) for _ in range(50)]
        assert np.median(said) < 4 * white


def test_a_short_recording_or_one_with_holes_tells_nothing():
    rng = np.random.default_rng(7)
    time, x = hum(rng, 0.2, 0.01, 5.0)
    assert frequency_error(time, x, FREQUENCY) == 0.0
    time, x = hum(rng, 0.2, 0.01, 15.0)
    whole = (time < 6.0) | (time > 9.0)
    assert frequency_error(time[whole], x[whole], FREQUENCY) == 0.0
    assert frequency_error(time, 0 * x, FREQUENCY) == 0.0
