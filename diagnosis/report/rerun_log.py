"""A diagnosis for the Rerun viewer: the rig in 3D beside both simulations of it, their signals, what the fit leaves."""

from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from rerun.error_utils import catch_and_log_exceptions

from imubench.atomic import atomic_file
from imubench.diagnosis.evidence import Evidence
from imubench.diagnosis.report import headline, words
from imubench.diagnosis.report.ghosts import DECLARED, FOUND, SOURCE, log_rig
from imubench.diagnosis.report.numbers import rows
from imubench.diagnosis.result import Diagnosis
from imubench.log.blueprint import eye, series_view
from imubench.log.scene import Scene
from imubench.log.signals import ESTIMATED, TIMELINE, TRUE, XYZ, log_sections, log_series
from imubench.reference import Reference

LEGENDS = ("", "; green wires = simulated", "; wires: orange = as declared, green = with the findings")  # by ghosts
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
    scene = log_rig(rec, evidence, reference)
    _log_simulated(rec, evidence)
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


def _log_simulated(rec: rr.RecordingStream, evidence: Evidence) -> None:
    """Log every channel as measured, as MuJoCo plays it without and with the findings, and by how much that is off."""
    for c in evidence.simulated:
        channel = c.channel.replace(".", "/")
        sides = [(DECLARED, c.before, ESTIMATED), (FOUND, c.after, TRUE)]
        log_series(rec, f"simulated/{channel}/measured", c.time, c.measured, [f"measured ({c.unit})"], [GREY], 1.0)
        for name, values, colour in sides if len(evidence.posed) > 1 else sides[1:]:
            for root, drawn in (("simulated", values), ("off", c.measured - values)):
                path = f"{root}/{channel}/{name.replace(' ', '_')}"
                log_series(rec, path, c.time, drawn, [f"{name} ({c.unit})"], [colour], 1.0)


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
    """Return the layout: rig and verdict on the left; simulated signals and what the fit leaves on the right."""
    span = evidence.span
    residuals = _residuals(evidence)
    shares = [1.0] * len(residuals)
    if angles:
        residuals.append(series_view("hinge angle (rad)", ["/hinge_angle/**"], span))
        shares.append(1.0)
    if marked or evidence.heldout_s:
        residuals.append(rrb.StateTimelineView(origin="/windows", name="where most of the misfit is"))
        shares.append(0.5 + 0.35 * (marked + bool(evidence.heldout_s)))
    right: rrb.Container = rrb.Vertical(*residuals, row_shares=shares, name="what the motion fit leaves")
    if evidence.simulated:
        beside = rrb.Vertical(*_channels(evidence, "simulated"), name="simulated and measured")
        off = rrb.Vertical(*_channels(evidence, "off"), name="measured minus simulated")
        right = rrb.Tabs(*((beside, off) if evidence.rolled_out else (off, beside)), right, active_tab=0)
    left = rrb.Vertical(
        rrb.Spatial3DView(
            origin=scene.frame,
            contents="/world/**",
            name=f"rig ({scene.source}{LEGENDS[len(evidence.posed)]})",
            eye_controls=eye(scene),
            line_grid=rrb.LineGrid3D(visible=True, spacing=0.1),
        ),
        rrb.TextDocumentView(origin="/summary", name="diagnosis"),
        row_shares=[0.55, 0.45],
    )
    return rrb.Blueprint(
        rrb.Horizontal(left, right, column_shares=[0.36, 0.64]),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="paused"),
    )


def _residuals(evidence: Evidence) -> list[rrb.Container | rrb.View]:
    """Return the views of what the motion fit leaves of every sensor, without and with the findings side by side."""
    out: list[rrb.Container | rrb.View] = []
    for trace in evidence.traces:
        base, name = f"/residual/{trace.at}/{trace.part}", f"{trace.at} {trace.part}: residual over noise"
        height = max(5.0, float(np.quantile(np.abs(trace.whitened), 0.999)))  # the same for both
        one = [series_view(f"{name}, as declared", [f"{base}/before"], evidence.span, height)]
        if trace.after is not None:
            one.append(series_view(f"{name}, with the findings", [f"{base}/after"], evidence.span, height))
        out.append(rrb.Horizontal(*one))
    return out


def _channels(evidence: Evidence, root: str) -> list[rrb.Container | rrb.View]:
    """Return the views of what is logged of every channel below `root`, a sensor's triple side by side."""
    rows: dict[str, list[rrb.View]] = {}
    for i, c in enumerate(evidence.simulated):
        at, part = c.channel.split(".")
        view = series_view(f"{at} {part} ({c.unit})", [f"/{root}/{at}/{part}/**"], evidence.span, legend=i == 0)
        rows.setdefault(f"{at}.{part.rpartition('_')[0]}", []).append(view)
    return [rrb.Horizontal(*views) for views in rows.values()]


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
