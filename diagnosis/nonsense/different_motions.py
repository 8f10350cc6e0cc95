"""Sensors that do not move together although their rig says that they must: files of two different recordings."""

from collections.abc import Iterator

import numpy as np
from scipy.ndimage import gaussian_filter1d

from imubench.arrays import Array
from imubench.diagnosis.config.nonsense import SHARED_MOTION, STRETCH
from imubench.diagnosis.nonsense.shared_motion import Shared, shared, squares
from imubench.diagnosis.nonsense.stretch import averaged, dense_enough, grid, stretch_of_most_motion
from imubench.diagnosis.result import Nonsense
from imubench.recording import Encoder, Imu, Pose, Recording
from imubench.rotations import conjugate, log, multiply


def different_motions(recording: Recording) -> Iterator[Nonsense]:
    """Yield every pair of sensors that shares no motion.

    Two IMUs on a hinge share what they turn across its axis; it is asked for where one of them turns about more than
    one axis. On a fixed base the first does not move. A gyroscope shares its rate with the measured attitude of its
    segment, and the rates of a hinge's IMUs make that of its encoder.
    """
    some = stretch_of_most_motion(recording, STRETCH.most_s)
    imus = {imu.name: imu for imu in some.moving if dense_enough(imu.time)}
    one, two = (imus.get(name) for name in some.tree.pair or ("", ""))
    if one and two and (found := shared_on_hinge(one, two)):
        yield _told("joint", "the two IMUs do not move together", found)
    for i, pose in enumerate(some.poses):
        for imu in (m for m in imus.values() if some.carrier(m.name) == pose.segment):
            if pose.quaternion is not None and (found := shared_with_pose(imu, pose)):
                yield _told(f"pose{i + 1}", f"{imu.name} and the measured pose do not move together", found)
    for encoder in some.encoders if two and len(imus) == len(some.moving) else ():
        if found := shared_with_encoder(list(imus.values()), encoder):
            yield _told("encoder", "the IMUs and the encoder do not move together", found)


def _told(at: str, what: str, found: Shared) -> Nonsense:
    evidence = {"correlation": found.correlation, "beyond_chance_std": found.beyond}
    advice = "check that the files are of one recording, and that their clocks began together"
    return Nonsense(at, what, evidence, advice=advice)


def shared_on_hinge(one: Imu, two: Imu) -> Shared | None:
    """Return what two IMUs on a hinge share, if that is nothing."""
    edges = grid([one.time, two.time], SHARED_MOTION.grid_hz)
    if edges.size < 2:
        return None
    rates = [smooth(averaged(i.time, i.gyro, edges), edges) for i in (one, two)]
    if max(rate_across_axis(w) for w in rates) < SHARED_MOTION.turning_rad_s:
        return None
    return _if_nothing(squares(rates[0]), squares(rates[1]), edges)


def shared_with_pose(imu: Imu, pose: Pose) -> Shared | None:
    """Return what an IMU shares with the measured attitude of its segment, if that is nothing."""
    time, rate = rate_of(pose)
    if not dense_enough(time):
        return None
    edges = grid([imu.time, time], SHARED_MOTION.grid_hz)
    if edges.size < 2:
        return None
    rates = [smooth(averaged(t, w, edges), edges) for t, w in ((imu.time, imu.gyro), (time, rate))]
    if max(float(np.sqrt(np.mean(np.sum(w**2, axis=1)))) for w in rates) < SHARED_MOTION.turning_rad_s:
        return None
    return _if_nothing(rates[0], rates[1], edges)


def shared_with_encoder(imus: list[Imu], encoder: Encoder) -> Shared | None:
    """Return what a hinge's IMUs share with its encoder, if that is nothing."""
    if not dense_enough(encoder.time):
        return None
    edges = grid([encoder.time, *(i.time for i in imus)], SHARED_MOTION.grid_hz)
    if edges.size < 2:
        return None
    rate = np.diff(np.interp(edges, encoder.time, encoder.angle))[:, None] / np.diff(edges)[:, None]
    rates = np.concatenate([smooth(averaged(i.time, i.gyro, edges), edges) for i in imus], axis=1)
    rate = smooth(rate, edges)
    if float(np.sqrt(np.mean(rate**2))) < SHARED_MOTION.turning_rad_s:
        return None
    return _if_nothing(rates, rate, edges)


def _if_nothing(one: Array, two: Array, edges: Array) -> Shared | None:
    found = shared(one, two, float(edges[1] - edges[0]))
    return found if found and found.unrelated else None


def smooth(values: Array, edges: Array) -> Array:
    """Return values (n, k) on even edges (n + 1,) s without what is quicker than `SHARED_MOTION.below_hz`."""
    width = np.sqrt(np.log(2) / 2) / (np.pi * SHARED_MOTION.below_hz)  # s: a Gaussian's half-power frequency is that
    return np.asarray(gaussian_filter1d(values, width / (edges[1] - edges[0]), axis=0))


def rate_across_axis(rate: Array) -> float:
    """Return the RMS of rates (n, 3) without their main axis: what is turned across a hinge is at least that."""
    power = np.linalg.eigvalsh(rate.T @ rate / len(rate))
    return float(np.sqrt(max(power[0] + power[1], 0.0)))


def rate_of(pose: Pose) -> tuple[Array, Array]:
    """Return the times (n,) s and body rates (n, 3) rad/s of a measured attitude, where one is measured."""
    assert pose.quaternion is not None  # as the caller has asked
    seen = np.isfinite(pose.quaternion).all(axis=1)
    time, q = pose.time[seen], pose.quaternion[seen]
    if len(time) < 2:
        return time, np.zeros((len(time), 3))
    turn = log(multiply(conjugate(q[:-1]), q[1:]))
    return 0.5 * (time[1:] + time[:-1]), turn / np.diff(time)[:, None]


__all__ = ["different_motions"]
