"""A gyroscope and an accelerometer that are not equally late: each has a filter of its own.

Prior: at the widest filters of the MPU-9250 the gyroscope is 0.2 to 2.9 ms late and the accelerometer 0.8 to 1.9 ms
(RM-MPU-9250A-00 rev 1.6, registers 27 and 29). Such limits are taken as three standard deviations: 1 ms.
"""

import numpy as np

from imubench.arrays import Array
from imubench.effects.effect import Effect, Error, Parameter, Reading, Values
from imubench.jets import Jet

AHEAD = "ahead"


class AccelAhead(Effect):
    """The accelerometer shows the world a little earlier than the gyroscope does, as fast as its readings change."""

    name, place, law = "accel_ahead", "imu", "y(t) = x(t) + ahead x'(t), x' as read"
    phrase = "an accelerometer of {imu} that is ahead of its gyroscope"
    given = True
    parameters = (Parameter(AHEAD, (), "s", 1e-3),)

    def __init__(self, time: Array, slope: Array) -> None:
        """Take times (n,) s of the world and how fast the accelerometer's readings change there (n, 3), m/s^3."""
        self.time, self.slope = time, slope

    def error(self, reading: Reading, p: Values) -> Error:
        at = reading.time.value[:, 0]
        slope = np.stack([np.interp(at, self.time, x) for x in self.slope.T], axis=1)
        return Error(accel=p[AHEAD] * Jet(slope))


def accel_ahead(time: Array, slope: Array) -> Effect:
    """Return by how much an accelerometer is ahead, as a number of a fit; see `AccelAhead`."""
    return AccelAhead(time, slope)


__all__ = ["accel_ahead"]
