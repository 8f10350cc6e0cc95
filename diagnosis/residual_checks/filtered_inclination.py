"""By how much farther off an effect makes the inclination that an ordinary orientation filter gives of an IMU.

Nobody who asks for an orientation fits the whole recording without the effects: gyroscopes that agree with each other
by a hinge would be trusted for as long as their noise allows, and a bias turns such a fit by what it adds up to in half
a minute. What a user has is a filter for each IMU: gyroscopes carry the attitude over seconds, the accelerometer holds
it to gravity. Here it is VQF's (Laidig and Seel, doi 10.1016/j.inffus.2022.10.014) without its estimate of a bias: with
Q the attitude that the gyroscope alone gives and f the specific force::

    up in sensor axes = Q^T h / |h|,    h = low-pass(Q f),  Butterworth of second order, tau / sqrt(2) = 1 / (2 pi f_c)

With y the readings, F the findings, g(S) what the model would read with the effects S at the fitted motion, the
inclinations of y - g(F) + g({}) and of y - g(F) + g({e}) are compared: everything taken out, and everything but e. Let
d be by how much they differ, q by how much the second goes with one standard deviation of e's numbers, and s by how
much the first is off the fitted motion: how well such a filter does on this recording. As in
`verdict/estimate_shift.py` the
answer is, with e in the readings,

    sqrt(s^2 + d^2 - q^2) - sqrt(s^2 + q^2)

farther off, or not at all. What is at the joint moves the segments, and a filter says what these do: it is off by
nothing more.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import butter, lfilter, lfilter_zi

from imubench import rotations
from imubench.arrays import Array
from imubench.diagnosis.config.solve import START
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis, State
from imubench.diagnosis.result import Move
from imubench.diagnosis.solve.gauss_newton import extended
from imubench.diagnosis.solve.marginals import root
from imubench.diagnosis.solve.refit import information
from imubench.jets import derivatives_by
from imubench.recording import Imu

Triples = tuple[Array, Array]  # angular rate rad/s, specific force m/s^2, each (n, 3), sensor axes


@dataclass(frozen=True)
class Inclinations:
    """What an orientation filter gives of each IMU without anything that was found at the IMUs."""

    fit: Fit
    clean: dict[str, Triples]  # by IMU: the readings, all effects at IMUs taken out
    bare: dict[str, Triples]  # by IMU: what the model would read without these effects
    up: dict[str, Array]  # by IMU: (n, 3), sensor axes
    std: Array  # (segments,) deg RMS, how far these are off the fitted motion
    covariance: Array  # (p, p) of the fit's numbers

    @classmethod
    def of(cls, fit: Fit) -> "Inclinations | None":
        """Return those of a fit; None where a segment carries no IMU."""
        recording = fit.model.recording
        carried = {recording.carrier(imu.name) for imu in recording.imus}
        if not set(fit.model.rig.tree.names) <= carried:
            return None
        plain = extended(fit, tuple(h for h in fit.model.hypotheses if not at_imu(h)))
        clean, bare, up, off = {}, {}, {}, {}
        for imu in recording.imus:
            with_all, bare[imu.name] = read(fit, imu), read(plain, imu)
            gyro, accel = (y - a + b for y, a, b in zip((imu.gyro, imu.accel), with_all, bare[imu.name], strict=True))
            clean[imu.name] = gyro, accel
            up[imu.name] = inclination(imu.time, gyro, accel)
            off[imu.name] = rms(rotations.angle_between(up[imu.name], fitted_up(plain, imu)))
        return cls(fit, clean, bare, up, by_segment(fit, off), information(fit)[0])

    def farther_off(self, left: Collection[Hypothesis]) -> Move:
        """Return by how much farther off inclinations are with some effects left in, all others at IMUs taken out."""
        shift, chance = self.shift(left), self.chance(left)
        without = self.std**2 + np.maximum(shift**2 - chance**2, 0.0)
        return Move(np.maximum(np.sqrt(without) - np.hypot(self.std, chance), 0.0), "deg RMS")

    def shift(self, left: Collection[Hypothesis]) -> Array:
        """Return by how much (segments,) deg RMS some effects move the inclinations, all others being taken out."""
        return self._apart(self.up, self._left_in(left, self.fit.state))

    def chance(self, left: Collection[Hypothesis]) -> Array:
        """Return by how much (segments,) deg RMS one standard deviation of these effects' numbers moves them."""
        model, state = self.fit.model, self.fit.state
        names = [h.key(p.name) for h in left if at_imu(h) for p in h.effect.parameters]
        if not names:
            return np.zeros_like(self.std)
        at = model.parameters.places(names)
        here, square = self._left_in(left, state), np.zeros_like(self.std)
        for step in root(self.covariance[np.ix_(at, at)]).T:
            values, used = dict(state.values), 0
            for name in names:
                width = len(values[name])
                values[name] = values[name] + step[used : used + width]
                used += width
            square += self._apart(here, self._left_in(left, replace(state, values=values))) ** 2
        return np.asarray(np.sqrt(square))

    def _left_in(self, left: Collection[Hypothesis], state: State) -> dict[str, Array]:
        """Return up by IMU (n, 3) from readings that hold some effects, with their numbers in a state."""
        kept = tuple(h for h in self.fit.model.hypotheses if h in left or not at_imu(h))
        alone = extended(replace(self.fit, state=state), kept)
        up = dict(self.up)
        for imu in self.fit.model.recording.imus:
            if any(h.at == imu.name for h in left):
                triples = zip(self.clean[imu.name], self.bare[imu.name], read(alone, imu), strict=True)
                gyro, accel = (y - bare + with_it for y, bare, with_it in triples)
                up[imu.name] = inclination(imu.time, gyro, accel)
        return up

    def _apart(self, one: Mapping[str, Array], other: Mapping[str, Array]) -> Array:
        return by_segment(self.fit, {name: rms(rotations.angle_between(up, other[name])) for name, up in one.items()})


