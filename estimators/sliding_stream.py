"""The joint centre from one IMU on soft tissue, on a stream: the last 8 s fitted again and again, and carried on.

A fit of a window starts from that of the window before, half a second earlier. With q the numbers that bend (a line's
frequency; of a spring m, z, k, l), x those that act linearly (r0, sizes, start, gravity), J_q, J_x the derivatives of
the whitened equations and e what is left of them, one step of Gauss and Newton,

    (J^T J + p / prior) (dq, dx) = J^T e - p x / prior,    p the power of the noise,

takes both to where they belong, if dq is small in its own standard deviations; else the equations are made anew. Where
the first sample is another one, the start and the error of gravity are first turned into its axes.

Whether another kind of r, or other lines, have more evidence is asked of one candidate at a time by a fit from scratch,
of each as often as it may matter (`_wait`), the one that waited longest first. A candidate is given up as soon as
several more steps as good as the last would not do.
"""

import math
from functools import cache

import numpy as np
from numpy.typing import ArrayLike
from threadpoolctl import ThreadpoolController

from imubench.arrays import Array, frozen
from imubench.errors import InputError
from imubench.estimators import sliding_search, sliding_spring
from imubench.estimators.sliding_lines import Lines
from imubench.estimators.sliding_rows import Rows
from imubench.estimators.sliding_search import EXPLAINED
from imubench.estimators.sliding_splines import SPACINGS
from imubench.estimators.sliding_spring import Spring

STREAM = "sliding-stream"
KINDS = ("felt", "unfelt", "spring")
WINDOW = 8.0  # s, of the last samples that a stream fits
FIRST = 2.0  # s, before a stream answers
EVERY = 0.5  # s, between two fits of the kind that answers
UNSETTLED, SETTLED = 0.5, 6.0  # s, before a kind is asked again while little is sure, and later
FAR = 30.0  # nat, by which a kind may be behind that is not asked again until the window is another
UNEXPLAINED = 2.0  # times the noise's power in the residuals: no kind of r is right then, nor its covariance
WORSE = 1.3  # times the residual power when a kind was last asked; over a window of 600 rows its std is 0.06
CLEARLY = 1.0  # nat, of more evidence for the same kind to count as another answer
LEAST_NOISE = 1e-6  # rad/s or m/s^2: a record without noise is fitted as if it had this much
WIDE = 8  # fits, between two that try all densities of the smoothed rates; else the neighbours, as windows are alike
DENSITIES = range(len(SPACINGS))
BACK = 4  # samples, over which a rate's derivative is taken to turn r by a spring's softness

Fit = Lines | Spring


@cache
def _controller() -> ThreadpoolController:
    return ThreadpoolController()


class Window:
    """The samples of the last seconds, in an array that is moved up when full, and grows with their number."""

    def __init__(self, seconds: float):
        self.seconds = seconds
        self._held = np.empty((256, 10))
        self._first = self._end = 0
        self.dropped = 0  # samples that have left so far

    def __len__(self) -> int:
        return self._end - self._first

    @property
    def samples(self) -> Array:
        """Return the samples (n, 10): time in s, w in rad/s, f and a in m/s^2."""
        return self._held[self._first : self._end]

    def add(self, time: float, w: ArrayLike, f: ArrayLike, a: ArrayLike) -> Array:
        """Add a sample and drop those more than `seconds` before; return its row (10,)."""
        if self._end == len(self._held):
            samples = self.samples
            if 2 * len(samples) > len(self._held):
                self._held = np.empty((2 * len(self._held), 10))
            self._held[: len(samples)] = samples
            self._first, self._end = 0, len(samples)
        row = self._held[self._end]
        row[0] = time
        for at, x, name in ((1, w, "gyro"), (4, f, "accel"), (7, a, "a")):
            x = np.asarray(x, dtype=float)
            if x.shape != (3,):
                frozen(x, (3,), name)
            row[at : at + 3] = x
        if not math.isfinite(row.sum()):
            for x, name in ((w, "gyro"), (f, "accel"), (a, "a")):
                frozen(x, (3,), name)
        self._end += 1
        while time - self._held[self._first, 0] > self.seconds:
            self._first += 1
            self.dropped += 1
        return row


