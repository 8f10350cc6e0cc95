"""What a filter reads beside one that only delays: by its series where the delay is far below a sampling interval."""

import numpy as np
import pytest

from imubench.diagnosis.config.criteria import DELAY
from imubench.diagnosis.criteria.delays import beyond_delay, extrapolated
from imubench.effects import EFFECTS

RATE = 40.0
TIME = np.arange(800) / RATE


def swinging(hz):
    """Return readings (n, 3) of gyro and accel that swing at a frequency."""
    return {part: np.sin(2 * np.pi * hz * TIME[:, None] + np.arange(3)) for part in ("gyro", "accel")}


def exact(time, hz, delay):
    """Return LP[x](u + delay) - x(u) of a sine at the world's times u by its transfer function, long after it began."""
    w = 2 * np.pi * hz
    gain = np.exp(1j * w * delay) / (1 + 1j * w * delay) - 1
    return np.imag(gain * np.exp(1j * (w * time[:, None] + np.arange(3))))


@pytest.mark.parametrize("hz", [0.5, 3.0, 5.0])
@pytest.mark.parametrize("share", [0.0013, 0.5 * DELAY.short, 0.99 * DELAY.short, 1.5 * DELAY.short, 1.0])
def test_it_is_what_the_transfer_function_says(hz, share):
    delay = share / RATE
    time, x = extrapolated(TIME, swinging(hz), delay)
    c = beyond_delay(EFFECTS["low_pass"], time, x, delay)["accel"]
    inside = (time > 2) & (time < TIME[-1] - 2)
    want = exact(time, hz, delay)[inside]
    # a cubic spline's second derivative at 8 samples a period is 5 % off, a grid of 0.3 delays 4 %
    assert np.abs(c[inside] - want).max() < 0.1 * np.abs(want).max()


def test_a_short_delay_takes_no_finer_grid():
    time, _ = extrapolated(TIME, swinging(1.0), 33e-6)
    assert len(time) == len(TIME)
    fine, _ = extrapolated(TIME, swinging(1.0), DELAY.short / RATE)
    assert len(fine) < 130 * len(TIME)  # steps of 0.3 delays
