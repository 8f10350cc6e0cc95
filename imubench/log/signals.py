"""Time series of a run in Rerun: signals, joint angle, constraint, error and motion sections."""

from collections.abc import Sequence

import numpy as np
import rerun as rr
from numpy.typing import ArrayLike

from imubench.arrays import Array
from imubench.estimate import Estimate
from imubench.recording import Recording
from imubench.reference import Reference
from imubench.rotations import angle_between
from imubench.truth import Truth

TIMELINE = "sim_time"
LAST_TIME = 9.2e9  # s; 2^63 ns are 9.22e9 s
BETWEEN = ""  # the state where no section is: a gap in the view, as null is; `rerun rrd verify` refuses null (0.41.0)
DRAWN_RATE = 60.0  # Hz, about: of what is drawn in 3D

XYZ = ((230, 70, 70), (70, 180, 80), (80, 130, 245))  # x, y, z
TRUE = (60, 200, 90)  # whatever is true
ESTIMATED = (255, 140, 25)  # whatever was estimated
IMU_COLOURS = ((240, 170, 60), (110, 190, 235))  # imu1, imu2 where they share a plot


def time_column(time: Array) -> rr.TimeColumn:
    """Return times (n,) in s as a Rerun index in whole nanoseconds, rounded to the nearest.

    Times that 64 bits do not hold, 292 years from zero, stand at the end of what they do.
    """
    whole = np.round(within_time(time) * 1e9).astype("int64")
    return rr.TimeColumn(TIMELINE, duration=whole.astype("timedelta64[ns]"))


def within_time(time: ArrayLike) -> Array:
    """Return times in s, no farther from zero than Rerun's clock of 64-bit nanoseconds goes."""
    return np.clip(np.asarray(time, dtype=float), -LAST_TIME, LAST_TIME)


def drawn_rows(time: Array) -> Array:
    """Return the row numbers that bring `time` (n,) down to about `DRAWN_RATE`, the last row always among them."""
    n = time.size
    rate = (n - 1) / (time[-1] - time[0]) if n > 1 else 0.0
    step = max(1, round(rate / DRAWN_RATE))
    return np.unique(np.append(np.arange(0, n, step), n - 1))


def interpolate(at: Array, time: Array, values: Array) -> Array:
    """Return `values` (n, ...) given at `time` (n,), linearly interpolated at the times `at` (k,)."""
    flat = values.reshape(time.size, -1)
    return np.stack([np.interp(at, time, column) for column in flat.T], axis=-1).reshape(at.size, *values.shape[1:])


def log_series(
    rec: rr.RecordingStream,
    path: str,
    time: Array,
    values: Array,
    names: Sequence[str],
    colours: Sequence[tuple[int, int, int]],
    width: float = 1.5,
) -> None:
    """Log `values` (n,) or (n, k) at `time` (n,) in s as k lines with their names and colours."""
    rec.log(path, rr.SeriesLines(names=list(names), colors=list(colours), widths=[width] * len(names)), static=True)
    rec.send_columns(path, indexes=[time_column(time)], columns=rr.Scalars.columns(scalars=values))


def log_signals(
    rec: rr.RecordingStream, recording: Recording, truth: Truth | None, reference: Reference | None
) -> set[str]:
    """Log every sensor's samples in full, the true signal at the same stamps, and the joint angle.

    The truth is interpolated linearly at the stamps of each IMU. Returns {"angle"} if an angle is known.
    """
    shown = set()
    for imu in recording.imus:
        true = next((s for s in truth.sensors if s.name == imu.name), None) if truth else None
        pairs = (
            ("gyro", "rad/s", imu.gyro, true.gyro if true else None),
            ("accel", "m/s²", imu.accel, true.specific_force if true else None),
        )
        for what, unit, measured, exact in pairs:
            names = [f"{what} {axis} ({unit})" for axis in "xyz"]
            log_series(rec, f"{imu.name}/{what}", imu.time, measured, names, XYZ)
            if truth is not None and exact is not None:
                path = f"truth/{imu.name}/{'gyro' if what == 'gyro' else 'specific_force'}"
                log_series(
                    rec, path, imu.time, interpolate(imu.time, truth.time, exact), [f"true {n}" for n in names], XYZ
                )
    for encoder in recording.encoders:
        angle = encoder.angle + encoder.zero
        log_series(rec, f"encoder/{encoder.joint}/angle", encoder.time, angle, ["encoder (rad)"], [(200, 120, 220)])
        shown.add("angle")
    if reference is not None and reference.hinge_angle is not None:
        seen = np.isfinite(reference.hinge_angle)
        time, angle = reference.time[seen], reference.hinge_angle[seen]
        log_series(rec, "reference/hinge_angle", time, angle, ["reference (rad)"], [(170, 170, 170)])
        shown.add("angle")
    if truth is not None and truth.joint_angle is not None:
        log_series(rec, "joint/angle", truth.time, truth.joint_angle, ["true (rad)"], [TRUE])
        shown.add("angle")
    return shown


