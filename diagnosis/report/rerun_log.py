"""A diagnosis for the Rerun viewer: the recovered motion in 3D, residuals before and after, windows marked."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from rerun.error_utils import catch_and_log_exceptions

from imubench.atomic import atomic_file
from imubench.diagnosis.evidence import Evidence, Played
from imubench.diagnosis.report import headline, words
from imubench.diagnosis.report.numbers import rows
from imubench.diagnosis.result import Diagnosis
from imubench.log.blueprint import eye, series_view
from imubench.log.scene import Scene, log_scene
from imubench.log.signals import ESTIMATED, TIMELINE, TRUE, XYZ, log_sections, log_series
from imubench.recording import Recording
from imubench.reference import Reference
from imubench.rotations import from_axis_angle, multiply

SOURCE = "recovered motion"
GREY = (170, 170, 170)
KEEP_PEAKS = rr.components.AggregationPolicy.MinMax  # zoomed out, the mean of many samples would hide a residual


def log_diagnosis(path: Path, d: Diagnosis, evidence: Evidence, reference: Reference | None = None) -> None:
    """Write a diagnosis to `path`, a .rrd file that carries its layout; nothing is opened.

    `reference` is drawn beside the recovered hinge angle. The file appears whole or not at all.
    """
    rec = rr.RecordingStream("imubench")
    memory = rec.memory_recording()  # as in `imubench.log.run`: a file sink can wait for ever on a full disk
    with catch_and_log_exceptions("log_diagnosis", strict=True):
        _log_all(rec, d, evidence, reference)
    data = memory.drain_as_bytes()
    rec.disconnect()
    with atomic_file(Path(path)) as partial:
        partial.write_bytes(data)


def _log_all(rec: rr.RecordingStream, d: Diagnosis, evidence: Evidence, reference: Reference | None) -> None:
    rig = with_fitted_mounts(evidence)
    scene = log_scene(rec, rig, None, None, as_reference(evidence.motion), None, "")
    scene = replace(scene, source=SOURCE)
    for trace in evidence.traces:
        base = f"residual/{trace.at}/{trace.part}"
        sides = (("before", trace.whitened), ("after", trace.whitened_after))
        for side, z in sides:
            if z is not None:
                names = [f"{channel} {side}" for channel in trace.channels]
                log_series(rec, f"{base}/{side}", trace.time, z, names, XYZ[: len(names)], 1.0)
                rec.log(f"{base}/{side}", rr.SeriesLines.from_fields(aggregation_policy=KEEP_PEAKS), static=True)
    for w in d.where:
        log_sections(rec, f"windows/{w.at}", [(f"misfit at {w.at}", *window) for window in w.windows_s])
    if evidence.heldout_s:
        log_sections(rec, "windows/held_out", [("held out", *window) for window in evidence.heldout_s])
    angles = _log_angles(rec, evidence, reference)
    rec.log("summary", rr.TextDocument(summary(d, evidence), media_type="text/markdown"), static=True)
    rec.send_recording_name(f"{d.recording} diagnosed")
    rec.send_property("diagnosis", rr.AnyValues(verdict=d.verdict, rig=d.rig, name=d.recording))
    rec.send_blueprint(layout(evidence, scene, angles, bool(d.where)), make_active=True, make_default=True)


def with_fitted_mounts(evidence: Evidence) -> Recording:
    """Return the recording with its mounts where the fit has them."""
    imus = [
        replace(imu, mount_position=pose.position, mount_quaternion=pose.quaternion, mount_position_std=0.0)
        for imu in evidence.recording.imus
        if (pose := evidence.mounts[imu.name])
    ]
    return replace(evidence.recording, imus=tuple(imus))


def as_reference(motion: Played) -> Reference:
    """Return a recovered motion in the shape of a record of the segments' poses."""
    second = None
    if motion.hinge_angle is not None:
        second = multiply(motion.quaternion1, from_axis_angle([0.0, 1.0, 0.0], motion.hinge_angle))
    return Reference(motion.time, motion.hinge_angle, motion.quaternion1, second, motion.position)


