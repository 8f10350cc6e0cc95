"""A low-pass filter in the place of a clock that is late: to first order both are a delay."""

import numpy as np
from scipy.interpolate import CubicSpline

from imubench.arrays import Array
from imubench.diagnosis.fit import Fit
from imubench.diagnosis.marks import Columns, Joint
from imubench.diagnosis.model import Hypothesis, Model, State
from imubench.diagnosis.terms import interpolated
from imubench.effects import VARIANTS
from imubench.recording import Imu

NEAR = 1.12  # how far apart the cutoffs are that are tried
FINE = 0.3  # of a delay: the steps at which a filter that stands for it is computed


def late(fit: Fit, h: Hypothesis) -> tuple[Imu, float] | None:
    """Return the IMU that reads late where an effect is a clock's offset, its own or the other of two, and by what."""
    if h.effect.name != "time_offset":
        return None
    recording, offset = fit.model.recording, float(fit.state.values[h.key("offset")][0])
    own = [i for i in recording.imus if i.name == h.at]
    others = [] if recording.encoders or recording.poses else [i for i in recording.imus if i.name != h.at]
    return next(((i, abs(offset)) for i in (own if offset > 0 else others)), None)


def filters(model: Model, state: State, imu: Imu, delay: float) -> Columns:
    """Return what low-pass filters of some cutoffs would add at an IMU, in the place of a delay in s."""
    read = {r.name: r.residual.value for r in model.measured(state)}
    out: Columns = {}
    names = [f"{imu.name}.gyro", f"{imu.name}.accel"]
    if delay <= 0 or any(len(read[n]) != len(imu.time) for n in names):
        return {}
    count = int(np.ceil(len(imu.time) / (FINE * delay * imu.rate))) + len(imu.time)
    fine = np.linspace(imu.time[0], imu.time[-1], count)
    w, f = (CubicSpline(imu.time, read[n] + x)(fine) for n, x in zip(names, (imu.gyro, imu.accel), strict=True))
    for effect in (e for e in VARIANTS if e.name == "low_pass" and not e.variant):
        for factor in (0.8, 0.9, 1.0, 1.1, 1.25):
            cutoff = factor / (2 * np.pi * delay)
            _, g, a = effect.corrupt(fine, w, f, {"cutoff": np.array(cutoff)}, np.random.default_rng(0))
            added = {names[0]: g - w, names[1]: a - f}
            out[f"{effect.name} {cutoff:.3g}"] = {n: interpolated(imu.time, fine, x) for n, x in added.items()}
    return out


def left_by(both: Joint, wanted: Array, by: Array) -> float:
    """Return what is lost when a direction (k,) stands for another, its size near 1: cutoffs between those tried."""
    pull = by @ both.information @ by
    size = float(np.clip(by @ both.information @ wanted / max(float(pull), 1e-300), 1 / NEAR, NEAR))
    rest = wanted - size * by
    return 0.5 * float(rest @ both.information @ rest)


__all__ = ["filters", "late", "left_by"]