def constraint(recording: Recording, axes: Array) -> tuple[Array, Array] | None:
    """Return time (n,) and |w1 x j1| - |w2 x j2| (n,) in rad/s of joint axes (2, 3); None without two IMUs.

    Both projections agree for the right axes of a rigid hinge (Seel 2012). The second IMU is
    interpolated at the stamps of the first where both overlap.
    """
    if len(recording.imus) != 2 or axes.shape != (2, 3):
        return None
    first, second = recording.imus
    both = (first.time >= second.time[0]) & (first.time <= second.time[-1])
    time = first.time[both]
    rate1, rate2 = first.gyro[both], interpolate(time, second.time, second.gyro)
    across = [np.linalg.norm(np.cross(w, j), axis=-1) for w, j in zip((rate1, rate2), axes, strict=True)]
    return time, across[0] - across[1]


def log_constraint(
    rec: rr.RecordingStream, recording: Recording, estimate: Estimate, true_axes: Array | None, judge: str
) -> bool:
    """Log the hinge constraint of the estimated axes and, as the floor of noise, of the true ones (2, 3).

    `judge` is the word for the true ones. Returns whether there was a constraint to log.
    """
    found = None
    for axes, path, name, colour in (
        (estimate.value, "estimated_axis", "estimated axis (rad/s)", ESTIMATED),
        (true_axes, f"{judge}_axis", f"{judge} axis (rad/s)", TRUE),
    ):
        if axes is not None and (found := constraint(recording, axes)) is not None:
            log_series(rec, f"joint/constraint/{path}", *found, [name], [colour])
    return found is not None


def aligned(value: Array, true: Array, together: bool = True) -> Array:
    """Return axes (..., m, 3) turned together so that the first is within 90 deg of the true (..., m, 3).

    Not `together`: each is turned on its own, since their signs mean nothing.
    """
    flip = np.sum(value * true, axis=-1, keepdims=True) < 0
    return np.where(flip[..., :1, :] if together else flip, -value, value)


def log_error(rec: rr.RecordingStream, names: Sequence[str], estimate: Estimate, time: Array, true: Array) -> Array:
    """Log the error of an estimate over `time` (n,) against the true value (n, m, 3) in m sensors.

    Angles go out in deg, the length of a vector's error in m. Returns the angles (n, m) in deg.
    """
    angles = np.rad2deg(angle_between(estimate.value, true))
    lengths = np.linalg.norm(estimate.value - true, axis=-1)
    for i, name in enumerate(names):
        colour = [IMU_COLOURS[i]]
        log_series(rec, f"error/angle/{name}", time, angles[:, i], [f"{name} (deg)"], colour, 2.5)
        if estimate.quantity == "joint_vector":
            log_series(rec, f"error/length/{name}", time, lengths[:, i], [f"{name} (m)"], colour, 2.5)
    return angles


def log_sections(rec: rr.RecordingStream, path: str, sections: Sequence[tuple[str, float, float]]) -> None:
    """Log named spans (what, start, end) in s as states; where spans overlap the latest to start shows."""
    edges = sorted({edge for _, start, end in sections for edge in (start, end)})
    states = []
    for edge in edges:
        running = [(start, what) for what, start, end in sections if start <= edge < end]
        states.append(max(running)[1] if running else BETWEEN)
    column = rr.StateChange.columns(state=states)
    rec.send_columns(path, indexes=[time_column(np.array(edges))], columns=column)
