"""A low-pass filter in the place of a clock that is late: to first order both are a delay.

A filter reads LP[x](t), a delay x(t - tau), and between them c(t) = LP[x](t) - x(t - tau), about tau^2 / 2 x''. It is
taken from the motion as it was fitted, up to the frequency at which that sinks into the noise: above, the fitted motion
is made of the very noise, and c would be nothing else (0.005 m/s^2 for 0.0008 on a limb that moves at 5 Hz).

A delay far below the sampling interval would take a grid far finer than the samples. There c is its series, about the
time u = t - tau of the world that a delay shows, with D = d/dt::

    LP[x](u + tau) - x(u) = [exp(tau D) / (1 + tau D) - 1] x = tau^2 / 2 D^2 x - tau^3 / 3 D^3 x + 3/8 tau^4 D^4 x - ...

At w rad/s the third term is 3/4 (w tau)^2 of the first.
"""

from collections.abc import Mapping

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import welch

from imubench.arrays import Array
from imubench.diagnosis.config.criteria import DELAY
from imubench.diagnosis.criteria.signatures import Columns, JointInformation
from imubench.diagnosis.noise.coherence import clear_of_noise, even_stamps, slower
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.bspline import interpolated
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis, State
from imubench.effects import delay_law, filter_law
from imubench.effects.effect import Effect
from imubench.recording import Imu

Readings = dict[str, Array]


def late_imu(fit: Fit, h: Hypothesis) -> tuple[Imu, float] | None:
    """Return the IMU that reads late where an effect is a clock's offset, its own or the other of two, and by what."""
    if not h.effect.late_by:
        return None
    recording, offset = fit.model.recording, float(fit.state.values[h.key(h.effect.late_by)][0])
    own = [i for i in recording.imus if i.name == h.at]
    others = [] if recording.encoders or recording.poses else [i for i in recording.imus if i.name != h.at]
    return next(((i, abs(offset)) for i in (own if offset > 0 else others)), None)


def filters(bare: Model, still: State, imu: Imu, delay: float, noise: Mapping[str, float]) -> Columns:
    """Return what a low-pass filter at an IMU would add, in the place of a delay in s; `noise` as a fit has it."""
    law = filter_law()
    if delay <= 0 or law is None:
        return {}
    clock = Hypothesis(delay_law(), imu.name)
    moved = bare.with_effects((*bare.hypotheses, clock))
    at_once = {r.name: r.residual.value for r in bare.measured(still, {imu.name})}
    delayed = list(
        moved.measured(
            State(still.coefficients, still.values | {clock.key(clock.effect.late_by): np.array([delay])}), {imu.name}
        )
    )
    time, x = extrapolated(*clear_readings(bare, still, imu, noise), delay)
    c = beyond_delay(law, time, x, delay)
    return {
        law.name: {
            r.name: r.residual.value - at_once[r.name] + interpolated(r.time, time, c[r.name.split(".")[1]])
            for r in delayed
        }
    }


def filter_beyond_delay(fit: Fit, imu: Imu, delay: float) -> Effect | None:
    """Return a filter in the place of a late clock's delay in s, None where it is not far quicker than the motion."""
    law = filter_law()
    if law is None:
        return None
    time, x = extrapolated(*clear_readings(fit.model, fit.state, imu, fit.noise), delay)
    moved = {part: np.gradient(x[part], time, axis=0) * delay for part in x}
    c = beyond_delay(law, time, x, delay)
    if any(np.std(c[part]) > DELAY.quick * np.std(moved[part]) for part in x):
        return None
    low, high = (beyond_delay(law, time, x, delay * (1 + change)) for change in (-DELAY.difference, DELAY.difference))
    return law.far_quicker(
        time, c, {part: (high[part] - low[part]) / (2 * DELAY.difference * delay) for part in x}, delay
    )


def clear_readings(model: Model, state: State, imu: Imu, noise: Mapping[str, float]) -> tuple[Array, Readings]:
    """Return times (n,) s and what an IMU would read there, (n, 3), without what is only the fit's noise.

    At even times of the world, through the gaps of its samples too.
    """
    moment = model.moment(state, even_stamps(imu), imu.name)
    segment = model.carrier(state, moment, imu.name)
    reading = model.reading(imu, state, moment, segment)
    many = (len(moment.time.value), 3)  # on a base that stands still a reading is one for all times
    x = {n: np.broadcast_to(j.value, many) for n, j in (("gyro", reading.gyro), ("accel", reading.accel))}
    cut = {
        n: clear_of_noise(v, max(noise[f"{imu.name}.{n}"], high_band_std(v, imu.rate)), imu.rate) for n, v in x.items()
    }
    return moment.time.value[:, 0], {part: slower(v, cut[part], imu.rate) for part, v in x.items()}


def high_band_std(signal: Array, sampling: float) -> float:
    """Return the std of white noise as loud as a signal (n, 3) is in the upper third of its frequencies.

    A gyroscope that also follows from another's accelerometer is fitted with several times its own noise there.
    """
    f, power = welch(signal, sampling, nperseg=min(256, len(signal)), axis=0)
    return float(np.sqrt(np.median(power.sum(axis=1)[f > sampling / 3]) / 3 * sampling / 2))


def is_short(time: Array, delay: float) -> bool:
    """Return whether a delay in s is far shorter than the steps of times (n,)."""
    return bool(delay < DELAY.short * (time[1] - time[0]))


def extrapolated(time: Array, x: Readings, delay: float) -> tuple[Array, Readings]:
    """Return fine times and readings (n, 3) there, which go straight on before the first one and after the last.

    A filter that begins at the first reading, which is moving, would be wrong there by all that it delays. With a delay
    that is far shorter than the steps these stay as they are.
    """
    if is_short(time, delay):
        return time, dict(x)
    start, end = time[0] - DELAY.settled * delay, time[-1] + DELAY.settled * delay
    fine = np.linspace(start, end, int(np.ceil((end - start) / (DELAY.step * delay))) + len(time))
    inside = np.clip(fine, time[0], time[-1])
    splines = {part: CubicSpline(time, y) for part, y in x.items()}
    return fine, {part: s(inside) + (fine - inside)[:, None] * s(inside, 1) for part, s in splines.items()}


def beyond_delay(law: Effect, time: Array, x: Mapping[str, Array], delay: float) -> Readings:
    """Return c (n, 3): what a filter's `law` reads beside one that only delays, at even times (n,) of the world."""
    if is_short(time, delay):
        splines = {part: CubicSpline(time, y) for part, y in x.items()}
        return {part: delay**2 / 2 * s(time, 2) - delay**3 / 3 * s(time, 3) for part, s in splines.items()}
    cutoff = {"cutoff": np.array(1 / (2 * np.pi * delay))}
    _, *read = law.corrupt(time, x["gyro"], x["accel"], cutoff, np.random.default_rng(0))
    return {part: interpolated(time + delay, time, y) - x[part] for part, y in zip(x, read, strict=True)}


def left_by(both: JointInformation, wanted: Array, by: Array) -> float:
    """Return the loss of a direction (k,) in another's place, its size near 1, so that the cutoff is the delay's."""
    pull = by @ both.information @ by
    size = float(
        np.clip(by @ both.information @ wanted / max(float(pull), 1e-300), 1 / DELAY.cutoff_ratio, DELAY.cutoff_ratio)
    )
    rest = wanted - size * by
    return 0.5 * float(rest @ both.information @ rest)


__all__ = ["filter_beyond_delay", "filters", "late_imu", "left_by"]
