"""How coloured the noise may be: the bound holds for noise that is coloured, and is low where it is white."""

import numpy as np
import pytest
from scipy.signal import lfilter

from imubench.diagnosis.config.noise import COLOUR
from imubench.diagnosis.noise.colour_bound import CORNERS_HZ, frequencies, louder_where, powers, shares
from imubench.diagnosis.noise.coloured import spectra
from imubench.diagnosis.problem.averaging import Averaging

RATE, SAMPLES = 100.0, 1500


def noise(rng, share=0.0, corner=0.5):
    """White noise (n, 3) of power 1, with first-order noise of `share` of it beside."""
    keep = np.exp(-2 * np.pi * corner / RATE)
    drive = np.sqrt(share * (1 - keep**2)) * rng.standard_normal((5 * SAMPLES, 3))
    return (rng.standard_normal((5 * SAMPLES, 3)) + lfilter([1.0], [1.0, -keep], drive, axis=0))[-SAMPLES:]


def shown(rng, share=0.0, corner=0.5):
    """What a fit shows that leaves all noise, its level fitted."""
    left = noise(rng, share, corner)
    return spectra(left / left.std(), rng.standard_normal((SAMPLES, 3, COLOUR.draws)))


def test_the_power_of_first_order_noise_is_that_of_its_samples():
    rng = np.random.default_rng(1)
    f = np.fft.rfftfreq(SAMPLES, 1 / RATE)
    power = np.mean([np.abs(np.fft.rfft(noise(rng, 0.2, 1.0), axis=0)) ** 2 / SAMPLES for _ in range(30)], axis=(0, 2))
    want = 1 + 0.2 * powers(f, 1 / RATE)[np.argmin(np.abs(CORNERS_HZ - 1.0))]
    some = [slice(2, 8), slice(8, 20), slice(20, 60), slice(60, 200)]
    np.testing.assert_allclose([power[s].mean() for s in some], [want[s].mean() for s in some], rtol=0.08)


@pytest.mark.parametrize("corner", [0.5, 1.0, 2.0])
def test_coloured_noise_is_allowed_its_share(corner):
    rng = np.random.default_rng(2)
    at = int(np.argmin(np.abs(CORNERS_HZ - corner)))
    allowed = np.array(
        [shares(shown(rng, 0.15, corner), frequencies(SAMPLES, 1 / RATE), 1 / RATE)[at] for _ in range(40)]
    )
    assert np.mean(allowed > 0.12) > 0.95  # of a level that the coloured noise raised by 7 %
    assert np.all(allowed <= 0.2)


def test_white_noise_allows_little():
    rng = np.random.default_rng(3)
    allowed = [shares(shown(rng), frequencies(SAMPLES, 1 / RATE), 1 / RATE)[0] for _ in range(40)]
    assert np.median(allowed) < 0.05 and np.quantile(allowed, 0.9) < 0.1
    assert shares(None, frequencies(SAMPLES, 1 / RATE), 1 / RATE)[0] == 0.2


def test_a_drift_stands_beside_less_noise_where_none_is_shown():
    rng = np.random.default_rng(4)
    time = np.arange(SAMPLES) / RATE
    drift = [("imu1.gyro", time, np.repeat(time[:, None], 3, axis=1).reshape(-1, 1))]
    most = louder_where(drift, {}, {}, Averaging())
    white = louder_where(drift, {}, {"imu1.gyro": shown(rng)}, Averaging())
    coloured = louder_where(drift, {}, {"imu1.gyro": shown(rng, 0.15, 0.5)}, Averaging())
    fewer = [(name, t[::4], x.reshape(-1, 3)[::4].reshape(-1, 1)) for name, t, x in drift]
    averaged = louder_where(fewer, {}, {}, Averaging({"imu1.gyro": 0.5}))  # of four samples each
    assert averaged == pytest.approx(most, rel=0.02)  # as dense beside the white noise's density
    assert most > 10 and white < 0.4 * most and coloured > 0.6 * most
