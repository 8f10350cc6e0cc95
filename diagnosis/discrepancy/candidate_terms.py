"""The terms without a name that are tried on a fit: at each IMU, and in the torque of free swings."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.discrepancy import BASIS
from imubench.diagnosis.discrepancy.basis_functions import curve, drifts, even, kinked, play, settling, shaking, signs
from imubench.diagnosis.discrepancy.terms import ANGULAR_ACCELERATION, JOINT_RATE, JUMP, LATE, LATER, OWN, Term
from imubench.diagnosis.noise.coherence import clear_in, slower
from imubench.diagnosis.problem.batch_model import middles
from imubench.diagnosis.problem.bspline import Moment
from imubench.diagnosis.problem.dynamics_factors import swing_rows
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.residuals import SWING_EQUATION
from imubench.diagnosis.problem.rig_kinematics import HINGE
from imubench.jets import Jet, skew
from imubench.recording import Imu


def terms(fit: Fit) -> Iterator[Term]:
    """Yield every term that is tried on a fit: of a long recording all of them at once would fill the memory."""
    for imu in fit.model.recording.imus:
        yield from (term for term in sensor_terms(fit, imu) if term.count)
    yield from (term for term in torque_terms(fit) if term.count)


def sensor_terms(fit: Fit, imu: Imu) -> Iterator[Term]:
    """Yield the terms at one IMU."""
    model, state = fit.model, fit.state
    moment = model.moment(state, imu.time, imu.name)
    segment = model.carrier(state, moment, imu.name)
    reading = model.reading(imu, state, moment, segment)
    turning = segment.child(model.mount(imu, state, moment, segment)).accel.value
    time, n = moment.time.value[:, 0], len(imu.time)
    sensed = {
        "gyro": np.broadcast_to(reading.gyro.value, (n, 3)),
        "accel": np.broadcast_to(reading.accel.value, (n, 3)),
    }
    shaken = {part: even(*shaking(x, imu.rate).T) for part, x in sensed.items()}
    cut = clear_in(fit, imu, "gyro")
    sensed = {part: slower(x, cut, imu.rate) for part, x in sensed.items()}
    turning = slower(np.broadcast_to(turning, (n, 3)), cut, imu.rate)
    if model.rig.hinge:
        angle, rate = (moment.track(HINGE, order).value[:, 0] for order in range(2))
    for part, x in sensed.items():
        unit = fit.noise.get(f"{imu.name}.{part}")
        if unit is None:  # no sample of it counts
            continue
        make = Maker(imu.name, part, time, unit)
        slope = np.gradient(x, time, axis=0)
        lags = np.moveaxis(
            play(x[:, None], np.std(x, axis=0) * np.array(BASIS.play_widths)[:, None]) - x[:, None], 1, 0
        )
        yield make.each(OWN, [kinked(x[:, i]) for i in range(3)])
        yield make.each(f"{OWN} and where it came from", [even(*(lag[:, i] for lag in lags)) for i in range(3)])
        yield make.alike(f"{OWN}, by one law for all axes", [x, x * np.abs(x), x**3, *signs(x)])
        yield make.alike(f"{OWN} and where it came from, by one law for all axes", list(lags))
        bend = np.gradient(slope, time, axis=0)
        yield make.every(LATER, even(*x.T, *slope.T, *bend.T))
        for i in range(3):
            before = [np.interp(time - late, time, x[:, i]) for late in BASIS.lags_s]
            basis = even(x[:, i], slope[:, i], bend[:, i], *before)
            yield make.others(f"the reading of axis {'xyz'[i]}, {LATE}", i, basis)
        yield make.every(ANGULAR_ACCELERATION, even(*turning.T))
        if part == "gyro":
            yield make.every("shaking", np.concatenate([*shaken.values()], axis=1))
        yield make.every("the accelerometer's shaking", shaken["accel"])
        yield replace(make.every("time", drifts(time)), drift=True, timed=True)
        if model.rig.hinge:
            yield make.every("the hinge angle", curve(angle))
            yield make.every("the hinge rate", kinked(rate))
    yield replace(turning_with("time: the sensor turns slowly", imu.name, time, sensed, drifts(time)), timed=True)
    yield turning_with("time: the sensor turns and settles", imu.name, time, sensed, settling(time))


def turning_with(goes_with: str, at: str, time: Array, sensed: Mapping[str, Array], late: Array) -> Term:
    """Return the term in which a mount turns about each axis by functions of time (n, k).

    Turned by a small q its sensor reads x - q x x of a vector x, and its gyroscope how fast it turns, dq/dt, as well.
    """
    late = late - late.mean(axis=0)  # the mount is where it is on average
    turned = {part: np.einsum("nk,nij->nijk", late, skew(x)) for part, x in sensed.items()}
    turned["gyro"] += np.einsum("nk,ij->nijk", np.gradient(late, time, axis=0), np.eye(3))
    signals = {part: BASIS.turn_rad * s.reshape(len(time), 3, -1) for part, s in turned.items()}
    return Term(at, "both", goes_with, time, signals, (-1,) * (3 * late.shape[1]))


@dataclass(frozen=True)
class Maker:
    """Makes terms of one triple."""

    at: str
    part: str
    time: Array
    unit: float

    def every(self, goes_with: str, basis: Array) -> Term:
        """Return the term in which each channel is a function of the same signals (n, k)."""
        return self.each(goes_with, [basis] * 3)

    def others(self, goes_with: str, axis: int, basis: Array) -> Term:
        """Return the term in which both channels but that of one axis are functions of the same signals (n, k)."""
        return self.each(goes_with, [basis[:, :0] if i == axis else basis for i in range(3)])

    def alike(self, goes_with: str, signals: list[Array]) -> Term:
        """Return the term in which one law adds its signals (n, 3) to all channels."""
        each = [self.unit * x / max(float(np.sqrt(np.mean(x**2))), 1e-12) for x in signals]
        return Term(self.at, self.part, goes_with, self.time, {self.part: np.stack(each, axis=2)}, (-1,) * len(each))

    def each(self, goes_with: str, bases: list[Array]) -> Term:
        """Return the term in which each channel is a function of its own signals (n, k)."""
        total = sum(b.shape[1] for b in bases)
        signals, channel, at = np.zeros((len(self.time), 3, total)), [], 0
        for i, basis in enumerate(bases):
            signals[:, i, at : at + basis.shape[1]] = self.unit * basis
            channel += [i] * basis.shape[1]
            at += basis.shape[1]
        return Term(self.at, self.part, goes_with, self.time, {self.part: signals}, tuple(channel))


def jumps(fit: Fit, imu: Imu, part: str, starts: Array) -> list[Term]:
    """Return jumps of one triple's readings at times (m,) s on the splines."""
    time = imu.time - fit.model.start
    make = Maker(imu.name, part, time, fit.noise[f"{imu.name}.{part}"])
    words = [f"{JUMP} at {start + fit.model.start:.2f} s" for start in starts]
    steps = [1.0 * (time >= start)[:, None] for start in starts]
    return [replace(make.every(w, x), drift=True, timed=True) for w, x in zip(words, steps, strict=True)]


