"""What a fit holds to be plausible before it sees a measurement, as rows."""

from collections.abc import Iterable, Iterator

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.solve import MOTION_PRIOR
from imubench.diagnosis.problem.batch_model import Model, inside, middles, sampled
from imubench.diagnosis.problem.bspline import Moment
from imubench.diagnosis.problem.hypothesis import Hypothesis, State
from imubench.diagnosis.problem.residuals import Rows
from imubench.diagnosis.problem.rig_kinematics import ATTITUDE, FORCE, HINGE, POSITION, VELOCITY
from imubench.diagnosis.problem.sensor_axes import sensor_turn, turned
from imubench.jets import CONSTANT, Jet, cross, dot, variable

TILT = "tilt."
PRIORS = ("prior.", TILT, "smooth.", "norm", "heading", "drift", "pace", "size.")
"""How the names of rows begin that are priors: neither measurements nor laws."""
WHITE_DERIVATIVE = {FORCE: 2}  # order of the derivative that is taken for white:


def states_inside(model: Model, state: State, h: Hypothesis) -> dict[str, Array]:
    """Return an effect's states (n, width) in the middle of every interval that has samples."""
    moment = Moment(model.tracks, state.coefficients, Jet(inside(model)[:, None]))
    return {s.name: moment.track(h.key(s.name)).value for s in h.effect.states}


def is_prior(rows: Rows) -> bool:
    """Return whether rows are a prior's: what they hold may change with the noise levels."""
    return not rows.counts and rows.name.startswith(PRIORS)


def prior_rows(model: Model, state: State, noise: dict[str, float], anchor: Array | None) -> Iterator[Rows]:
    """Yield the rows of every prior: parameters, smoothness, norm, heading, a pace that stays within bounds.

    `anchor` (4,) is the first attitude of the start. `noise` has each spline's roughness under "smooth.NAME".
    """
    for name, prior in model.priors.items():
        jet = variable((name, CONSTANT), state.values[name]) - prior.start
        yield Rows(f"prior.{name}", np.zeros(1), jet, prior.std, counts=False)
    for name, tilt in (model.tilts or {}).items():
        if name in model.priors and name not in (model.fixed or {}):
            jet = variable((name, CONSTANT), state.values[name]) - tilt.start
            yield Rows(f"{TILT}{name}", np.zeros(1), jet, tilt.std, counts=False)
    yield from smooth_rows(model, state, noise, [name for name in model.tracks.widths if name != VELOCITY])
    time = middles(model)
    moment = Moment(model.tracks, state.coefficients, Jet(time[:, None]))
    if ATTITUDE in model.tracks.widths:
        q = moment.track(ATTITUDE)
        yield Rows("norm", time, off_one(dot(q, q)), np.full(1, MOTION_PRIOR.norm_std), False)
        if anchor is not None:
            first = Moment(model.tracks, state.coefficients, Jet(time[:1, None])).track(ATTITUDE)
            w, x, y, z = anchor
            yield Rows(
                "heading",
                time[:1],
                dot(first, np.array([-z, -y, x, w])),
                np.full(1, MOTION_PRIOR.heading_half_rad),
                False,
            )
    yield from pace_rows(model, state)
    yield from size_rows(model, state)


def size_rows(model: Model, state: State) -> Iterator[Rows]:
    """Yield the rows that hold the states of effects to a plausible size."""
    time, step = middles(model), model.tracks.knots.step
    moment = Moment(model.tracks, state.coefficients, Jet(time[:, None]))
    for h in model.hypotheses:
        for s in h.effect.states:
            name = h.key(s.name)
            yield Rows(f"size.{name}", time, moment.track(name), np.full(s.width, s.std / np.sqrt(step)), False)


