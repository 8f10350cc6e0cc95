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
from imubench.diagnosis.problem.hypothesis import State
from imubench.diagnosis.result import UNKNOWN, Diagnosis, Finding
from imubench.diagnosis.samples.screening import check_samples, with_sample_noise
from imubench.diagnosis.sensor_errors.baseline import whole
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.initialize import model_of
from imubench.diagnosis.solve.levenberg_marquardt import Fit
from imubench.effects import VARIANTS
from imubench.effects.soft_mounts import EFFECTS as SPRINGS
from imubench.effects.soft_mounts import Sprung
from imubench.errors import InputError
from imubench.jets import Jet
from imubench.progress import Step, silent
from imubench.recording import Imu, Recording

SHAPED_THE_MOTION = "nothing to correct: it shaped the motion, which the readings show as it was"
MOTION_WITHOUT_LAW = (
    "left in: a motion without a law takes in what the mounts may explain, and would hand the fit's to an estimator"
)
NOISE = "left in: what it took cannot be given back; the declared noise is raised by it"
CLOCK_CORRECTED = "the stamps are moved to the common clock"
CORRECTED_DECLARATION = {
    "mount_pose": "the declared mount is moved to where the sensor is",
    "gravity": "the declared one is changed",
}
TORQUES = ("inertia", "viscous_friction", "dry_friction", "air_drag", "joint_spring", "end_stop")
STAYING = (
    CORRECTED_DECLARATION
    | dict.fromkeys(("time_offset", "clock_skew"), CLOCK_CORRECTED)
    | dict.fromkeys(TORQUES, SHAPED_THE_MOTION)
    | {e.name: MOTION_WITHOUT_LAW for e in VARIANTS if e.free}
)
"""What is done about effects that are in the readings of a corrected recording as well."""
SAMPLES = dict.fromkeys(("quantisation", "gyro_noise", "accel_noise"), NOISE) | {
    "saturation": "clipped samples are left out",
    "dropouts": "repeated samples are left out",
    "impacts": "knocked samples are left out",
}
SAMPLE_EFFECTS = ("saturation", "dropouts", "impacts")


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


def corrected(recording: Recording, diagnosis: Diagnosis, step: Step = silent) -> Corrected:
    """Return a recording with the findings of its diagnosis taken out; what cannot be is left, and said so.

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
    every = whole(diagnosis)
    found = tuple(f for f in every if f.named and f.confidence >= CONFIDENCE.counts)
    laws = [settings for f in found if (settings := started_effects(f, recording))]
    done = tuple(Done(f.effect, f.at, words(f)) for f in every)
    loose = springs_that_leave_more(diagnosis)
    out, keep = recording, {i.name: np.ones(i.time.size, dtype=bool) for i in recording.imus}
    masks = check_samples(recording).masks if any(f.effect in SAMPLE_EFFECTS for f in found) else {}
    for name, part in ((f.at, part) for f in found if f.effect in SAMPLE_EFFECTS for part in ("gyro", "accel")):
        keep[name] &= masks.get(f"{name}.{part}", True)
    if any(t.hypothesis.effect.name not in STAYING for t, *_ in laws):
        try:
            with step("fit the motion with what was found"):
                fit = explained_fit(recording, laws)
        except NotPositiveDefiniteError:
            names = ", ".join(t.hypothesis.name for t, *_ in laws)
            raise InputError(
                f"diagnosis: expected numbers with which a motion fits, got none that do: {names}"
            ) from None
        out = taken_out(recording, fit, loose)
        for t, *_ in laws:
            if t.hypothesis.at in keep:
                keep[t.hypothesis.at] &= ~off_its_law(t, fit.model)
    out = redeclared(with_sample_noise(out, found), [t for t, *_ in laws])
    out = replace(out, imus=tuple(some(i, keep[i.name]) for i in out.imus))
    if (hz := lowest(diagnosis, loose)) is not None:
        out = banded(out, hz)
        done += tuple(
            Done(UNKNOWN, imu.name, f"read below {hz:.3g} Hz alone: above, springs leave it") for imu in out.imus
        )
    return Corrected(out, done)


def springs_that_leave_more(diagnosis: Diagnosis) -> set[str]:
    """Return the sensors on springs that do what no straight springs do: something without a name is there too."""
    sure = [f for f in diagnosis.findings if f.confidence >= CONFIDENCE.counts]
    sprung = {f.at for f in sure if f.effect in {e.name for e in SPRINGS}}
    return sprung & {f.at for f in sure if not f.named}


def lowest(diagnosis: Diagnosis, places: Collection[str]) -> float | None:
    """Return the frequency in Hz from which on some places differ from the declared model; None where none does.

    From there on the readings of springs that leave more are neither the segment's motion nor noise; below it, what
    springs do is small, and as their law says.
    """
    return min((low for w in diagnosis.where if w.at in places for low, _ in w.bands_hz), default=None)


def taken_out(recording: Recording, fit: Fit, loose: Collection[str] = ()) -> Recording:
    """Return a recording whose readings are without the effects of a fit that do not stay; stamps as they were.

    A sensor on springs is put where it is unloaded; one that is `loose` (its springs' law is not all there is) where it
    is in the mean.
    """
    model, state = fit.model, fit.state
    without = replace(model, hypotheses=tuple(h for h in model.hypotheses if h.effect.name in STAYING))
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
    springs = [h for h in fit.model.hypotheses if h.at == imu.name and isinstance(h.effect, Sprung)]
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
            if t.hypothesis.effect.name == "mount_pose":
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
    return STAYING.get(f.effect) or SAMPLES.get(f.effect) or "taken out of the readings"