def at_imu(h: Hypothesis) -> bool:
    """Return whether an effect sits at an IMU."""
    return h.at.startswith("imu")


def by_segment(fit: Fit, angles: Mapping[str, float]) -> Array:
    """Return angles in rad by IMU as deg by segment, the largest of a segment's IMUs."""
    carrier = fit.model.recording.carrier
    return np.array(
        [
            np.degrees(max(angle for name, angle in angles.items() if carrier(name) == segment))
            for segment in fit.model.rig.tree.names
        ]
    )


def read(fit: Fit, imu: Imu) -> Triples:
    """Return what a fit's model reads at the stamps of an IMU."""
    model, state = fit.model, fit.state
    with derivatives_by(()):
        moment = model.moment(state, imu.time, imu.name)
        reading = model.reading(imu, state, moment, model.carrier(state, moment, imu.name))
    n = len(imu.time)
    return np.broadcast_to(reading.gyro.value, (n, 3)), np.broadcast_to(reading.accel.value, (n, 3))


def fitted_up(fit: Fit, imu: Imu) -> Array:
    """Return up (n, 3) in an IMU's axes as a fit has it at the IMU's stamps."""
    model, state, n = fit.model, fit.state, len(imu.time)
    with derivatives_by(()):
        moment = model.moment(state, imu.time, imu.name)
        segment = model.carrier(state, moment, imu.name)
        mount = model.mount(imu, state, moment, segment)
    assert segment.turn is not None
    up = np.broadcast_to(segment.turn.matrix, (n, 3, 3))[:, 2]
    return np.asarray(np.einsum("nji,nj->ni", np.broadcast_to(mount.turn.matrix, (n, 3, 3)), up))


def rms(x: Array) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(x**2)))


def inclination(time: Array, gyro: Array, accel: Array) -> Array:
    """Return up (n, 3) in sensor axes by an orientation filter of one IMU.

    Args:
        time: (n,) s.
        gyro: (n, 3) rad/s.
        accel: (n, 3) m/s^2.
    """
    step = float(np.median(np.diff(time)))
    attitude = carried(gyro * np.diff(time, prepend=time[0] - step)[:, None])
    force = rotations.rotate(attitude, accel)
    cutoff = 1 / (np.sqrt(2) * np.pi * START.levelling_s)
    b, a = butter(2, 2 * cutoff * step)
    begin = force[: max(round(START.levelling_s / step), 1)].mean(axis=0)
    held, _ = lfilter(b, a, force, axis=0, zi=lfilter_zi(b, a)[:, None] * begin)
    return rotations.rotate_back(attitude, held / np.linalg.norm(held, axis=1, keepdims=True))


def carried(turns: Array) -> Array:
    """Return the attitudes (n, 4) after rotation vectors (n, 3) in sensor axes, one after the other.

    The products of all beginnings, each from two that are half as long.
    """
    q = rotations.exp(turns)
    reach = 1
    while reach < len(q):
        q = np.concatenate([q[:reach], rotations.multiply(q[:-reach], q[reach:])])
        reach *= 2
    return np.asarray(q / np.linalg.norm(q, axis=1, keepdims=True))


__all__ = ["Inclinations", "at_imu", "inclination"]
