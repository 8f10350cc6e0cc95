"""Readings that follow the truth late: a first-order filter in the sensor or its driver.

Prior: low-pass filters of IMUs lie between some hertz and some hundreds; below 10 Hz a limb's motion is lost
and above half the sampling rate nothing shows (20 Hz, a factor of 2.5 either way).
"""

from collections.abc import Mapping

import numpy as np

from imubench.arrays import Array
from imubench.effects.effect import Change, Effect, Equation, Error, Parameter, Reading, Scene, State, Values
from imubench.jets import Jet

SIZES = {"gyro": 5.0, "accel": 15.0}  # rad/s, m/s^2: of what is filtered
NEXT_CUTOFF = Change(share=0.05)  # a setting of digital filters; resistors and capacitors of others are of 1 to 5 %
CLOSE = {"gyro": 0.01, "accel": 0.1}  # rad/s, m/s^2: how closely it obeys


class _Filter(Effect):
    name, place = "low_pass", "imu"
    phrase = "a low-pass filter in {imu}"
    filters, leaves_to = True, ("time_offset", "gyro_scale", "accel_scale")
    of_the_sensor = NEXT_CUTOFF
    parameters = (Parameter("cutoff", (), "Hz", 0.9, start=20.0, log=True),)

    def __init__(self, *channels: str) -> None:
        self.channels = channels or ("gyro", "accel")
        self.variant = "" if len(self.channels) == 2 else self.channels[0]
        self.settings = {"channels": self.channels}

    def corrupt(
        self, time: Array, gyro: Array, accel: Array, parameters: Mapping[str, Array], rng: np.random.Generator
    ) -> tuple[Array, Array, Array]:
        """Exact where the truth goes straight from one sample to the next; times evenly spaced."""
        from scipy.signal import lfilter  # here: long to import, and most commands do without

        out = {"gyro": gyro, "accel": accel}
        z = float(time[1] - time[0]) * 2 * np.pi * float(parameters["cutoff"])
        fade = np.exp(-z)
        gain = (1 - fade) / z  # the mean of the response over a step
        for c in self.channels:
            out[c] = lfilter([1 - gain, gain - fade], [1.0, -fade], out[c], axis=0, zi=gain * out[c][:1])[0]
        return time, out["gyro"], out["accel"]


class LowPass(_Filter):
    """The reading is filtered; what comes out is a state y of its own."""

    law = "y + y' / (2 pi cutoff) = x"

    def __init__(self, *channels: str) -> None:
        super().__init__(*channels)
        self.states = tuple(State(c, 3, SIZES[c]) for c in self.channels)

    def grid(self, seconds: float) -> dict[str, Array]:
        return {"cutoff": np.array([4.0, 8.0, 16.0, 32.0, 64.0])}

    def filtered(self, reading: Reading, scene: Scene, p: Values) -> Reading:
        gyro = scene.own("gyro")[0] if "gyro" in self.channels else reading.gyro
        accel = scene.own("accel")[0] if "accel" in self.channels else reading.accel
        return Reading(gyro, accel, reading.time)

    def equations(self, scene: Scene, p: Values) -> list[Equation]:
        _, sensor = scene.mounted()
        met = {"gyro": sensor.rate, "accel": sensor.force}
        speed = (2 * np.pi) * p["cutoff"]
        out = []
        for channel in self.channels:
            y, rate, _ = scene.own(channel)
            out.append(Equation(channel, y + rate / speed - met[channel], CLOSE[channel]))
        return out

    def far_quicker(
        self, time: Array, beside: Mapping[str, Array], slope: Mapping[str, Array], delay: float
    ) -> "QuickLowPass":
        return QuickLowPass(time, beside, slope, delay)


class QuickLowPass(_Filter):
    """The same where it is far quicker than the motion: a delay tau = 1 / (2 pi cutoff), and little beside.

    What a filter does beside delaying is taken from a motion that is known, c(t) at one delay and its slope, and held.
    A law's rows in the middle between knots would leave the motion as free there as a law allows.
    """

    law = "y(t) = x(t - tau) + c(t) + (tau - tau_0) c'(t), tau = 1 / (2 pi cutoff), c held"

    def __init__(self, time: Array, beside: Mapping[str, Array], slope: Mapping[str, Array], delay: float) -> None:
        """Take times (n,) s of the world, what gyro and accel (n, 3) read beside a `delay` in s, and that by s."""
        super().__init__()
        self.variant, self.time, self.beside, self.slope, self.delay = "quick", time, beside, slope, delay

    def clock(self, time: Jet, p: Values) -> Jet:
        return time - delay_of(p["cutoff"])

    def error(self, reading: Reading, p: Values) -> Error:
        longer = delay_of(p["cutoff"]) - self.delay
        at = reading.time.value[:, 0]
        c, slope = (
            {part: np.stack([np.interp(at, self.time, x) for x in held[part].T], axis=1) for part in held}
            for held in (self.beside, self.slope)
        )
        return Error(*(Jet(c[part]) + longer * slope[part] for part in ("gyro", "accel")))


def delay_of(cutoff: Jet) -> Jet:
    """Return the delay 1 / (2 pi cutoff) in s of what is far slower than a cutoff in Hz."""
    delay = 1 / (2 * np.pi * cutoff.value)
    return cutoff.through(delay, -delay / cutoff.value)


EFFECTS: tuple[Effect, ...] = (LowPass(), LowPass("gyro"), LowPass("accel"))