def quadrature(model: Model) -> tuple[Array, Array]:
    """Return times (n,) s and weights (n,), in intervals between knots, at which roughness is summed over time.

    The middle of an interval stands for all of it, but for those that are not wholly between the first and the last
    sample, which have the two points of Gauss's rule. A spline whose second derivative vanishes in every middle may
    grow 22-fold from one interval to the next, and nothing else holds it where no samples are.
    """
    middle, step, (first, last) = middles(model), model.tracks.knots.step, sampled(model)
    between = (middle - step / 2 >= first) & (middle + step / 2 <= last)
    aside = step / np.sqrt(12.0)
    time = np.concatenate([middle[between], middle[~between] - aside, middle[~between] + aside])
    weights = np.concatenate([np.ones(between.sum()), np.full(2 * (~between).sum(), 0.5)])
    order = np.argsort(time)
    return time[order], weights[order]


def smooth_rows(model: Model, state: State, noise: dict[str, float], names: Iterable[str]) -> Iterator[Rows]:
    """Yield the rows that hold some splines as smooth as `noise` says."""
    (time, weights), step = quadrature(model), model.tracks.knots.step
    moment = Moment(model.tracks, state.coefficients, Jet(time[:, None]))
    sensor = sensor_turn(model.rig, model.mounts, state.values)
    jumpy = {h.key(s.name) for h in model.hypotheses for s in h.effect.states if s.jumps}
    for name in names:
        density = np.full(model.tracks.widths[name], noise[f"smooth.{name}"] / np.sqrt(step))
        curved = moment.track(name, WHITE_DERIVATIVE.get(name, MOTION_PRIOR.white_derivative))
        curved = curved * np.sqrt(weights)[:, None]
        if name == FORCE:
            curved = sensor.back(curved)
        elif name == ATTITUDE:
            curved = turned(curved, sensor)
        elif name in jumpy:
            curved = heavy_tailed(curved, density)
        yield Rows(f"smooth.{name}", time, curved, density, False)


def off_one(square: Jet) -> Jet:
    """Return sinh(log n) (n, 1) of squares n of a quaternion's norm: n - 1 where it is near one, endless at nought.

    Through nought an attitude turns over between two samples, which no sample sees.
    """
    n = square.value
    return square.through((n - 1 / n) / 2, (1 + n**-2) / 2)


def heavy_tailed(x: Jet, std: Array) -> Jet:
    """Return x (n, m) as a residual of normal errors whose cost is that of errors of Cauchy's: log(1 + (x / std)^2).

    What rests on one side and falls to the other is smooth but for moments. One roughness for both would let a joint's
    play follow noise at rest and round its falls.
    """
    u = x.value / std
    cost = np.log1p(u * u)
    root = np.sign(u) * np.sqrt(2 * cost)
    straight = np.full_like(u, np.sqrt(2.0))  # at nought
    return x.through(root * std, np.divide(2 * u / (1 + u * u), root, out=straight, where=root != 0.0))


def pace_rows(model: Model, state: State) -> Iterator[Rows]:
    """Yield the rows that keep the pace of a joint centre that nobody measured within bounds, where there is one."""
    if VELOCITY in model.tracks.widths:
        time = middles(model)
        moment = Moment(model.tracks, state.coefficients, Jet(time[:, None]))
        base, sensor = model.rig.first(moment, model.gravity(state)), sensor_turn(model.rig, model.mounts, state.values)
        assert base.turn is not None
        velocity = moment.track(VELOCITY)
        gravity = base.turn.back(model.gravity(state))
        drift = moment.track(VELOCITY, 1) + cross(base.rate, velocity) - base.force - gravity
        yield Rows("drift", time, sensor.back(drift), np.full(3, MOTION_PRIOR.centre_drift_m_s2), False)
        pace = np.full(3, MOTION_PRIOR.centre_m_s / np.sqrt(model.tracks.knots.step))
        yield Rows("pace", time, sensor.back(velocity), pace, False)


START_SMOOTH = {
    ATTITUDE: 300.0,
    POSITION: 300.0,
    FORCE: 300.0,
    HINGE: 300.0,
}  # per s^4 (s^2) and root Hz, a first guess
