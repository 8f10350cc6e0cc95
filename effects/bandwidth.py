"""Readings that follow the truth late: a first-order filter in the sensor or its driver.

Prior: low-pass filters of IMUs lie between some hertz and some hundreds; below 10 Hz a limb's motion is lost
and above half the sampling rate nothing shows (20 Hz, a factor of 2.5 either way).
"""

from collections.abc import Mapping

import numpy as np
from scipy.signal import lfilter

from imubench.arrays import Array
from imubench.effects.effect import Effect, Equation, Parameter, Reading, Scene, State, Values

SIZES = {"gyro": 5.0, "accel": 15.0}  # rad/s, m/s^2: of what is filtered
CLOSE = {"gyro": 0.01, "accel": 0.1}  # rad/s, m/s^2: how closely it obeys


class LowPass(Effect):
    """The reading is filtered; what comes out is a state y of its own."""

    name, place, law = "low_pass", "imu", "y + y' / (2 pi cutoff) = x"
    parameters = (Parameter("cutoff", (), "Hz", 0.9, start=20.0, log=True),)

    def __init__(self, *channels: str) -> None:
        self.channels = channels or ("gyro", "accel")
        self.variant = "" if len(self.channels) == 2 else self.channels[0]
        self.settings = {"channels": self.channels}
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

    def corrupt(
        self, time: Array, gyro: Array, accel: Array, parameters: Mapping[str, Array], rng: np.random.Generator
    ) -> tuple[Array, Array, Array]:
        """Exact where the truth goes straight from one sample to the next; times evenly spaced."""
        out = {"gyro": gyro, "accel": accel}
        z = float(time[1] - time[0]) * 2 * np.pi * float(parameters["cutoff"])
        fade = np.exp(-z)
        gain = (1 - fade) / z  # the mean of the response over a step
        for c in self.channels:
            out[c] = lfilter([1 - gain, gain - fade], [1.0, -fade], out[c], axis=0, zi=gain * out[c][:1])[0]
        return time, out["gyro"], out["accel"]


EFFECTS: tuple[Effect, ...] = (LowPass(), LowPass("gyro"), LowPass("accel"))
