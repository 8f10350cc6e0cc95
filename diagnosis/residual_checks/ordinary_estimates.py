"""By how much farther off an effect makes what ordinary estimates say of single IMUs: inclinations, and mounts.

Nobody who asks for an orientation fits the whole recording without the effects: gyroscopes that agree with each other
by a hinge would be trusted for as long as their noise allows, and a bias turns such a fit by what it adds up to in half
a minute; beside a pose whose errors last it turns the mount with it. What a user has is a filter for each IMU, and the
rotation that matches rates.

In the filter gyroscopes carry the attitude over seconds, the accelerometer holds it to gravity. It is VQF's (Laidig and
Seel, doi 10.1016/j.inffus.2022.10.014) without its estimate of a bias: with Q the attitude that the gyroscope alone
gives and f the specific force::

    up in sensor axes = Q^T h / |h|,    h = low-pass(Q f),  Butterworth of second order, tau / sqrt(2) = 1 / (2 pi f_c)

Where a segment's orientation is measured, a mount is turned by t so that rates y match those u that the model would
read, which are y = u + u x t for a small t, with the declared mount at their side::

    t = argmin  sum |y - u - u x t|^2 / std_gyro^2 + |t|^2 / std_mount^2

With y the readings, F the findings, g(S) what the model would read with the effects S at the fitted motion, the
estimates from y - g(F) + g({}) and from y - g(F) + g({e}) are compared: everything taken out, and everything but e. Let
d be by how much they differ, q by how much the second goes with one standard deviation of e's numbers, and s by how
much the first is off the fit: how well such an estimate does on this recording. As in `verdict/estimate_shift.py` the
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
from imubench.arrays import Array, rms
from imubench.diagnosis.config.solve import START
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis, State
from imubench.diagnosis.result import Move
from imubench.diagnosis.solve.gauss_newton import extended
from imubench.diagnosis.solve.marginals import root
from imubench.diagnosis.solve.refit import information
from imubench.jets import derivatives_by, skew
from imubench.recording import Imu

Triples = tuple[Array, Array]  # angular rate rad/s, specific force m/s^2, each (n, 3), sensor axes


ORIENTATION, MOUNT = "orientation", "mount_rotation"  # as moves name them


@dataclass(frozen=True)
class Answers:
    """What ordinary estimates say, by IMU."""

    up: dict[str, Array]  # (n, 3), sensor axes
    turned: dict[str, Array]  # (3,) rad, the mount against the fit's, where the segment's orientation is measured


@dataclass(frozen=True)
class OrdinaryEstimates:
    """What ordinary estimates say of a fit's recording without anything that was found at its IMUs."""

    fit: Fit
    clean: dict[str, Triples]  # by IMU: the readings, all effects at IMUs taken out
    bare: dict[str, Triples]  # by IMU: what the model would read without these effects
    answers: Answers  # from the clean readings
    std: dict[str, Array]  # deg RMS, how far these are off the fit: orientations by segment, mounts by IMU
    covariance: Array  # (p, p) of the fit's numbers

    @classmethod
    def of(cls, fit: Fit) -> "OrdinaryEstimates | None":
        """Return those of a fit; None where a segment carries no IMU, or the base stands still, as declared."""
        recording = fit.model.recording
        carried = {recording.carrier(imu.name) for imu in recording.imus}
        if recording.clamped or not set(fit.model.rig.tree.names) <= carried:
            return None
        plain = extended(fit, tuple(h for h in fit.model.hypotheses if not at_imu(h)))
        clean, bare, fitted = {}, {}, Answers({}, {})
        for imu in recording.imus:
            with_all, bare[imu.name] = read(fit, imu), read(plain, imu)
            gyro, accel = (y - a + b for y, a, b in zip((imu.gyro, imu.accel), with_all, bare[imu.name], strict=True))
            clean[imu.name] = gyro, accel
            fitted.up[imu.name] = fitted_up(plain, imu)
            if measured(fit, imu):
                fitted.turned[imu.name] = np.zeros(3)
        said = answers_of(fit, clean, bare)
        return cls(fit, clean, bare, said, apart(fit, said, fitted), information(fit)[0])

    def farther_off(self, left: Collection[Hypothesis]) -> dict[str, Move]:
        """Return by how much farther off estimates are with some effects left in, all others at IMUs taken out."""
        shift, chance = self.shift(left), self.chance(left)
        out = {}
        for name, std in self.std.items():
            without = std**2 + np.maximum(shift[name] ** 2 - chance[name] ** 2, 0.0)
            worse = np.maximum(np.sqrt(without) - np.hypot(std, chance[name]), 0.0)
            out[name] = Move(worse, "deg RMS" if name == ORIENTATION else "deg")
        return out

    def shift(self, left: Collection[Hypothesis]) -> dict[str, Array]:
        """Return by how much some effects move the estimates in deg, all others being taken out."""
        return apart(self.fit, self.answers, self._left_in(left, self.fit.state))

    def chance(self, left: Collection[Hypothesis]) -> dict[str, Array]:
        """Return by how much one standard deviation of these effects' numbers moves them in deg."""
        model, state = self.fit.model, self.fit.state
        square = {name: np.zeros_like(std) for name, std in self.std.items()}
        names = [h.key(p.name) for h in left if at_imu(h) for p in h.effect.parameters]
        if not names:
            return square
        at = model.parameters.places(names)
        here = self._left_in(left, state)
        for step in root(self.covariance[np.ix_(at, at)]).T:
            values, used = dict(state.values), 0
            for name in names:
                width = len(values[name])
                values[name] = values[name] + step[used : used + width]
                used += width
            off = apart(self.fit, here, self._left_in(left, replace(state, values=values)))
            square = {name: square[name] + x**2 for name, x in off.items()}
        return {name: np.sqrt(x) for name, x in square.items()}

    def _left_in(self, left: Collection[Hypothesis], state: State) -> Answers:
        """Return the estimates from readings that hold some effects, with their numbers in a state."""
        kept = tuple(h for h in self.fit.model.hypotheses if h in left or not at_imu(h))
        alone = extended(replace(self.fit, state=state), kept)
        readings = {}
        for imu in self.fit.model.recording.imus:
            if any(h.at == imu.name for h in left):
                triples = zip(self.clean[imu.name], self.bare[imu.name], read(alone, imu), strict=True)
                gyro, accel = (y - bare + with_it for y, bare, with_it in triples)
                readings[imu.name] = gyro, accel
        some = answers_of(self.fit, readings, self.bare)
        return Answers(self.answers.up | some.up, self.answers.turned | some.turned)


