"""A narrow-band hum: a motor, a fan, a loose strap.

Priors: its frequency anywhere up to some tens of hertz, its amplitude below that of a limb's motion (1 m/s^2).
"""

from collections.abc import Mapping

import numpy as np

from imubench.arrays import Array
from imubench.effects.effect import Effect, Error, Found, Numbers, Parameter, Reading, Values
from imubench.effects.wander import frequency_error
from imubench.recording import Imu


class Vibration(Effect):
    """The accelerometer hums; fitted as a cosine and a sine on each axis, about a start within 1 / (2 duration)."""

    name, place, law = "vibration", "imu", "accel reads f + amplitude sin(2 pi frequency t + phase)"
    phrase = "a hum at {imu}"
    channel, tone = "accel", "frequency"
    on_sensor = False  # a motor beside it hums, or its strap
    parameters = (
        Parameter("frequency", (), "Hz", 20.0, start=20.0),
        Parameter("cosine", (3,), "m/s^2", 1.0, reported=False),
        Parameter("sine", (3,), "m/s^2", 1.0, reported=False),
    )
    found = (Found("amplitude", (3,), "m/s^2"),)

    def error(self, reading: Reading, p: Values) -> Error:
        phase = (2 * np.pi) * p["frequency"] * reading.time
        c, s = np.cos(phase.value), np.sin(phase.value)
        return Error(accel=p["cosine"] * phase.through(c, -s) + p["sine"] * phase.through(s, c))

    def changing(self, values: Mapping[str, Array], imu: Imu) -> dict[str, float]:
        """The frequency's, by a phase that wanders."""
        along = np.linalg.svd(np.stack([values["cosine"], values["sine"]], axis=1))[0][:, 0]
        return {"frequency": frequency_error(imu.time, imu.accel @ along, float(values["frequency"][0]))}

    def read(self, values: Mapping[str, Array], states: Mapping[str, Array], step: float) -> dict[str, Array]:
        """Each axis' amplitude in the phase that the axes have in common: of that all but noise is."""
        both = np.stack([values["cosine"], values["sine"]], axis=1)
        return {"amplitude": both @ np.linalg.svd(both)[2][0]}

    def of_report(self, numbers: Numbers, rng: np.random.Generator) -> Numbers:
        """Amplitude sin(2 pi f t + phase), of a random phase where only the amplitude is told."""
        if "sine" in numbers or "amplitude" not in numbers:
            return numbers
        phase, amplitude = rng.uniform(0, 2 * np.pi), np.asarray(numbers["amplitude"])
        both = {"cosine": np.sin(phase) * amplitude, "sine": np.cos(phase) * amplitude}
        return {"frequency": numbers["frequency"], **both}


EFFECTS: tuple[Effect, ...] = (Vibration(),)
