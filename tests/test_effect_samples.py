"""Filters, hums, backlash and what happens to single samples, against plain arithmetic."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from imubench.effects import EFFECTS, VARIANTS
from imubench.effects.effect import Reading, Scene
from imubench.jets import Jet
from imubench.links import Link, Motion

TIME = np.arange(0, 5.0, 0.01)
RNG = np.random.default_rng(4)
GYRO, ACCEL = RNG.normal(size=(2, len(TIME), 3)).cumsum(axis=1) * 0.3


def corrupted(name, seed=1, variant="", **parameters):
    (effect,) = [e for e in VARIANTS if e.name == name and e.variant == variant]
    before = TIME.copy(), GYRO.copy(), ACCEL.copy()
    out = effect.corrupt(TIME, GYRO, ACCEL, parameters, np.random.default_rng(seed))
    for kept, given in zip(before, (TIME, GYRO, ACCEL), strict=True):
        assert np.array_equal(kept, given)
    return out


def test_saturation_clips_its_channel():
    time, gyro, accel = corrupted("saturation", variant="gyro", limit=1.0)
    assert np.abs(gyro).max() == 1.0
    inside = np.abs(GYRO) < 1.0
    assert np.array_equal(gyro[inside], GYRO[inside])
    assert accel is ACCEL and time is TIME


def test_quantisation_rounds_its_channel():
    _, gyro, accel = corrupted("quantisation", variant="accel", step=0.05)
    assert_allclose(accel / 0.05, np.round(accel / 0.05), atol=1e-9)  # rounding of a division
    assert np.abs(accel - ACCEL).max() <= 0.025 + 1e-12
    assert gyro is GYRO


def test_missing_samples_are_gone_and_held_ones_repeat():
    time, gyro, _ = corrupted("dropouts", variant="missing", fraction=0.2)
    assert abs(1 - len(time) / len(TIME) - 0.2) < 0.06  # three deviations of a share of 500
    assert np.array_equal(gyro, GYRO[np.isin(TIME, time)])
    time, gyro, accel = corrupted("dropouts", variant="held", fraction=0.2)
    held = np.flatnonzero((gyro != GYRO).any(axis=1))
    assert time is TIME and abs(len(held) / len(TIME) - 0.2) < 0.06
    assert np.array_equal(gyro[held], gyro[held - 1]) and np.array_equal(accel[held], accel[held - 1])


def test_impacts_are_where_they_are_said_to_be():
    _, gyro, accel = corrupted("impacts", times=np.array([1.0, 3.2]))
    hit = TIME[np.linalg.norm(accel - ACCEL, axis=1) > 1.0]
    assert_allclose(np.unique(np.round(hit, 1)), [1.0, 3.2])
    assert gyro is GYRO


@pytest.mark.parametrize(("name", "channel"), [("gyro_noise", 1), ("accel_noise", 2)])
def test_noise_has_its_level(name, channel):
    out = corrupted(name, std=0.05)
    changed = out[channel] - (TIME, GYRO, ACCEL)[channel]
    assert_allclose(changed.std(), 0.05, rtol=0.08)  # three deviations of a spread of 1500 numbers
    assert out[3 - channel] is (TIME, GYRO, ACCEL)[3 - channel]


@pytest.mark.parametrize("variant", ["", "gyro", "accel"])
def test_a_filtered_simulation_obeys_the_law_that_a_fit_holds(variant):
    """Between samples the truth is straight, so an integration of y' = w (x - y) over it gives the filter."""
    _, gyro, accel = corrupted("low_pass", variant=variant, cutoff=5.0)
    w = 2 * np.pi * 5.0
    for channel, x, y in (("gyro", GYRO, gyro), ("accel", ACCEL, accel)):
        if variant not in ("", channel):
            assert np.array_equal(x, y)
            continue

        def slope(t, now, x=x):
            return w * (np.array([np.interp(t, TIME, column) for column in x.T]) - now)

        exact = solve_ivp(slope, (0, 1), x[0], t_eval=TIME[:100], rtol=1e-8, atol=1e-9, max_step=0.001).y.T
        assert_allclose(y[:100], exact, atol=1e-5)  # the integration's error at the corners


