"""A stop that is met too seldom for its knocks to tell: the equation of a free swing fails for moments, and only then.

Between two contacts a limb swings as its equation says; in one, hundredths of a second long, it is pushed back. Of 80
swings without a stop the equation failed nowhere by more than 12 times what it does in the median, and by 78 to 216
times at three stops. What the spline cannot follow there it makes up for beside it, so contacts are looked for
once more in a fit that does not ask the equation of them.

What the equation lacks, summed over a contact, is the push J. About a hinge's axis it goes against the side of the
stop. A pendulum's stop pushes along the gradient of its swing by a rotation, (e - z_e z) / (1 - z_e^2), z the limb's
axis, e the level axis of the swing: so J has nothing along z, and e is the level axis in the plane of J and z, to some
degrees (two contacts with one stop differed by 7). Where several axes agree as well, the contacts are the farthest that
the limb goes about one of them, and as far one as the other: that axis counts.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.candidates.end_stop import Stop, angle_at, in_world, left_out, limb_at, swing_of
from imubench.diagnosis.config.candidates import CONTACT, END_STOP
from imubench.diagnosis.config.samples import HIGH_BAND
from imubench.diagnosis.config.solve import SWING
from imubench.diagnosis.problem.dynamics_factors import missing_torque
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.residuals import equation_of
from imubench.diagnosis.problem.rig_kinematics import HINGE_AXIS
from imubench.diagnosis.windows import Window, covered, cut_out
from imubench.recording import Body

AXES_TRIED_RAD = np.linspace(-CONTACT.astray_rad, CONTACT.astray_rad, 71)  # rad beside it, that are tried


def contact_stop(fit: Fit, swings: Sequence[Window], again: Callable[[tuple[Window, ...]], Fit]) -> Stop | None:
    """Return the stop that a limb meets in free swings, told from its equation; None where nothing looks like one.

    `again` is the nominal fit with other free swings than its recording's `swings`.
    """
    body, found = fit.model.recording.body, np.array([])
    if body is None or not (fit.model.rig.hinge or fit.model.rig.ball):
        return None
    more = failures(fit)
    for _ in range(CONTACT.rounds):
        if not more.size:
            break
        found = np.sort(np.concatenate([found, more]))
        fit = again(beside(swings, found))
        more = failures(fit)
    if not found.size or more.size:
        return None
    return stop_from(fit, body, contacts(found, fit), swings)


def failures(fit: Fit) -> Array:
    """Return when (s) the equation fails by far more than elsewhere, each the worst within `CONTACT.smeared_s`."""
    rows = equation_of(fit.rows)
    if rows is None:
        return np.array([])
    size = np.linalg.norm(rows.residual.value / rows.std, axis=1)
    least, out = CONTACT.fails * float(np.median(size)), []
    while size.max() > least:
        out.append(rows.time[int(np.argmax(size))])
        size[np.abs(rows.time - out[-1]) < CONTACT.smeared_s] = 0.0
    return np.array(out) + fit.model.start


def beside(swings: Sequence[Window], times: Array) -> tuple[Window, ...]:
    """Return free swings without `CONTACT.half_s` a second on either side of some times."""
    return cut_out(swings, [(t - CONTACT.half_s, t + CONTACT.half_s) for t in times])


def contacts(times: Array, fit: Fit) -> list[Window]:
    """Return the stretches in s, of the splines, in which the equation was not asked about contacts at some times."""
    pad = CONTACT.half_s + SWING.jump_knots * fit.model.tracks.knots.step
    first = [0, *(i + 1 for i, (a, b) in enumerate(pairwise(times)) if b - a > HIGH_BAND.one_knock_s), len(times)]
    groups = [times[a:b] - fit.model.start for a, b in pairwise(first)]
    return [(float(g[0]) - pad, float(g[-1]) + pad) for g in groups]


def stop_from(fit: Fit, body: Body, met: Sequence[Window], swings: Sequence[Window]) -> Stop | None:
    """Return the stop that is met in some stretches (s of the splines), where it is one."""
    hinge, fine = fit.model.rig.hinge, np.arange(*fit.span, END_STOP.grid_s)
    free = covered(fine + fit.model.start, swings)
    touching = covered(fine, met)
    inside = [np.flatnonzero(covered(fine, [window])) for window in met]
    limb = None if hinge else limb_at(fit, fine)
    least, found = np.inf, None
    as_good = float(np.ptp(AXES_TRIED_RAD)) / (len(AXES_TRIED_RAD) - 1) / 2  # the nearest to the pushes comes first
    for side, heading in ways(fit, body, met):
        away = side * (angle_at(fit, fine) if limb is None else swing_of(limb, heading))
        deepest = np.array([some[np.argmax(away[some])] for some in inside])
        beyond = float(away[free & ~touching].max(initial=-np.inf)) - float(away[deepest].min())
        off = float(np.ptp(away[deepest])) + max(beyond, 0.0)
        if off < least - as_good:
            least, found = off, (side, heading, away, deepest)
    if found is None or least > CONTACT.one_angle_rad:
        return None
    side, heading, away, deepest = found
    angle = float(np.median(away[deepest]))
    windows = left_out(fine + fit.model.start, touching | (free & (away > angle - END_STOP.same_rad)))
    stop = Stop(
        side * angle,
        END_STOP.same_rad,
        fine[deepest] + fit.model.start,
        windows,
        heading,
        END_STOP.least_std_rad if hinge else CONTACT.least_std_rad,
    )
    return stop if hinge or angle > 0 else None


def ways(fit: Fit, body: Body, met: Sequence[Window]) -> list[tuple[float, float]]:
    """Return on which side, 1 or -1, a stop is that pushes so, and about which headings in rad, the likeliest first.

    None where the pushes are not those of one stop.
    """
    pushes = [pushed(fit, body, window) for window in met]
    if fit.model.rig.hinge:
        sides = {-float(np.sign(push[HINGE_AXIS])) for push, _ in pushes}
        return [(side, 0.0) for side in sides] if len(sides) == 1 else []
    axes = [a for a in (level_axis(*push) for push in pushes) if a is not None]
    if len(axes) < len(pushes):
        return []
    headings = np.array([np.arctan2(-a[0], a[1]) for a in axes])
    sizes = np.array([np.linalg.norm(push) for push, _ in pushes])
    middle = float(np.angle(np.sum(sizes * np.exp(1j * headings))))
    astray = np.abs(np.angle(np.exp(1j * (headings - middle))))
    return [(1.0, middle + off) for off in sorted(AXES_TRIED_RAD, key=abs)] if astray.max() < CONTACT.astray_rad else []


def pushed(fit: Fit, body: Body, window: Window) -> tuple[Array, Array]:
    """Return the push (3,) N m s in a stretch (s of the splines) and the limb's axis (3,) where it is hardest.

    A hinge's in its segment's axes, a pendulum's in the world's.
    """
    time = np.arange(*window, END_STOP.grid_s / 2)
    missing = missing_torque(fit.model, fit.state, body, time)
    worst = int(np.argmax(np.linalg.norm(missing.value, axis=1)))
    if fit.model.rig.hinge:
        return missing.value.sum(axis=0) * END_STOP.grid_s / 2, np.array([0.0, 0.0, 1.0])
    push = in_world(fit, time, missing.value).sum(axis=0) * END_STOP.grid_s / 2
    return push, limb_at(fit, time[[worst]])[:, 0]


def level_axis(push: Array, limb: Array) -> Array | None:
    """Return the level axis (3,) about which a push (3,) drives a limb's axis (3,) back; None where a stop's would not.

    A limb beyond the stop is at an angle above 0 about it.
    """
    size = float(np.linalg.norm(push))
    if min(abs(float(push @ limb)), abs(float(push[2]))) > CONTACT.along * size or abs(limb[2]) < CONTACT.along:
        return None
    level = push - push[2] / limb[2] * limb
    return np.asarray(-level / np.linalg.norm(level))


__all__ = ["contact_stop", "contacts", "failures", "level_axis"]
