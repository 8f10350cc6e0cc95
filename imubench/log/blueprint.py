"""How a run is laid out in the Rerun viewer: the rig and the verdict on the left, time series on the right."""

from collections.abc import Collection, Sequence

import numpy as np
import rerun.blueprint as rrb

from imubench.log.scene import Scene
from imubench.log.signals import TIMELINE, within_time

VIEW_FROM = (0.65, 0.5, 0.45)  # along what the eye should face, across it and up
DISTANCE = 2.6  # between eye and target, in halves of the rig


LEGEND = {"true": "green = {judge}", "estimated": "orange = estimated"}
PLOTS = {  # what may be shown -> (title, contents)
    "angle": ("hinge angle (rad)", ["/joint/angle", "/encoder/**", "/reference/hinge_angle"]),
    "constraint": ("hinge constraint |ω₁×j₁| − |ω₂×j₂| (rad/s)", ["/joint/constraint/**"]),
    "error/angle": ("angle error of the estimate (deg)", ["/error/angle/**"]),
    "error/length": ("length of the error of the estimated r (m)", ["/error/length/**"]),
}


def run_blueprint(
    imus: Sequence[str], shown: Collection[str], scene: Scene, judge: str, span: tuple[float, float]
) -> rrb.Blueprint:
    """Return the layout for a run with these IMUs and what is `shown`: keys of `PLOTS` and `LEGEND`, "sections".

    `judge` is the word for what is true, `span` the first and last time in s.
    """
    rows = [
        rrb.Horizontal(*[series_view(f"{i}: {title} ({unit})", [f"/{i}/{what}"], span) for i in imus])
        for what, title, unit in (("gyro", "angular rate", "rad/s"), ("accel", "specific force", "m/s²"))
        if imus
    ]
    plots = [series_view(title, contents, span) for key, (title, contents) in PLOTS.items() if key in shown]
    rows += [rrb.Horizontal(*plots[k : k + 2]) for k in range(0, len(plots), 2)]
    shares = [1.0] * len(rows)
    if "sections" in shown:
        rows.append(rrb.StateTimelineView(origin="/sections", name="sections of the motion"))
        shares.append(0.45)
    legend = ", ".join(text.format(judge=judge) for key, text in LEGEND.items() if key in shown)
    left = rrb.Vertical(
        rrb.Spatial3DView(
            origin=scene.frame,
            contents="/world/**",
            name=f"rig ({scene.source}){': ' if legend else ''}{legend}",
            eye_controls=eye(scene),
            line_grid=rrb.LineGrid3D(visible=True, spacing=0.1),
        ),
        rrb.TextDocumentView(origin="/summary", name="summary"),
        row_shares=[0.62, 0.38],
    )
    return rrb.Blueprint(
        rrb.Horizontal(left, rrb.Vertical(*rows, row_shares=shares), column_shares=[0.42, 0.58]) if rows else left,
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="paused"),
    )


def series_view(
    name: str, contents: Sequence[str], span: tuple[float, float], height: float | None = None, legend: bool = True
) -> rrb.TimeSeriesView:
    """Return a plot of these paths over all of `span`, in s, from -`height` to `height` or as they need.

    Without `legend` names show only where the pointer is, as beside another plot of the same colours.

    A span of no length, that of a single sample, is made a second long.
    """
    first, last = within_time(span)
    margin = 0.5 if not last > first else 0.0
    start, end = (rrb.TimeRangeBoundary.absolute(seconds=edge) for edge in (first - margin, last + margin))
    return rrb.TimeSeriesView(
        origin="/",
        contents=list(contents),
        name=name,
        plot_legend=rrb.PlotLegend("RightTop", visible=legend),
        axis_y=None if height is None else rrb.ScalarAxis(range=(-height, height)),
        axis_x=rrb.TimeAxis(view_range=rrb.TimeRange(start=start, end=end)),  # by itself a minute at most shows
    )


def eye(scene: Scene) -> rrb.EyeControls3D:
    """Return a camera that sees the whole rig from the side it faces."""
    flat, up = np.array([*scene.facing[:2], 0.0]), np.array([0.0, 0.0, 1.0])
    ahead = flat / np.linalg.norm(flat) if np.linalg.norm(flat) > 0.1 else np.array([0.0, 1.0, 0.0])
    direction = VIEW_FROM[0] * ahead + VIEW_FROM[1] * np.cross(ahead, up) + VIEW_FROM[2] * up
    return rrb.EyeControls3D(
        kind=rrb.Eye3DKind.Orbital,
        position=scene.middle + DISTANCE * scene.reach * direction,
        look_target=scene.middle,
        eye_up=up,
    )
