"""A drift, a jump or a walk of a sensor: told apart by their shape, beside noise as coloured as it may be.

A slow error over T s is a sum of w_j sqrt(2) cos(pi j t / T), in standard deviations of white noise. With M what a fit
knows of all w, motion, geometry and effects free to follow, and g the gradient of its likelihood by them::

    g ~ N(M w, R M R),   R^2 = 1 + a L(j / 2T)    noise louder by what is of first order: `slow_noise`, a <= 0.2
    w ~ N(0, P),         P = s^2 c c'             of a drift or a jump, c its cosines
                         P = s^2 diag(1 / j^2)    of a walk: Brownian motion less its mean, by Karhunen and Loeve

so that ln N(g; 0, R M R + M P M) is what a shape is worth, at its best size s, colour a and corner, in all channels or
one; a constant is free. Noise that may be as loud as all of a curve need not be so: white noise of which three cosines
are loud, as those of a jump are, is not coloured noise.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.linalg import solve_triangular

from imubench.arrays import Array
from imubench.diagnosis.config.discrepancy import BASIS, DRIFT, TERM
from imubench.diagnosis.config.shared import DECLARED_NOISE
from imubench.diagnosis.criteria.score_test import at_best_size, each
from imubench.diagnosis.discrepancy.candidate_terms import Maker
from imubench.diagnosis.discrepancy.term_scores import hypothesis_of
from imubench.diagnosis.discrepancy.terms import Term
from imubench.diagnosis.noise.colour_bound import powers
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.solve.schur import Base
from imubench.diagnosis.solve.threads import one_thread

COLOURED_POWERS = (
    0.15 * DECLARED_NOISE.colour,
    0.5 * DECLARED_NOISE.colour,
    DECLARED_NOISE.colour,
)  # of the white noise's power, that coloured noise may have


@dataclass(frozen=True)
class ShapeTest:
    """The same beside noise of one colour, and a constant, that have been made white."""

    alone: float  # log likelihood of no slow error at all
    reach: Array  # (r, 3 k) what a cosine does
    pull: Array  # (r,) what there is

    def worth(self, spread: Array) -> float:
        """Return the log likelihood of errors whose cosines are `spread` (3 k, q) times q numbers of the best size."""
        reached = self.reach @ spread
        values, vectors = np.linalg.eigh(reached.T @ reached)
        pull = (vectors.T @ (reached.T @ self.pull)) ** 2
        return self.alone + at_best_size(values, pull, BASIS.sizes)[0]


@dataclass(frozen=True)
class SlowErrors:
    """What a fit knows of slow errors of one triple, in r combinations of 3 k cosines that it knows anything of."""

    cosines: Array  # (n, k) at the sensor's samples
    beside: tuple[ShapeTest, ...]  # beside noise of each colour

    @classmethod
    def of(cls, fit: Fit, term: Term) -> "SlowErrors":
        """Return what a fit knows of slow errors of a term's triple."""
        time, seconds = term.time, float(term.time[-1] - term.time[0])
        cosines = cosines_at((time - time[0]) / seconds, min(int(2 * seconds * DRIFT.most_hz), DRIFT.most_cosines) + 1)
        every = Maker(term.at, term.part, time, fit.noise[f"{term.at}.{term.part}"]).every(term.goes_with, cosines)
        ((_, information, force),) = each(Base.of(fit), [hypothesis_of(every, 1.0)])
        step = fit.model.averaging.step(f"{term.at}.{term.part}", seconds / (len(time) - 1))
        return cls.told(cosines, seconds, step, information, force)

    @classmethod
    def told(cls, cosines: Array, seconds: float, step: float, information: Array, force: Array) -> "SlowErrors":
        """Return it from the information (3 k, 3 k) of all cosines over so many seconds, and the gradient (3 k,).

        `step`: s from one sample of the recording to the next.
        """
        count = cosines.shape[1]
        values, vectors = np.linalg.eigh(information)
        seen = vectors[:, values > DRIFT.least_information * values[-1]].T
        reach = seen @ information
        constants = DRIFT.free_constant * reach[:, ::count]
        out = []
        for louder in (np.ones(count), *noise_colours(np.arange(count) / (2 * seconds), step)):
            noisy = seen * np.sqrt(np.tile(louder, 3))
            factor = np.linalg.cholesky(noisy @ information @ noisy.T + constants @ constants.T)
            pull = solve_triangular(factor, seen @ force, lower=True)
            alone = -float(np.log(np.diag(factor)).sum()) - 0.5 * float(pull @ pull)
            out.append(ShapeTest(alone, solve_triangular(factor, reach, lower=True), pull))
        return cls(cosines, tuple(out))

    def worth(self, spread: Array) -> float:
        """Return the log likelihood of errors whose cosines in a channel are `spread` (k, q), beside the best colour.

        In all channels or one.
        """
        spreads = [np.kron(channels, spread) for channels in ALL_CHANNELS_OR_ONE]
        return max(beside.worth(s) for beside, s in product(self.beside, spreads))

    def none(self) -> float:
        """Return the same of no slow error at all."""
        return max(beside.alone for beside in self.beside)

    def drift(self) -> float:
        """Return the same of a straight line."""
        return self.worth(self.projected(np.linspace(-1, 1, len(self.cosines))))

    def walk(self) -> float:
        """Return the same of a walk."""
        wave = np.arange(1, self.cosines.shape[1])
        return self.worth(np.diag(np.concatenate([[0.0], 1 / wave])))

    def jump(self, signal: Array) -> float:
        """Return the same of a signal (n,) that is a jump, its moment one of many."""
        return self.worth(self.projected(signal)) - float(np.log(TERM.jumps))

    def beyond(self, term: Term) -> float:
        """Return by how much more the shape of a term, a jump or a walk, is worth than a drift or nothing."""
        shape = self.jump(1.0 * np.any(term.signals[term.part], axis=(1, 2))) if term.jumps else self.walk()
        return shape - max(self.drift(), self.none())

    def projected(self, signal: Array) -> Array:
        """Return the cosines (k, 1) of a signal (n,)."""
        return np.asarray(self.cosines.T @ signal[:, None] / len(signal))


ALL_CHANNELS_OR_ONE = (np.eye(3), *np.eye(3)[:, :, None])


@one_thread
def beyond_a_drift(fit: Fit, term: Term) -> float:
    """Return the nat by which a term's shape, a jump or a walk, is likelier than a drift of the same triple or none.

    `fit` has none of the three, or a drift.
    """
    return SlowErrors.of(fit, term).beyond(term)


def cosines_at(share: Array, count: int) -> Array:
    """Return the first cosines (n, count), of an RMS of 1, at shares (n,) of the time."""
    wave = np.arange(count)
    return np.asarray(np.cos(np.pi * share[:, None] * wave) * np.where(wave > 0, np.sqrt(2), 1.0))


def noise_colours(frequencies: Array, step: float) -> Iterator[Array]:
    """Yield by how much noise may be louder than white (k,), of samples every `step` s."""
    for power, share in product(powers(frequencies, step)[::2], COLOURED_POWERS):
        yield 1 + share * power


__all__ = ["SlowErrors", "beyond_a_drift"]