def torque_terms(fit: Fit) -> Iterator[Term]:
    """Yield the terms of the torque in free swings."""
    model, state = fit.model, fit.state
    rows = list(swing_rows(model, state, middles(model)))
    if not rows:
        return
    time = rows[0].time
    moment = Moment(model.tracks, state.coefficients, Jet(time[:, None]))
    segment = model.last(state, moment)
    angle, rate, _ = (x.value[:, 0] for x in model.scene(moment, segment).turned())
    unit = fit.noise.get(SWING_EQUATION, 1.0) * float(np.mean(rows[0].std))
    waves = [f(k * angle) for k in range(1, BASIS.harmonics + 1) for f in (np.sin, np.cos)]
    bases: dict[str, Callable[[], Array]] = {
        "the joint's angle, again and again": lambda: np.stack(waves, axis=1),
        "the joint's angle": lambda: curve(angle - np.mean(angle)),
        JOINT_RATE: lambda: kinked(rate),
        "time": lambda: drifts(time),
    }
    for words, basis in bases.items():
        b = basis()
        slow = words == "time"
        yield Term("joint", "torque", words, time, {"torque": unit * b}, (0,) * b.shape[1], drift=slow, timed=slow)


__all__ = ["Maker", "jumps", "sensor_terms", "terms", "torque_terms"]
