"""A run written for the Rerun viewer: the rig in 3D, the signals, the error, the verdict."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import rerun as rr
from numpy.typing import ArrayLike
from rerun.error_utils import catch_and_log_exceptions

from imubench.arrays import Array, frozen
from imubench.atomic import atomic_file
from imubench.estimate import Estimate
from imubench.log.blueprint import run_blueprint
from imubench.log.joint import mean_axes
from imubench.log.scene import log_scene
from imubench.log.signals import (
    aligned,
    drawn_rows,
    interpolate,
    log_constraint,
    log_error,
    log_sections,
    log_signals,
)
from imubench.log.summary import deviations, summary
from imubench.recording import Recording
from imubench.reference import Reference
from imubench.score import Score
from imubench.truth import Truth

STEADY = 1e-3  # deg; an error that changes by less gets no plot, the summary says it


def log_run(
    path: Path,
    recording: Recording,
    truth: Truth | None = None,
    estimate: Estimate | None = None,
    score: Score | None = None,
    true_axes: ArrayLike | None = None,
    axes_from: str = "reference",
    reference: Reference | None = None,
    name: str | None = None,
) -> None:
    """Write a run to `path`, a .rrd file of Rerun that carries its layout; nothing is opened.

    `true_axes` (m, 3), unit, sensor axes, stand in for the truth that a real recording has not
    got; `axes_from` is the word for them in the picture. `reference` moves the rig. Joint axes
    are shown with both signs turned together towards the true ones, as they are scored, and each
    on its own where their pairing is unknown. The file appears whole or not at all; `InputError`
    when its place cannot be written, a full disk included, or `true_axes` do not fit.
    """
    axes = mean_axes(recording, truth)
    if axes is None and true_axes is not None:
        axes = frozen(true_axes, (len(recording.imus), 3), "true_axes")
    if estimate is not None and estimate.quantity == "joint_axis" and axes is not None:
        estimate = replace(estimate, value=aligned(estimate.value, axes, together=estimate.pairing != "unknown"))
    judge = "true" if truth is not None or axes is None else axes_from
    rec = rr.RecordingStream("imubench")
    # In memory first: Rerun's own file sink can wait for ever when its disk is full (0.41.0).
    memory = rec.memory_recording()
    with catch_and_log_exceptions("log_run", strict=True):  # wrong arguments raise, not only warn
        _log_all(rec, recording, truth, estimate, score, axes, reference, name or recording.name, judge)
    data = memory.drain_as_bytes()
    rec.disconnect()
    with atomic_file(Path(path)) as partial:
        partial.write_bytes(data)


def _log_all(
    rec: rr.RecordingStream,
    recording: Recording,
    truth: Truth | None,
    estimate: Estimate | None,
    score: Score | None,
    axes: Array | None,
    reference: Reference | None,
    name: str,
    judge: str,
) -> None:
    imus = [imu.name for imu in recording.imus]
    shown = log_signals(rec, recording, truth, reference)
    shown |= {"true"} if axes is not None or (truth and estimate) else set()
    shown |= {"estimated"} if estimate else set()
    scene = log_scene(rec, recording, truth, estimate, reference, axes, judge)
    angles = None
    if estimate is not None:
        if estimate.quantity == "joint_axis" and log_constraint(rec, recording, estimate, axes, judge):
            shown.add("constraint")
        judged = _true_values(recording, truth, estimate, axes)
        if judged is not None:
            angles = log_error(rec, imus, estimate, *judged)
            if np.ptp(angles, axis=0).max() > STEADY:
                shown |= {"error/angle", "error/length"} if estimate.quantity == "joint_vector" else {"error/angle"}
    sections = {
        "motion": truth.labels if truth else (),
        "free_swing": [("free swing", *w) for w in recording.free_swings],
    }
    for what, spans in sections.items():
        if spans:
            log_sections(rec, f"sections/{what}", spans)
            shown.add("sections")
    text = summary(recording, estimate, score, deviations(imus, score, angles), scene.source, judge)
    rec.log("summary", rr.TextDocument(text, media_type="text/markdown"), static=True)
    rec.send_recording_name(name)
    facts = {"rig": recording.rig, "name": name, "gravity": recording.gravity}
    rec.send_property("run", rr.AnyValues(**facts, estimator=estimate.estimator if estimate else "none"))
    clocks = [i.time for i in recording.imus] + [e.time for e in recording.encoders] + [p.time for p in recording.poses]
    span = min(float(t[0]) for t in clocks), max(float(t[-1]) for t in clocks)
    rec.send_blueprint(run_blueprint(imus, shown, scene, judge, span), make_active=True, make_default=True)


def _true_values(
    recording: Recording, truth: Truth | None, estimate: Estimate, axes: Array | None
) -> tuple[Array, Array] | None:
    """Return when to judge an estimate, (n,) s, and the true value then, (n, m, 3); None if nothing is known."""
    sensors = [truth.sensor(imu.name) for imu in recording.imus] if truth else []
    if truth is not None:
        values = [s.joint_axis if estimate.quantity == "joint_axis" else s.joint_vector for s in sensors]
        known = [v for v in values if v is not None]
        if len(known) == len(values) == estimate.value.shape[-2]:
            time = truth.time[drawn_rows(truth.time)] if estimate.time is None else estimate.time
            return time, interpolate(time, truth.time, np.stack(known, axis=1))
    if axes is not None and estimate.value.shape == axes.shape:
        time = recording.imus[0].time[[0, -1]]
        return time, np.stack([axes, axes])
    return None