def _log_angles(rec: rr.RecordingStream, evidence: Evidence, reference: Reference | None) -> bool:
    """Log the hinge angle, recovered without and with the findings, and of a reference; return if there is one."""
    first, last = evidence.motion_before, evidence.motion
    for motion, name, colour in ((first, "before", ESTIMATED), (last, "after" if first else "recovered", TRUE)):
        if motion is not None and motion.hinge_angle is not None:
            log_series(rec, f"hinge_angle/{name}", motion.time, motion.hinge_angle, [f"{name} (rad)"], [colour])
    if reference is not None and reference.hinge_angle is not None:
        seen = np.isfinite(reference.hinge_angle)
        time, angle = reference.time[seen], reference.hinge_angle[seen]
        log_series(rec, "hinge_angle/reference", time, angle, ["reference (rad)"], [GREY])
    return last.hinge_angle is not None


def layout(evidence: Evidence, scene: Scene, angles: bool, marked: bool) -> rrb.Blueprint:
    """Return the layout: rig and verdict on the left, residuals before and after on the right."""
    span = evidence.span
    plots = []
    for trace in evidence.traces:
        base, name = f"/residual/{trace.at}/{trace.part}", f"{trace.at} {trace.part}: residual over noise"
        height = max(5.0, float(np.quantile(np.abs(trace.whitened), 0.999)))  # the same for both
        one = [series_view(f"{name}, as declared", [f"{base}/before"], span, height)]
        if trace.after is not None:
            one.append(series_view(f"{name}, with the findings", [f"{base}/after"], span, height))
        plots.append(rrb.Horizontal(*one))
    shares = [1.0] * len(plots)
    if angles:
        plots.append(series_view("hinge angle (rad)", ["/hinge_angle/**"], span))
        shares.append(1.0)
    if marked or evidence.heldout_s:
        plots.append(rrb.StateTimelineView(origin="/windows", name="where most of the misfit is"))
        shares.append(0.5 + 0.35 * (marked + bool(evidence.heldout_s)))
    left = rrb.Vertical(
        rrb.Spatial3DView(
            origin=scene.frame,
            contents="/world/**",
            name=f"rig ({scene.source})",
            eye_controls=eye(scene),
            line_grid=rrb.LineGrid3D(visible=True, spacing=0.1),
        ),
        rrb.TextDocumentView(origin="/summary", name="diagnosis"),
        row_shares=[0.55, 0.45],
    )
    return rrb.Blueprint(
        rrb.Horizontal(left, rrb.Vertical(*plots, row_shares=shares), column_shares=[0.36, 0.64]),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="paused"),
    )


def summary(d: Diagnosis, evidence: Evidence) -> str:
    """Return the verdict, where and what in Markdown."""
    lines = [f"### {headline.headline(d)}", ""]
    if d.stopped:
        lines += [words.stopped(d), ""]
    if d.fitted:
        lines += [f"Misfit {d.misfit[0]:.2f} as declared, {d.misfit[1]:.2f} with the findings; 1 is only noise.", ""]
        lines += [f"- {words.location(w, evidence.span, 0.0)}" for w in d.where]
    else:
        lines += [f"- {text}" for text in headline.places(d, evidence.span, 0.0)]
    for finding in d.findings if d.fitted else ():
        lines += ["", f"**{words.title(finding)}** ({words.percent(finding.confidence)})", ""]
        body = [row for name, p in finding.parameters.items() for row in rows(name, p)]
        if body:
            lines += ["| parameter | value | 95 % interval | unit |", "|---|---|---|---|"]
            lines += [f"| {' | '.join(row)} |" for row in body]
    if scene_note := ("" if evidence.recording.poses else "Its heading and its place are arbitrary."):
        lines += ["", f"3D view: {SOURCE}. {scene_note}"]
    return "\n".join(lines)
