"""A recording as it would have been without what a diagnosis found in it, for any estimator to take.

A sample y with stamp s, the world's time t at that stamp, h the model's reading in sensor axes, E the effects found::

    y_corrected(t) = y(s) - (h(t; E) - h(t; those of E that stay))

What no law explains stays in, noise included. See docs/correct-with.md.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from imubench import rotations
from imubench.arrays import Array
from imubench.band import banded
from imubench.correction.explained import StartedEffect, explained_fit, off_its_law, started_effects
from imubench.diagnosis.config.shared import CONFIDENCE
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.bspline import Moment
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import State
from imubench.diagnosis.result import UNKNOWN, Diagnosis, Finding
from imubench.diagnosis.samples.screening import check_samples, with_sample_noise
from imubench.diagnosis.sensor_errors.baseline import whole
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.initialize import model_of
from imubench.effects import EFFECTS, traits_of
from imubench.effects.traits import Correction
from imubench.errors import InputError
from imubench.jets import Jet
from imubench.progress import Step, silent
from imubench.recording import Imu, Recording

Place = tuple[str, str]
"""An effect and where it is."""


@dataclass(frozen=True)
class Done:
    """What was done about one finding, in words."""

    effect: str
    at: str
    what: str


@dataclass(frozen=True)
class Corrected:
    """A recording without what was found in it, and what was done about each finding."""

    recording: Recording
    done: tuple[Done, ...]


@dataclass(frozen=True)
class Removal:
    """What takes findings out of a recording: its motion, fitted with all of them at their numbers."""

    recording: Recording
    diagnosis: Diagnosis
    found: tuple[Finding, ...]  # those that are sure and have a law
    laws: tuple[tuple[StartedEffect, ...], ...]  # of each finding that is an effect of a fit, its settings
    fit: Fit | None  # None: nothing of it shapes the readings

    def without(self, left_in: Collection[Place] = ()) -> Corrected:
        """Return the recording without the findings, less some that are `left_in`, by effect and place.

        Raises `InputError` where fewer than two samples of an IMU would be left.
        """
        recording, every = self.recording, whole(self.diagnosis)
        found = tuple(f for f in self.found if (f.effect, f.at) not in left_in)
        laws = [t for t, *_ in self.laws if (t.hypothesis.effect.name, t.hypothesis.at) not in left_in]
        done = tuple(Done(f.effect, f.at, words(f)) for f in every if (f.effect, f.at) not in left_in)
        kept = {at for effect, at in left_in if traits_of(effect).on_springs}
        loose = springs_that_leave_more(self.diagnosis) - kept
        out, keep = recording, {i.name: np.ones(i.time.size, dtype=bool) for i in recording.imus}
        spoiled = [f.at for f in found if (fault := traits_of(f.effect).fault) is not None and fault.measures_nothing]
        masks = check_samples(recording).masks if spoiled else {}
        for name, part in ((name, part) for name in spoiled for part in ("gyro", "accel")):
            keep[name] &= masks.get(f"{name}.{part}", True)
        if self.fit is not None:
            out = taken_out(recording, self.fit, loose, left_in)
            for t in (t for t in laws if t.hypothesis.at in keep):
                keep[t.hypothesis.at] &= ~off_its_law(t, self.fit.model)
        out = redeclared(with_sample_noise(out, found), laws)
        out = replace(out, imus=tuple(some(i, keep[i.name]) for i in out.imus))
        if (hz := lowest(self.diagnosis, loose)) is not None:
            out = banded(out, hz)
            done += tuple(
                Done(UNKNOWN, imu.name, f"read below {hz:.3g} Hz alone: above, springs leave it") for imu in out.imus
            )
        return Corrected(out, done)


def corrected(recording: Recording, diagnosis: Diagnosis, step: Step = silent) -> Corrected:
    """Return a recording with the findings of its diagnosis taken out; what cannot be is left, and said so.

    Raises `InputError` as `removal` does.
    """
    return removal(recording, diagnosis, step).without()


def removal(recording: Recording, diagnosis: Diagnosis, step: Step = silent) -> Removal:
    """Return what takes the findings of its diagnosis out of a recording.

    Raises `InputError` for the diagnosis of another recording, one that names what this recording cannot have, or one
    whose model is doubted: what it takes out may not be there.
    """
    for key, mine, its in (("name", recording.name, diagnosis.recording), ("rig", recording.rig, diagnosis.rig)):
        if mine != its:
            raise InputError(f"diagnosis: expected that of a recording of {key} '{mine}', got of '{its}'")
    if diagnosis.doubts:
        first = diagnosis.doubts[0]
        raise InputError(
            f"diagnosis: expected a model that can be trusted, got one that is doubted: {first.of}: {first.why}"
        )
    found = tuple(f for f in whole(diagnosis) if f.named and f.confidence >= CONFIDENCE.counts)
    laws = tuple(settings for f in found if (settings := started_effects(f, recording)))
    fit = None
    if not all(t.hypothesis.effect.correction.stays for t, *_ in laws):
        try:
            with step("fit the motion with what was found"):
                fit = explained_fit(recording, laws)
        except NotPositiveDefiniteError:
            names = ", ".join(t.hypothesis.name for t, *_ in laws)
            raise InputError(
                f"diagnosis: expected numbers with which a motion fits, got none that do: {names}"
            ) from None
    return Removal(recording, diagnosis, found, laws, fit)


def springs_that_leave_more(diagnosis: Diagnosis) -> set[str]:
    """Return the sensors on springs that do what no straight springs do: something without a name is there too."""
    sure = [f for f in diagnosis.findings if f.confidence >= CONFIDENCE.counts]
    sprung = {f.at for f in sure if traits_of(f.effect).on_springs}
    return sprung & {f.at for f in sure if not f.named}


def lowest(diagnosis: Diagnosis, places: Collection[str]) -> float | None:
    """Return the frequency in Hz from which on some places differ from the declared model; None where none does.

    From there on the readings of springs that leave more are neither the segment's motion nor noise; below it, what
    springs do is small, and as their law says. What begins at 0 Hz leaves no such band.
    """
    every = [low for w in diagnosis.where if w.at in places for low, _ in w.bands_hz]
    return min(every) if every and min(every) > 0 else None


def taken_out(
    recording: Recording, fit: Fit, loose: Collection[str] = (), left_in: Collection[Place] = ()
) -> Recording:
    """Return a recording whose readings are without the effects of a fit that do not stay; stamps as they were.

    Neither taken out is what is `left_in`, by effect and place.

    A sensor on springs is put where it is unloaded; one that is `loose` (its springs' law is not all there is) where it
    is in the mean.
    """
    model, state = fit.model, fit.state
    stays = [h for h in model.hypotheses if h.effect.correction.stays or (h.effect.name, h.at) in left_in]
    without = replace(model, hypotheses=tuple(stays))
    imus, encoders = [], []
    for imu in recording.imus:
        moment = model.moment(state, imu.time, imu.name)
        gyro, accel = readings(model, imu, state, moment)
        placed = at_rest_in_the_mean(fit, imu) if imu.name in loose else state
        plain_gyro, plain_accel = readings(without, imu, placed, moment)
        gyro, accel = imu.gyro - (gyro - plain_gyro), imu.accel - (accel - plain_accel)
        imus.append(replace(imu, gyro=gyro, accel=accel, gyro_range=None, accel_range=None))  # those were the sensor's
    for encoder in recording.encoders:
        moment = model.moment(state, encoder.time, "encoder")
        excess = model.joint_angle(state, moment).value - without.joint_angle(state, moment).value
        encoders.append(replace(encoder, angle=encoder.angle - excess[:, 0]))
    return replace(recording, imus=tuple(imus), encoders=tuple(encoders))


def at_rest_in_the_mean(fit: Fit, imu: Imu) -> State:
    """Return the state with an IMU's mount where its springs hold it in the mean.

    Unloaded, it would be where nobody has seen it: how far springs sag is known as badly as their law, while the mean
    of what they do is where the readings were taken. With R_k, p_k the pose with the springs at the samples
    (sensor -> segment), R, p that without, D the rotation nearest to the mean of R' R_k (in the sense of Frobenius)::

        R exp(rotation) -> R exp(rotation) D,     p -> p + mean(p_k - p)
    """
    springs = [h for h in fit.model.hypotheses if h.at == imu.name and h.effect.on_springs]
    moment = fit.model.moment(fit.state, imu.time, imu.name)
    segment = fit.model.carrier(fit.state, moment, imu.name)
    links = [
        replace(fit.model, hypotheses=tuple(chosen)).mount(imu, fit.state, moment, segment) for chosen in (springs, ())
    ]
    (turned, shifted), (turn, place) = ((link.turn.matrix, link.offset.value) for link in links)
    left, _, right = np.linalg.svd(np.mean(np.swapaxes(turn, 1, 2) @ turned, axis=0))
    mean = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    rotation, translation = f"{imu.name}.rotation", f"{imu.name}.translation"
    values = dict(fit.state.values)
    values[rotation] = rotations.log(rotations.from_matrix(rotations.to_matrix(rotations.exp(values[rotation])) @ mean))
    values[translation] = values[translation] + np.mean(shifted - place, axis=0)
    return replace(fit.state, values=values)


def readings(model: Model, imu: Imu, state: State, moment: Moment) -> tuple[Array, Array]:
    """Return what a model's IMU reports, rad/s and m/s^2, (n or 1, 3) each."""
    segment = model.carrier(state, moment, imu.name)
    reading = model.reading(imu, state, moment, segment)
    return reading.gyro.value, reading.accel.value


def redeclared(recording: Recording, effects: Sequence[StartedEffect]) -> Recording:
    """Return a recording with the stamps, mounts and gravity that effects say are the right ones."""
    start, imus, gravity = model_of(recording).start, [], Jet(np.array([[0.0, 0.0, -recording.gravity]]))
    for t in (t for t in effects if t.hypothesis.at == "world"):
        gravity = t.hypothesis.effect.gravity(gravity, t.values)
    for imu in recording.imus:
        late, position, turn = Jet((imu.time - start)[:, None]), imu.mount_position, imu.mount_quaternion
        time = late
        for t in (t for t in effects if t.hypothesis.at == imu.name):
            time = t.hypothesis.effect.clock(time, t.values)
            if t.hypothesis.effect.misplaces:
                position = position + t.values["translation"].value[0]
                turn = rotations.multiply(turn, rotations.exp(t.values["rotation"].value[0]))
        stamps = imu.time - (late.value - time.value)[:, 0]  # where nothing is late, as they were to the last digit
        imus.append(replace(imu, time=stamps, mount_position=position, mount_quaternion=turn))
    return replace(recording, imus=tuple(imus), gravity=float(np.linalg.norm(gravity.value)))


def some(imu: Imu, keep: NDArray[np.bool_]) -> Imu:
    """Return an IMU with some of its samples; `InputError` where fewer than two would be left."""
    if keep.sum() < 2:
        raise InputError(f"{imu.name}: expected two samples or more that the diagnosis leaves in, got {keep.sum()}")
    return imu if keep.all() else replace(imu, time=imu.time[keep], gyro=imu.gyro[keep], accel=imu.accel[keep])


def words(f: Finding) -> str:
    """Return in words what is done about a finding."""
    if not f.named:
        return "left in: no law to correct it by"
    if f.confidence < CONFIDENCE.counts:
        return f"left in: its confidence of {f.confidence:.2f} is under {CONFIDENCE.counts:g}"
    law = EFFECTS.get(f.effect)
    return (Correction.TAKEN_OUT if law is None else law.correction).value