class SlidingStream:
    """One sample in, one r out.

    Oscillations are carried on as they are. A spring's d is what the specific force f makes of it,
    m^2 d + 2 z m d' = f, and theta goes by the last rates.
    """

    def __init__(
        self,
        gyro_noise_std: float = 0.0017,
        accel_noise_std: float = 0.02,
        kinds: tuple[str, ...] = KINDS,
        window: float = WINDOW,
    ):
        self.noise = max(gyro_noise_std, LEAST_NOISE), max(accel_noise_std, LEAST_NOISE)
        self.kinds, self.window = kinds, window
        self.fit: Fit | None = None
        self.kind = ""  # which of them the fit is
        self._from = 0  # samples that had left when it was made
        self._samples = Window(window)
        self._time, self._next = 0.0, FIRST
        self._spring: sliding_spring.Carried | None = None
        self._densities = DENSITIES  # of the smoothed rates, to be tried in the next window
        self._due: dict[str, float] = {}  # s, when each kind is to be asked again
        self._asked: dict[str, float] = {}  # s, when each was asked last
        self._fits, self._level = 0, np.inf  # fits so far; the residual power when a kind was last asked

    @property
    def covariance(self) -> Array:
        """The covariance of the last r (3, 3) in m^2; that of a spring is of its last fit."""
        if self.fit is None:
            return np.full((3, 3), np.nan)
        return self.fit.last_covariance if isinstance(self.fit, Spring) else self.fit.covariance_at(self._time)

    def update(self, gyro: ArrayLike, accel: ArrayLike, acceleration: ArrayLike, dt: float) -> Array:
        """Return r (3,) in m after w (3,) in rad/s, f and, gravity taken out, a (3,) in m/s^2; NaN before `FIRST`.

        `dt` s since the sample before; that of the first is not used. Raises `InputError` for samples that are not
        finite and for a step that is not; the stream is then as it was.
        """
        time = self._time
        if len(self._samples):
            if not 0 < dt < math.inf:
                raise InputError(f"{STREAM}: expected a time step > 0 s, got {dt!r}")
            time += dt
        row = self._samples.add(time, gyro, accel, acceleration)
        self._time = time
        if time >= self._next - 1e-9:
            with _controller().limit(limits=1, user_api="blas"):
                self._refit()
            self._next = time + EVERY
        elif self._spring is not None:
            self._spring.step(row[4:7], dt)
        return self._answer()

    def _refit(self) -> None:
        samples = self._samples.samples.copy()
        time, w, f, a = samples[:, 0], samples[:, 1:4], samples[:, 4:7], samples[:, 7:]
        rows = Rows(time, w, f, f - a, *self.noise, self._densities)
        if self.fit is None:
            fit = self._first(rows)
        else:
            fit = self._followed(self.fit, rows)
            kind = self._candidate(fit.noise)
            if kind is not None:
                fit = self._asked_for(kind, rows, fit)
        self._fits += 1
        density = rows.smoothed.density
        self._densities = DENSITIES if self._fits % WIDE == 0 else range(density - 1, density + 2)
        self.fit, self._from = fit, self._samples.dropped
        self._spring = sliding_spring.Carried(fit) if isinstance(fit, Spring) else None

    def _first(self, rows: Rows) -> Fit:
        """Return the fit of the largest evidence of all kinds."""
        found: dict[str, Fit] = {}
        for kind in self.kinds:
            best = max((fit.evidence for fit in found.values()), default=-np.inf)
            found[kind] = fitted(rows, kind, best)
        self.kind = max(found, key=lambda kind: found[kind].evidence)
        chosen = found[self.kind]
        for kind, fit in found.items():
            self._wait(kind, chosen.evidence - fit.evidence, chosen.noise)
        return chosen

    def _followed(self, last: Fit, rows: Rows) -> Fit:
        if isinstance(last, Spring):
            return sliding_spring.followed(rows, last, self._samples.dropped - self._from)
        return sliding_search.followed(rows, last)

    def _candidate(self, noise: float) -> str | None:
        """Return the kind that is to be asked now, if any: of those that are due, the one that waits the longest."""
        if noise > WORSE * self._level:
            self._due = dict.fromkeys(self.kinds, self._time)
        due = [kind for kind in reversed(self.kinds) if self._due[kind] <= self._time + 1e-9]
        return min(due, key=lambda kind: self._asked[kind], default=None)

    def _asked_for(self, kind: str, rows: Rows, now: Fit) -> Fit:
        """Return the fit of one kind from scratch if it has more evidence, or else the one that there is now."""
        fit = fitted(rows, kind, now.evidence)
        ahead = now.evidence - fit.evidence
        if ahead < 0:
            if kind != self.kind or ahead < -CLEARLY:
                self._due = dict.fromkeys(self.kinds, self._time)
            self.kind, now = kind, fit
        self._wait(kind, ahead, now.noise)
        return now

    def _wait(self, kind: str, ahead: float, noise: float) -> None:
        """Say when a kind is asked again that is behind by `ahead` nat; `noise` is the residual power of what answers.

        While nothing explains the samples, or the window still grows and with it what it tells: soon.
        """
        if kind == self.kind == "spring" and noise < EXPLAINED:
            wait = self.window  # of the one spring that explains them, nothing else is to be found from scratch
        elif noise > UNEXPLAINED or (ahead < FAR and self._samples.dropped == 0):
            wait = UNSETTLED
        else:
            wait = SETTLED if ahead < FAR else self.window
        self._due[kind], self._asked[kind], self._level = self._time + wait, self._time, noise

    def _answer(self) -> Array:
        if self.fit is None:
            return np.full(3, np.nan)
        if not isinstance(self.fit, Spring):
            return self.fit.at(self._time)
        assert self._spring is not None
        before, now = self._samples.samples[-1 - BACK], self._samples.samples[-1]
        return self._spring.r((now[1:4] - before[1:4]) / (now[0] - before[0]))


def fitted(rows: Rows, kind: str, rival: float = -np.inf) -> Fit:
    """Return the fit of one kind, from scratch; one that cannot have the evidence of a rival, in nat, may be left."""
    if kind == "spring":
        return sliding_spring.fit(rows, rival=rival)
    return sliding_search.fit(rows, kind == "felt", rival=rival)