def test_a_filters_state_is_what_comes_out_and_follows_what_goes_in():
    cutoff, t = 5.0, np.linspace(0, 1, 20)[:, None]
    w, f = 2 * np.pi * cutoff, 2 * np.pi * np.array([1.0, 2.0, 3.0])
    response = 1 / (1 + 1j * f / w)
    y, rate = (response * np.exp(1j * f * t)).imag, (1j * f * response * np.exp(1j * f * t)).imag
    still = Motion(Jet(np.zeros((1, 3))), Jet(np.zeros((1, 3))), Jet(np.sin(f * t)))
    states = [Jet(y), Jet(rate), Jet(0 * y)]
    scene = Scene(Jet(t), still, state=lambda _, order: states[order], mount=Link(), sensor=still)
    (effect,) = [e for e in VARIANTS if e.name == "low_pass" and e.variant == "accel"]
    (law,) = effect.equations(scene, {"cutoff": Jet(np.array([[cutoff]]))})
    assert_allclose(law.residual.value, 0.0, atol=1e-12)  # rounding
    reading = effect.filtered(Reading(Jet(GYRO), Jet(ACCEL), Jet(TIME[:, None])), scene, {})
    assert np.array_equal(reading.accel.value, y) and np.array_equal(reading.gyro.value, GYRO)


def test_a_hum_has_its_amplitude_and_its_sign_is_relative():
    amplitude, phase, f = np.array([0.4, -0.2, 0.1]), 0.9, 17.3
    hum = EFFECTS["vibration"]
    p = {"frequency": f, "cosine": amplitude * np.sin(phase), "sine": amplitude * np.cos(phase)}
    jets = {name: Jet(np.atleast_2d(value)) for name, value in p.items()}
    error = hum.error(Reading(Jet(GYRO), Jet(ACCEL), Jet(TIME[:, None])), jets)
    expected = amplitude * np.sin(2 * np.pi * f * TIME[:, None] + phase)
    assert_allclose(error.accel.value, expected, atol=1e-12)  # rounding
    assert error.gyro is None
    found = hum.read(p, {}, 0.01)["amplitude"]
    assert_allclose(found * np.sign(found[0]), amplitude, atol=1e-12)


def test_backlash_follows_between_its_stops():
    """The exact play against the law with rounded stops: both within a tenth of the range of each other."""
    time = np.linspace(0, 6, 6001)
    q, rate = 0.3 * np.sin(2 * time) + 0.1 * np.sin(7 * time), 0.6 * np.cos(2 * time) + 0.7 * np.cos(7 * time)
    backlash, size = EFFECTS["backlash"], 0.02
    side = backlash.played(q, size)
    assert np.abs(q - side).max() <= size + 1e-12
    assert np.all((np.diff(side) == 0) | np.isclose(np.abs(q - side)[1:], size))

    def slope(t, gap):
        turning = [Jet(np.interp(t, time, x).reshape(1, 1)) for x in (q, rate, 0 * q)]
        states = [Jet(np.atleast_2d(gap)), Jet(np.zeros((1, 1))), Jet(np.zeros((1, 1)))]
        still = Motion(Jet(np.zeros((1, 3))), Jet(np.zeros((1, 3))), Jet(np.zeros((1, 3))))
        scene = Scene(Jet(np.array([[t]])), still, *turning, state=lambda _, order: states[order])
        (law,) = backlash.equations(scene, {"range": Jet(np.array([[size]]))})
        return -law.residual.value[0]

    gap = solve_ivp(slope, (0, 6), [0.0], t_eval=time[::20], max_step=0.005).y[0]
    assert np.abs(gap - (q - side)[::20]).max() < 0.1 * size
