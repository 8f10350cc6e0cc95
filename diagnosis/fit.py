"""The motion fit: Levenberg-Marquardt on splines and parameters together, noise levels estimated on the way."""

from collections.abc import Collection
from dataclasses import dataclass, field, replace

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.diagnosis.blocks import NotPositiveDefiniteError, Solution, solve_arrow
from imubench.diagnosis.equations import equation_rows
from imubench.diagnosis.hypothesis import State
from imubench.diagnosis.kinematics import ATTITUDE, FORCE, VELOCITY
from imubench.diagnosis.linear import Linear, linearise
from imubench.diagnosis.model import Model
from imubench.diagnosis.normal import Normal
from imubench.diagnosis.priors import prior_rows
from imubench.diagnosis.rows import Parameters, Rows
from imubench.diagnosis.sensor_axes import SENSOR, turns_back
from imubench.diagnosis.splines import Tracks
from imubench.diagnosis.threads import one_thread
from imubench.jets import derivatives_by

ENOUGH = 1e-4  # of the cost per measured number: a smaller gain ends the search
STEPS = 40
AGAIN = 3  # steps after every change of the noise
SETTLING = 2  # linear solves of the own splines of effects after every step,
MOVED = 0.03  # the second where the first has moved them by more than so much of their plausible size
DAMPED = 1e-8  # of the diagonal, at first: what next to nothing holds, beyond a sensor's last sample, stays where it is
LEAST, EASED = 1e-11, 3.0  # at least; by what a whole step lowers it and a shortened one raises it
LENGTHS = (1.0, 0.5, 0.2, 0.05)  # of a Gauss-Newton step, tried before it is damped


@dataclass(frozen=True)
class Fit:
    """A model, its best state, and what the noise was taken to be."""

    model: Model
    state: State
    noise: dict[str, float]  # std of each group of rows, in its unit
    cost: float
    steps: int
    anchor: Array | None = None
    loose: float = 1.0
    rows: list[Rows] = field(default_factory=list, repr=False)

    @property
    def span(self) -> tuple[float, float]:
        """First and last time of the measurements, in s on the splines."""
        return min(float(r.time.min()) for r in self.measured), max(float(r.time.max()) for r in self.measured)

    @property
    def measured(self) -> list[Rows]:
        """The rows of measurements."""
        return [r for r in self.rows if r.counts]


def all_rows(
    model: Model,
    state: State,
    noise: dict[str, float],
    anchor: Array | None,
    loose: float = 1.0,
    alone: Collection[str] = (),
) -> list[Rows]:
    """Return every row of the problem, or of all sensors some IMUs' alone; `loose` widens the measurements' noise."""
    out = [replace(r, std=r.std * noise[r.name] * loose) for r in model.measured(state, alone)]
    out += [replace(r, std=r.std * noise.get(r.name, 1.0) * loose) for r in equation_rows(model, state)]
    return out + list(prior_rows(model, state, noise, anchor))


def assemble(model: Model, rows: list[Rows]) -> tuple[Normal, list[Linear]]:
    """Return the normal equations and the rows that made them."""
    normal = Normal.empty(model.tracks, model.parameters)
    linear = [linearise(r, model.tracks, model.parameters) for r in rows]
    normal.add(linear)
    normal.fill(model.tracks)
    return normal, linear


def factored(model: Model, rows: list[Rows]) -> tuple[Normal, Solution, list[Linear]]:
    """Return the normal equations, their band gone into the factored ones beside them, and the rows that made them."""
    normal, linear = assemble(model, rows)
    return normal, solve_arrow(normal.band, normal.border, normal.corner), linear


def step(model: Model, rows: list[Rows], damping: float) -> tuple[Array, Array]:
    """Return the damped Gauss-Newton step: splines (blocks, b) and parameters (p,)."""
    normal = assemble(model, rows)[0]
    normal.damp(damping)
    corner = normal.corner + damping * np.diag(np.diag(normal.corner))
    solution = solve_arrow(normal.band, normal.border, corner)
    x, values = solution.solve(-normal.gradient[:, :, None], -normal.corner_gradient[:, None])
    return x[:, :, 0], values[:, 0]


