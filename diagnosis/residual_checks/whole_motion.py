"""The motion of a fit that saw filtered samples, up to both ends of the recording.

Samples at a lower rate begin where a filter has all that it takes (`noise.decimation`). Before the first and after the
last of them the recording's own say how the rig moved. The motion is carried on by half of a spline's support at a
time: ten times as far ahead what a spline foretells has turned by radians, and no step leads back from there.
"""

from dataclasses import replace

import numpy as np

from imubench.diagnosis.config.solve import SOLVER
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.bspline import DEGREE, SUPPORT, Knots, Tracks
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import State
from imubench.diagnosis.samples.sample_faults import UNIT_OF_PART
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.diagnosis.windows import Window
from imubench.recording import Recording, span_of


def to_the_ends(fit: Fit, recording: Recording) -> Fit:
    """Return a fit with the motion that all of a recording shows, its numbers and noise levels as they are.

    Args:
        fit: of the recording, or of fewer samples of it.
        recording: as it came.
    """
    if not fit.model.averaging.shares:
        return fit
    whole, seen = span_of(recording), span_of(replace(fit.model.recording, encoders=(), poses=()))
    lost, step = max(seen[0] - whole[0], whole[1] - seen[1]), SUPPORT / 2 * fit.model.tracks.knots.step
    for reach in step * np.arange(1, np.ceil(lost / step) + 1):
        span = max(seen[0] - reach, whole[0]), min(seen[1] + reach, whole[1])
        fit = on_longer_knots(fit, (span[0] - step, span[1] + step))
        found = solve(beyond(fit, recording, span), fit.state, fit.noise, fit.anchor, steps=SOLVER.steps)
        fit = replace(fit, state=found.state)
    return fit


def reach_of(fit: Fit) -> Window:
    """Return from when to when, in s of the recording's clock, a fit's knots reach."""
    knots = fit.model.tracks.knots
    first = fit.model.start + knots.start
    return first, first + (knots.count - DEGREE) * knots.step


def on_longer_knots(fit: Fit, span: Window) -> Fit:
    """Return a fit, not solved again, whose knots reach at least over a `span`, s."""
    model, knots, own = fit.model, fit.model.tracks.knots, reach_of(fit)
    before, after = (max(int(np.ceil(by / knots.step)), 0) for by in (own[0] - span[0], span[1] - own[1]))
    longer = Knots(knots.start - before * knots.step, knots.step, knots.count + before + after)
    coefficients = np.pad(fit.state.coefficients, ((before, after), (0, 0)), mode="edge")
    model = replace(model, tracks=Tracks(longer, model.tracks.widths))
    return replace(fit, model=model, state=State(coefficients, fit.state.values))


def beyond(fit: Fit, recording: Recording, span: Window) -> Model:
    """Return the model of a fit, its numbers held, which also sees a recording's own samples as far as `span`, s."""
    model = fit.model
    louder, masks, imus = dict(model.louder or {}), dict(model.masks or {}), []
    for own in model.recording.imus:
        whole = recording.imu(own.name)
        before = (whole.time < own.time[0]) & (whole.time >= span[0])
        after = (whole.time > own.time[-1]) & (whole.time <= span[1])
        time, gyro, accel = (
            np.concatenate([getattr(whole, key)[before], getattr(own, key), getattr(whole, key)[after]])
            for key in ("time", "gyro", "accel")
        )
        imus.append(replace(own, time=time, gyro=gyro, accel=accel))
        sides = (int(before.sum()), int(after.sum()))
        for name in (f"{own.name}.{part}" for part in UNIT_OF_PART):
            known = louder.get(name, np.ones(own.time.size))
            louder[name] = np.pad(known, sides, constant_values=1 / model.averaging.share(name))
            if name in masks:
                masks[name] = np.pad(masks[name], sides, constant_values=True)
    seen = replace(model.recording, imus=tuple(imus))
    return replace(model, recording=seen, louder=louder, masks=masks or None, fixed=dict(fit.state.values))


__all__ = ["to_the_ends"]