def answers_of(fit: Fit, readings: Mapping[str, Triples], bare: Mapping[str, Triples]) -> Answers:
    """Return the estimates from readings of some IMUs; `bare` is what the model would read."""
    imus = [imu for imu in fit.model.recording.imus if imu.name in readings]
    up = {imu.name: inclination(imu.time, *readings[imu.name]) for imu in imus}
    turned = {i.name: matched(fit, i, readings[i.name][0], bare[i.name][0]) for i in imus if measured(fit, i)}
    return Answers(up, turned)


def apart(fit: Fit, one: Answers, other: Answers) -> dict[str, Array]:
    """Return by how much estimates differ in deg: orientations (segments,), mounts (imus,) where known."""
    angles = {name: rms(rotations.angle_between(up, other.up[name])) for name, up in one.up.items()}
    out = {ORIENTATION: by_segment(fit, angles)}
    if len(one.turned) == len(one.up):
        turns = [np.linalg.norm(turn - other.turned[name]) for name, turn in one.turned.items()]
        out[MOUNT] = np.degrees(turns)
    return out


def measured(fit: Fit, imu: Imu) -> bool:
    """Return whether the orientation of an IMU's segment is measured."""
    recording = fit.model.recording
    return any(p.quaternion is not None and p.segment == recording.carrier(imu.name) for p in recording.poses)


def matched(fit: Fit, imu: Imu, gyro: Array, model: Array) -> Array:
    """Return the turn (3,) rad in sensor axes of a mount by which rates (n, 3) match those that the model reads."""
    cross = skew(model)
    prior = (fit.noise[f"{imu.name}.gyro"] / fit.model.priors[f"{imu.name}.rotation"].std) ** 2
    information = np.einsum("nki,nkj->ij", cross, cross) + np.diag(prior)
    return np.asarray(np.linalg.solve(information, np.einsum("nki,nk->i", cross, gyro - model)))


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


__all__ = ["OrdinaryEstimates", "at_imu", "inclination"]