def moved(model: Model, state: State, x: Array, values: Array) -> State:
    """Return a state moved by x (blocks, b) and `values` (p,); segment 1 turns back as its sensor's mount turns.

    In splines of the segment's attitude and force a turn of the mount by 0.03 rad would leave errors of second order
    that gyroscopes see, and steps would be cut to hundredths.
    """
    count, width = state.coefficients.shape
    change = x.reshape(-1, width)[:count]
    parameters, tracks = model.parameters, model.tracks
    new = {name: value + values[parameters.columns(name)] for name, value in state.values.items()}
    coefficients = state.coefficients + change
    if SENSOR in model.mounts and ATTITUDE in tracks.widths:
        back, slope = turns_back(model, state.values, new)
        own = tracks.columns(ATTITUDE)
        q = state.coefficients[:, own]
        straight = coefficients[:, own] - rotations.multiply(q, np.concatenate([[0.0], slope / 2]))
        coefficients[:, own] = rotations.multiply(straight, rotations.from_matrix(back))
        for name in tracks.widths.keys() & {FORCE, VELOCITY}:
            own = tracks.columns(name)
            coefficients[:, own] = (coefficients[:, own] + np.cross(slope, state.coefficients[:, own])) @ back
    return State(coefficients, new)


def settled(model: Model, state: State, noise: dict[str, float], anchor: Array | None, loose: float) -> State:
    """Return the state with the effects' own splines solved for everything else as it is.

    A spring's law is tight and nearly linear in what hangs on it, but not in both it and the spring's constants:
    without this a step in a frequency breaks the law and is taken back.
    """
    own = {h.key(s.name): s.width for h in model.hypotheses for s in h.effect.states}
    if not own:
        return state
    only = Tracks(model.tracks.knots, own)
    size = np.concatenate([np.full(s.width, s.std) for h in model.hypotheses for s in h.effect.states])
    places = {h.at for h in model.hypotheses if h.effect.states}
    alone = places if places <= {imu.name for imu in model.recording.imus} else ()  # a joint's states move all sensors
    for _ in range(SETTLING):
        with derivatives_by(own):
            rows = [r for r in all_rows(model, state, noise, anchor, loose, alone) if r.residual.blocks]
        normal = Normal.empty(only, Parameters({}))
        normal.add([linearise(r, only, Parameters({})) for r in rows])
        normal.fill(only, DAMPED)
        change = normal.band.factor().solve(-normal.gradient[:, :, None]).reshape(-1, only.width)
        state = shifted(model, state, only, change)
        if np.max(np.abs(change) / size) < MOVED:
            break
    return state


def shifted(model: Model, state: State, only: Tracks, change: Array) -> State:
    """Return a state with some of its splines moved by `change` (knots or more, width of `only`)."""
    coefficients = state.coefficients.copy()
    for name in only.widths:
        coefficients[:, model.tracks.columns(name)] += change[: only.knots.count, only.columns(name)]
    return replace(state, coefficients=coefficients)


def at_noise_of(fit: Fit, other: Fit) -> Fit:
    """Return a fit solved again at the noise levels of one with more in its model, to be compared with that."""
    return solve(fit.model, fit.state, {n: other.noise[n] for n in fit.noise}, fit.anchor, steps=AGAIN)


@one_thread
def solve(
    model: Model,
    state: State,
    noise: dict[str, float],
    anchor: Array | None = None,
    loose: float = 1.0,
    steps: int = STEPS,
    enough: float = ENOUGH,
) -> Fit:
    """Return the state of least cost, from `state`."""
    taken, damping = 0, DAMPED
    rows = all_rows(model, state, noise, anchor, loose)
    cost = sum(r.cost for r in rows)
    count = sum(r.residual.value.size for r in rows if r.counts)
    while taken < steps:
        taken += 1
        before = cost
        while damping < 1e3:
            try:
                x, values = step(model, rows, damping)
            except NotPositiveDefiniteError:
                damping *= 10
                continue
            for length in LENGTHS:
                trial = moved(model, state, length * x, length * values)
                trial = settled(model, trial, noise, anchor, loose)
                trial_rows = all_rows(model, trial, noise, anchor, loose)
                trial_cost = sum(r.cost for r in trial_rows)
                if trial_cost < cost:
                    break
            else:
                damping *= 100
                continue
            state, rows, cost = trial, trial_rows, trial_cost
            damping = max(damping / EASED, LEAST) if length == LENGTHS[0] else damping * EASED
            break
        if before - cost < enough * count:
            break
    return Fit(model, state, noise, cost, taken, anchor, loose, rows)
