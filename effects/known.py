"""Errors of a sensor that an earlier recording of it has told, with how well: known beforehand, and not looked for.

With z (k,) the numbers of some effects, one after the other, m what is expected of them and S = L L' their covariance::

    z = m + L u,    u ~ N(0, I)

and each effect adds to the reading what it does with its part of z (`sensor_errors`). A fit that has u in it is pulled
to m as tightly as the earlier recording tells, errors of any numbers that it could tell only together included.
"""

from collections.abc import Iterator, Sequence
from itertools import accumulate

import numpy as np

from imubench.arrays import Array
from imubench.effects.effect import Effect, Error, Parameter, Reading, Values
from imubench.jets import Jet

NAME = "known_errors"
NUMBERS = "u"


class KnownErrors(Effect):
    """What an earlier recording says of a sensor's own errors, all of which act sample by sample."""

    name, place, law = NAME, "imu", "y = x + what each effect of a sensor adds, its numbers m + L u"
    given = True

    def __init__(self, effects: Sequence[Effect], expected: Array, covariance: Array) -> None:
        """Take effects without states, their numbers' expected values (k,) and covariance (k, k), positive definite.

        Raises:
            numpy.linalg.LinAlgError: for another covariance.
        """
        self.effects = tuple(effects)
        self.expected, self.root = expected, np.linalg.cholesky(covariance)
        self.parameters = (Parameter(NUMBERS, (len(expected),), "1", 1.0),)
        widths = [p.width for e in self.effects for p in e.parameters]
        self._ends = list(accumulate(widths))

    def known_parts(self) -> Iterator[tuple[Effect, Parameter, Array, Array]]:
        first = 0
        for effect in self.effects:
            for p in effect.parameters:
                own = slice(first, first + p.width)
                first += p.width
                yield effect, p, np.asarray(self.root[own]), self.expected[own]

    def error(self, reading: Reading, p: Values) -> Error:
        numbers = p[NUMBERS].at(self.root) + self.expected
        gyro, accel, first = Jet(np.zeros((1, 3))), Jet(np.zeros((1, 3))), 0
        ends = iter(self._ends)
        for effect in self.effects:
            own = {}
            for parameter in effect.parameters:
                end = next(ends)
                own[parameter.name], first = numbers[list(range(first, end))], end
            added = effect.error(reading, own)
            gyro = gyro if added.gyro is None else gyro + added.gyro
            accel = accel if added.accel is None else accel + added.accel
        return Error(gyro, accel)


def known_errors(effects: Sequence[Effect], expected: Array, covariance: Array) -> Effect:
    """Return the effect that has all of some sample-by-sample errors of a sensor in it, as well as they are known.

    Args:
        effects: without states.
        expected: (k,) their numbers, one effect after the other.
        covariance: (k, k) of these, positive definite.

    Raises:
        numpy.linalg.LinAlgError: for another covariance.
    """
    return KnownErrors(effects, expected, covariance)


__all__ = ["KnownErrors", "known_errors"]
