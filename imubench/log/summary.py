"""The words beside the picture: a verdict in one sentence and a table, in Markdown."""

import numpy as np

from imubench.arrays import Array, rms
from imubench.estimate import Estimate
from imubench.log.signals import constraint
from imubench.recording import Recording
from imubench.score import Score


def deviations(names: list[str], score: Score | None, angles: Array | None) -> dict[str, float]:
    """Return the deviation in deg per IMU: as scored, or else the mean of `angles` (n, m) in deg; empty if unjudged."""
    if score is not None:
        figures = {n: score.figures.get(f"angle_error_{n}", score.deviation(n)) for n in names}
        return {n: float(np.rad2deg(value)) for n, value in figures.items() if value is not None}
    if angles is None:
        return {}
    return {n: float(a) for n, a in zip(names, angles.mean(axis=0), strict=False)}


def spread(estimate: Estimate) -> list[float] | None:
    """Return the one-sigma length of each value by its covariance, along the worst direction; None without one.

    In deg for axes, in m for vectors.
    """
    if estimate.covariance is None or estimate.time is not None:
        return None
    blocks = [estimate.covariance[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] for i in range(len(estimate.value))]
    worst = [float(np.sqrt(max(np.linalg.eigvalsh(b)[-1], 0.0))) for b in blocks]
    return [float(np.rad2deg(w)) for w in worst] if estimate.quantity == "joint_axis" else worst


def verdict(
    recording: Recording, estimate: Estimate | None, score: Score | None, found: dict[str, float], judge: str = "true"
) -> str:
    """Return what came out, in a sentence or two, for somebody who has seen nothing else."""
    if estimate is None:
        return "Only signals: nothing was estimated from this recording."
    who = f"**{estimate.estimator}**"
    if estimate.status == "not identifiable":
        return f"{who} says that this motion does not identify the {_what(estimate)}."
    gave_up = "" if estimate.status == "converged" else ", but did not converge"
    if not found:
        floor = constraint(recording, estimate.value) if estimate.quantity == "joint_axis" else None
        if floor is None:
            return f"{who} gives the {_what(estimate)}{gave_up}; no truth is known to judge it by."
        turning = np.concatenate([np.linalg.norm(imu.gyro, axis=-1) for imu in recording.imus])
        return (
            f"{who} gives the {_what(estimate)}{gave_up}; no truth is known, but the hinge constraint is left at "
            f"{rms(floor[1]):.3g} rad/s RMS while the sensors turn at {rms(turning):.3g} rad/s RMS."
        ) + (" Their sign pairing is unknown." if estimate.pairing == "unknown" else "")
    against = "" if judge == "true" else f" against the {judge} axes"
    parts = []
    for name, angle in found.items():
        length = None if score is None else score.figures.get(f"error_{name}")
        parts.append(f"**{angle:.2f}°** {'' if length is None else f'and {1e3 * length:.1f} mm '}off in {name}")
    text = f"{who} finds the {_what(estimate)} {' and '.join(parts)}{against}{gave_up}."
    if estimate.quantity == "joint_axis" and max(found.values()) > 90:
        text += " The signs of the two axes are paired wrongly."
    return text + _pairing(estimate)


def _pairing(estimate: Estimate) -> str:
    """Return a sentence where nothing says how the signs of two axes go together."""
    return " Their sign pairing is unknown: shown is the better one." if estimate.pairing == "unknown" else ""


def summary(
    recording: Recording,
    estimate: Estimate | None,
    score: Score | None,
    found: dict[str, float],
    source: str,
    judge: str,
) -> str:
    """Return the Markdown of the summary; `found` is what `deviations` returns, `source` where the poses
    come from, `judge` the word for what is drawn as true.
    """
    lines = [f"### {verdict(recording, estimate, score, found, judge)}", ""]
    if estimate is not None:
        sigma, unit = spread(estimate), "°" if estimate.quantity == "joint_axis" else " m"
        names = [imu.name for imu in recording.imus][: estimate.value.shape[-2]]
        lines += ["| estimator | IMU | deviation | 1 σ claimed | status |", "|---|---|---|---|---|"]
        for i, name in enumerate(names):
            off = f"{found[name]:.3f}°" if name in found else "not judged"
            claimed = "none" if sigma is None else f"{sigma[i]:.2g}{unit}"
            lines.append(f"| {estimate.estimator} | {name} | {off} | {claimed} | {estimate.status} |")
        if estimate.covariance is None:
            lines += ["", f"No covariance: {estimate.no_covariance_because}."]
    lines += ["", "| rig | sensor | samples | rate | from | to |", "|---|---|---|---|---|---|"]
    for imu in recording.imus:
        lines.append(
            f"| {recording.rig} | {imu.name} | {imu.time.size} | {imu.rate:g} Hz "
            f"| {imu.time[0]:.2f} s | {imu.time[-1]:.2f} s |"
        )
    for encoder in recording.encoders:
        span = f"{encoder.time[0]:.2f} s | {encoder.time[-1]:.2f} s"
        lines.append(f"| {recording.rig} | encoder {encoder.joint} | {encoder.time.size} | – | {span} |")
    arrows = "" if estimate is None else " Thick orange: estimated."
    arrows += f" Thin green: {judge}." if found else ""
    lines += ["", f"3D view: {source}.{arrows} Red, green, blue on an IMU: x, y, z."]
    return "\n".join(lines)


def _what(estimate: Estimate) -> str:
    return "hinge axis" if estimate.quantity == "joint_axis" else "joint centre"
