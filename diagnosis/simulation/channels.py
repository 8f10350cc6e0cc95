"""What every sensor of a recording would read of a simulation, and how far that is from what it did read."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.correction.sensor_chain import angle_read, at_place, read_by
from imubench.diagnosis.config.correction import REPLAY
from imubench.diagnosis.evidence import Posed, Swing
from imubench.diagnosis.problem.encoder_calibration import read
from imubench.diagnosis.residual_checks.fit_summary import CHANNELS_WITH_UNIT
from imubench.diagnosis.simulation.sim_model import SimModel
from imubench.diagnosis.simulation.splice import played
from imubench.jets import Jet
from imubench.recording import Recording, span_of
from imubench.sim.imu_sampling import interpolate
from imubench.truth import Truth


@dataclass(frozen=True)
class Channel:
    """One measured channel."""

    name: str  # imu2.gyr_y, encoder.hinge, pose1.x
    group: str  # of the fit: imu2.gyro, encoder.angle, pose1.position
    unit: str
    time: Array  # (n,) s
    measured: Array  # (n,)


@dataclass(frozen=True)
class Simulated:
    """What is seen of one simulation."""

    channels: Mapping[str, Array]  # (n,) by channel, what every sensor reads at its stamps
    posed: Posed


def channels(recording: Recording) -> tuple[Channel, ...]:
    """Return every measured channel; samples that were not seen are not in it.

    A measured orientation is its own zero: what is simulated is a rotation vector from there, segment axes.
    """
    out = []
    for imu in recording.imus:
        for part, values in (("gyro", imu.gyro), ("accel", imu.accel)):
            names, unit = CHANNELS_WITH_UNIT[part]
            for i, name in enumerate(names):
                out.append(Channel(f"{imu.name}.{name}", f"{imu.name}.{part}", unit, imu.time, values[:, i]))
    for encoder in recording.encoders:
        out.append(Channel(f"encoder.{encoder.joint}", "encoder.angle", "rad", encoder.time, encoder.angle))
    for i, pose in enumerate(recording.poses, 1):
        for part, measured in (("position", pose.position), ("rotation", pose.quaternion)):
            if measured is None or not (seen := np.isfinite(measured).all(axis=1)).any():
                continue
            names, unit = CHANNELS_WITH_UNIT[part]
            for k, name in enumerate(names):
                values = measured[seen, k] if part == "position" else np.zeros(int(seen.sum()))
                out.append(Channel(f"pose{i}.{name}", f"pose{i}.{part}", unit, pose.time[seen], values))
    return tuple(out)


def judged_channels(recording: Recording, noise: Mapping[str, float]) -> tuple[Channel, ...]:
    """Return the measured channels of the groups that have a `noise`: a sensor that clips throughout has none."""
    return tuple(c for c in channels(recording) if c.group in noise)


def quickest(recording: Recording) -> float:
    """Return the rate in Hz of the sensor with most samples a second."""
    rates = [i.rate for i in recording.imus]
    clocks = [e.time for e in recording.encoders] + [p.time for p in recording.poses]
    rates += [1 / float(np.median(np.diff(time))) for time in clocks]
    return max(rates)


def dense_rate(recording: Recording) -> float:
    """Return how many rows a second of a simulation there are, whole ones to each sample of the quickest sensor."""
    rate = quickest(recording)
    return rate * max(1, int(np.ceil(REPLAY.least_rate_hz / rate)))


def read_out(model: SimModel, recording: Recording, truth: Truth, zero: float) -> dict[str, Array]:
    """Return what every channel of a recording reads of a simulation whose rows begin at `zero` s."""
    out: dict[str, Array] = {}
    step = truth.time[1] - truth.time[0]

    def at(time: Array, values: Array) -> Array:
        places = np.clip((time - zero) / step, 0.0, truth.time.size - 1.0)
        return interpolate(values, places)

    for imu in recording.imus:
        chain = at_place(model.effects, imu.name)
        _, *both = read_by(truth, model.start, imu.time, imu.name, chain, first=zero - model.start)
        for part, values in zip(("gyro", "accel"), both, strict=True):
            out |= {f"{imu.name}.{name}": values[:, i] for i, name in enumerate(CHANNELS_WITH_UNIT[part][0])}
    for encoder in recording.encoders:
        angle = angle_read(truth, model.start, encoder.time, model.effects, zero - model.start)[:, None]
        if model.encoder_error is not None:
            angle = read(Jet(angle), Jet(model.encoder_error[None])).value
        out[f"encoder.{encoder.joint}"] = angle[:, 0] - encoder.zero
    for i, pose in enumerate(recording.poses, 1):
        segment = next(s for s in truth.segments if s.name == pose.segment)
        if pose.position is not None and (seen := np.isfinite(pose.position).all(axis=1)).any():
            place = at(pose.time[seen], segment.position)
            out |= {f"pose{i}.{name}": place[:, k] for k, name in enumerate(CHANNELS_WITH_UNIT["position"][0])}
        if pose.quaternion is not None and (seen := np.isfinite(pose.quaternion).all(axis=1)).any():
            q = at(pose.time[seen], segment.quaternion)
            off = rotations.multiply(rotations.conjugate(pose.quaternion[seen]), q / np.linalg.norm(q, axis=1)[:, None])
            vector = rotations.log(off)
            out |= {f"pose{i}.{name}": vector[:, k] for k, name in enumerate(CHANNELS_WITH_UNIT["rotation"][0])}
    return out


def posed(truth: Truth, zero: float, rate: float) -> Posed:
    """Return where a simulation, whose rows begin at `zero` s, has the rig, at about `rate` Hz."""
    step = truth.time[1] - truth.time[0]
    rows = np.arange(0, truth.time.size, max(1, round(1 / (step * rate))))
    return Posed(
        zero + truth.time[rows],
        {s.name: (s.position[rows], s.quaternion[rows]) for s in truth.segments},
        {s.name: (s.position[rows], s.quaternion[rows]) for s in truth.sensors},
    )


def simulated(model: SimModel, recording: Recording, windows: Sequence[Swing]) -> Simulated:
    """Return a recording as a model plays it: rolled out in the windows, prescribed elsewhere."""
    assert model.motion is not None
    start, end = span_of(recording)
    rate = dense_rate(recording)
    truth, first = played(model.rig, model.motion, model.effects, (start, end), rate, windows)
    return Simulated(read_out(model, recording, truth, first), posed(truth, first, quickest(recording)))
