"""Clocks that are late or run fast.

Priors: two loggers started by hand or synchronised over radio are some tens of milliseconds apart (0.05 s);
a quartz clock is right within 100 parts in a million, a processor's own oscillator within 1 % (0.003).
"""

from collections.abc import Mapping

import numpy as np

from imubench.arrays import Array
from imubench.effects.effect import Effect, Parameter, Values
from imubench.jets import Jet
from imubench.recording import Recording


class _Clock(Effect):
    def places(self, recording: Recording) -> tuple[str, ...]:
        """Only differences show: an encoder's or a measured pose's clock is the measure, else the first IMU's.

        One on a fixed base sees nothing that has a time, and is none.
        """
        names = super().places(recording)
        if recording.base == "fixed":
            return tuple(n for n in names if n != "imu1")
        return names if recording.encoders or recording.poses else names[1:]


class TimeOffset(_Clock):
    """The clock is late by a constant."""

    name, place, law = "time_offset", "imu", "stamp t shows the world at t - offset"
    parameters = (Parameter("offset", (), "s", 0.05),)

    def places(self, recording: Recording) -> tuple[str, ...]:
        """Beside a fixed base the other IMU alone tells no offset: all that moves is as late as it is.

        On knots of the splines that lay elsewhere, the jerk with which a limb is let go gained 580 nat by one.
        """
        alone = recording.base == "fixed" and not (recording.encoders or recording.poses)
        return () if alone else super().places(recording)

    def clock(self, time: Jet, p: Values) -> Jet:
        return time - p["offset"]

    def aligned(self, values: Mapping[str, Array], step: float) -> dict[str, Array]:
        return {"offset": step * np.round(values["offset"] / step)}


class ClockSkew(_Clock):
    """The clock runs fast."""

    name, place, law = "clock_skew", "imu", "stamp t shows the world at t / (1 + skew)"
    parameters = (Parameter("skew", (), "1", 0.003),)

    def clock(self, time: Jet, p: Values) -> Jet:
        return time / (1.0 + p["skew"])

    def aligned(self, values: Mapping[str, Array], step: float) -> dict[str, Array]:
        return {"skew": 0 * values["skew"]}


TIME_OFFSET = TimeOffset()
"""The one that a fit may begin with, whether it is in a library or not."""

EFFECTS: tuple[Effect, ...] = (TIME_OFFSET, ClockSkew())
