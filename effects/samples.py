"""What happens to single samples. It is found in the raw samples, before any fit, and masked there.

Each law is that of plain arrays: `corrupt` turns what a simulation samples into what the file would hold.
"""

from collections.abc import Mapping
from typing import ClassVar, Literal

import numpy as np

from imubench.arrays import Array
from imubench.effects.effect import Change, Effect, Found
from imubench.effects.traits import Fault

Samples = tuple[Array, Array, Array]
Channel = Literal["gyro", "accel"]
NEXT_NOISE = Change(share=0.15)  # as far as a declared noise may be off: it goes with temperature and with what shakes
NEXT_STEP = Change(share=1e-3)  # a setting; this much is how closely the step is read off
KNOCK, KNOCK_TIME = 30.0, 0.03  # m/s^2, s: height and length of a simulated knock


class _Channelled(Effect):
    """An effect on the gyroscope or on the accelerometer, whose units differ."""

    place = "imu"

    def __init__(self, channel: Channel) -> None:
        self.channel = self.variant = channel
        self.settings = {"channels": (channel,)}

    def put(self, samples: Samples, changed: Array) -> Samples:
        """Return the samples with this effect's channel changed."""
        time, gyro, accel = samples
        return (time, changed, accel) if self.channel == "gyro" else (time, gyro, changed)


def _unit(channel: Channel) -> str:
    return "rad/s" if channel == "gyro" else "m/s^2"


class Saturation(_Channelled):
    """The sensor's range ends."""

    name, law = "saturation", "y = x clipped at +-limit"
    phrase, fault = "readings of {imu} that are clipped", Fault.CLIPPED

    def __init__(self, channel: Channel) -> None:
        super().__init__(channel)
        self.found = (Found("limit", (), _unit(channel)),)

    def corrupt(
        self, time: Array, gyro: Array, accel: Array, parameters: Mapping[str, Array], rng: np.random.Generator
    ) -> Samples:
        x, limit = (gyro if self.channel == "gyro" else accel), float(parameters["limit"])
        return self.put((time, gyro, accel), np.clip(x, -limit, limit))


class Quantisation(_Channelled):
    """The sensor's steps are coarse."""

    name, law = "quantisation", "y = x rounded to a multiple of step"
    phrase, fault = "readings of {imu} that are rounded to steps", Fault.ROUNDED
    of_the_sensor = NEXT_STEP

    def __init__(self, channel: Channel) -> None:
        super().__init__(channel)
        self.found = (Found("step", (), _unit(channel)),)

    def corrupt(
        self, time: Array, gyro: Array, accel: Array, parameters: Mapping[str, Array], rng: np.random.Generator
    ) -> Samples:
        x, step = (gyro if self.channel == "gyro" else accel), float(parameters["step"])
        return self.put((time, gyro, accel), step * np.round(x / step))


class Dropouts(Effect):
    """Samples are lost: their rows are missing, or the last value is held."""

    name, place, law = "dropouts", "imu", "a fraction of the samples lost at random"
    phrase, fault = "samples of {imu} that are lost", Fault.LOST
    found = (Found("fraction", (), "1"),)

    def __init__(self, mode: Literal["missing", "held"]) -> None:
        self.mode = self.variant = mode
        self.settings = {"mode": mode}

    def corrupt(
        self, time: Array, gyro: Array, accel: Array, parameters: Mapping[str, Array], rng: np.random.Generator
    ) -> Samples:
        there = rng.uniform(size=time.size) >= float(parameters["fraction"])
        there[0] = True
        if self.mode == "missing":
            return time[there], gyro[there], accel[there]
        last = np.maximum.accumulate(np.where(there, np.arange(time.size), 0))
        return time, gyro[last], accel[last]


class Impacts(Effect):
    """Short knocks against the sensor."""

    name, place, law = "impacts", "imu", "a short pulse of specific force at each of `times`"
    phrase, fault = "knocks on {imu}", Fault.STRUCK
    found = (Found("times", (None,), "s"),)

    def corrupt(
        self, time: Array, gyro: Array, accel: Array, parameters: Mapping[str, Array], rng: np.random.Generator
    ) -> Samples:
        """Half a sine of 30 m/s^2 in a random direction, 0.03 s long from each time on."""
        accel = accel.copy()
        for start in np.atleast_1d(parameters["times"]):
            u = (time - start) / KNOCK_TIME
            direction = rng.normal(size=3)
            pulse = np.where((u > 0) & (u < 1), np.sin(np.pi * u), 0.0)
            accel += KNOCK * pulse[:, None] * direction / np.linalg.norm(direction)
        return time, gyro, accel


class GyroNoise(_Channelled):
    """The gyroscope is noisier than declared."""

    name, law = "gyro_noise", "white noise, `std` its total per sample"
    phrase: ClassVar[str] = "more noise of {imu}'s gyroscope than declared"
    fault = Fault.NOISY
    of_the_sensor = NEXT_NOISE
    found = (Found("std", (), "rad/s"),)

    def __init__(self, channel: Channel = "gyro") -> None:
        super().__init__(channel)
        self.variant, self.settings = "", {}

    def corrupt(
        self, time: Array, gyro: Array, accel: Array, parameters: Mapping[str, Array], rng: np.random.Generator
    ) -> Samples:
        """The samples given hold no noise of their own."""
        x = gyro if self.channel == "gyro" else accel
        return self.put((time, gyro, accel), x + float(parameters["std"]) * rng.normal(size=x.shape))


class AccelNoise(GyroNoise):
    """The accelerometer is noisier than declared."""

    name = "accel_noise"
    phrase = "more noise of {imu}'s accelerometer than declared"
    found = (Found("std", (), "m/s^2"),)

    def __init__(self) -> None:
        super().__init__("accel")


EFFECTS: tuple[Effect, ...] = (
    Saturation("gyro"), Saturation("accel"), Quantisation("gyro"), Quantisation("accel"),
    Dropouts("missing"), Dropouts("held"), Impacts(), GyroNoise(), AccelNoise(),
)  # fmt: skip
