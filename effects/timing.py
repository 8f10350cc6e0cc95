"""Clocks that are late or run fast.

Priors: two loggers started by hand or synchronised over radio are some tens of milliseconds apart (0.05 s);
a quartz clock is right within 100 parts in a million, a processor's own oscillator within 1 % (0.003).
"""

from collections.abc import Mapping

import numpy as np

from imubench.arrays import Array
from imubench.effects.effect import Effect, Parameter, Values
from imubench.effects.traits import Alike
from imubench.jets import Jet
from imubench.recording import Recording

COMMON = "a common shift of both clocks only says when the motion was"
OPPOSITE = "the opposite one at the other sensor, where nothing else has a clock"


class _Clock(Effect):
    between_sensors = additive = True

    def places(self, recording: Recording) -> tuple[str, ...]:
        """Only differences show: an encoder's or a measured pose's clock is the measure, else the first IMU's.

        One that rests sees nothing that has a time, and is no measure of the other.
        """
        names, moving = super().places(recording), {imu.name for imu in recording.moving}
        measured = bool(recording.encoders or recording.poses) or len(moving) < len(names)
        return tuple(n for n in (names if measured else names[1:]) if n in moving)


class TimeOffset(_Clock):
    """The clock is late by a constant."""

    name, place, law = "time_offset", "imu", "stamp t shows the world at t - offset"
    phrase = "a clock of {imu} that is set wrong"
    late_by, in_every_sensor = "offset", True
    alike = (Alike(name, COMMON, OPPOSITE, only_imus=True),)
    parameters = (Parameter("offset", (), "s", 0.05),)

    def places(self, recording: Recording) -> tuple[str, ...]:
        """Two clocks must see a motion: all that the only one sees is as late as it is.

        Beside a fixed base the jerk with which a limb is let go gained 580 nat by an offset, for the splines' knots.
        """
        clocks = len(recording.moving) + len(recording.encoders) + len(recording.poses)
        return super().places(recording) if clocks > 1 else ()

    def clock(self, time: Jet, p: Values) -> Jet:
        return time - p["offset"]

    def aligned(self, values: Mapping[str, Array], step: float) -> dict[str, Array]:
        return {"offset": step * np.round(values["offset"] / step)}


class ClockSkew(_Clock):
    """The clock runs fast."""

    name, place, law = "clock_skew", "imu", "stamp t shows the world at t / (1 + skew)"
    phrase = "a clock of {imu} that runs too fast or too slow"
    alike = (Alike(name, COMMON, OPPOSITE, only_imus=True),)
    parameters = (Parameter("skew", (), "1", 0.003),)

    def clock(self, time: Jet, p: Values) -> Jet:
        return time / (1.0 + p["skew"])

    def aligned(self, values: Mapping[str, Array], step: float) -> dict[str, Array]:
        return {"skew": 0 * values["skew"]}


EFFECTS: tuple[Effect, ...] = (TimeOffset(), ClockSkew())
