"""How large the noise really is: each group's level by restricted maximum likelihood.

A fit with as many freedoms as samples leaves residuals smaller than the noise. With the leverage h of
each row (the diagonal of the hat matrix), s^2 = sum r^2 / (n - sum h) is unbiased; the same rule gives the
roughness of the motion from the rows that hold it smooth.
"""

from collections.abc import Collection
from dataclasses import replace
from weakref import WeakKeyDictionary

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.noise.debias import lawful, tilts
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.dynamics_factors import GROUP, is_data
from imubench.diagnosis.problem.hypothesis import Prior, State
from imubench.diagnosis.samples.check_findings import OFF
from imubench.diagnosis.solve.bordered import Solution
from imubench.diagnosis.solve.gauss_newton import Step, factored
from imubench.diagnosis.solve.levenberg_marquardt import AGAIN, ENOUGH, Fit, search
from imubench.diagnosis.solve.linearize import Linear
from imubench.diagnosis.solve.marginals import Spread
from imubench.diagnosis.solve.threads import MOST_KNOTS, one_thread
from imubench.recording import Recording

FLOOR = 1 - OFF  # of the declared level
LAW_FLOOR = 0.05  # of its std: a law that held without any noise would hold the fit still; what is below stays there
LAW_RISE = 4.0  # times its level of the round before, at most
SMALLEST = 1e-7  # of a unit: no group is taken for exact
ROUNDS = 3
LAST = 5  # rounds at most once the motion is free: a quick one settles late
LOOSENED = 32.0  # times its estimate: what a clean recording needs to leave nothing that goes with the motion
FAR, FASTER = 0.3, 0.5  # a relative change of a level, above which so much of it is added
SAME = 0.05  # relative change of every level, and of a law's numbers, that ends the rounds
FAINT = 1e-6  # damping of the diagonal, that leverages do not show
FINE = 3e-6  # the solver's `enough` where a law's damping is sought: it changes the cost by next to nothing

Levels = tuple[dict[str, float], dict[str, Array]]
_known: WeakKeyDictionary[Fit, Levels] = WeakKeyDictionary()
ALLOWED = (1 + OFF) ** 2 * 1.2 * 1.3  # of the declared noise power: with 20 % of colour, 30 % for rough motion


@one_thread
def levels(fit: Fit) -> Levels:
    """Return the noise level of every group that `fit.noise` names, and the leverage of its rows and of all data.

    Not to be written to: of a fit that is not too long they are kept as long as it is. Ten refits are held against one.
    """
    if fit in _known:
        return _known[fit]
    _, solution, parts = factored(fit.model, fit.rows)
    found = _levels(fit, solution, parts, fit.noise.keys() | {r.name for r in fit.rows if is_data(r)})
    if fit.model.tracks.knots.count <= MOST_KNOTS:
        _known[fit] = found
    return found


def _estimated(fit: Fit, step: Step | None, names: Collection[str]) -> tuple[dict[str, float], dict[str, Prior]]:
    """Return the noise levels of some groups and how laws lean, without the matrices that these are read off.

    `step` led to the fit, where one did: its equations are as good as the fit's own, but for how laws lean.
    """
    if step and step.damping < FAINT and not lawful(fit):
        return _levels(fit, step.solution, step.linear, names)[0], {}
    normal, solution, parts = factored(fit.model, fit.rows)
    return _levels(fit, solution, parts, names)[0], tilts(fit, normal, solution, parts)


def _levels(fit: Fit, solution: Solution, parts: list[Linear], names: Collection[str]) -> Levels:
    chosen = [(rows, part) for rows, part in zip(fit.rows, parts, strict=True) if rows.name in names]
    covariance = Spread.of(solution, fit.model.tracks.width)
    out, hats = {}, {}
    for (rows, _), hat in zip(chosen, covariance.leverages([part for _, part in chosen]), strict=True):
        hats[rows.name] = hat
        if rows.name in fit.noise:
            free = max(rows.residual.value.size - float(hat.sum()), 1.0)
            out[rows.name] = max(fit.noise[rows.name] * fit.loose * np.sqrt(2 * rows.cost / free), SMALLEST)
    return out, hats


def declared(model: Model) -> dict[str, float]:
    """Return the noise levels that a model's recording declares, by group."""
    return declared_by(model.recording)


def declared_by(recording: Recording) -> dict[str, float]:
    """Return the noise levels that a recording declares, by group."""
    out: dict[str, float | None] = {}
    for imu in recording.imus:
        out |= {f"{imu.name}.gyro": imu.gyro_noise_std, f"{imu.name}.accel": imu.accel_noise_std}
    for encoder in recording.encoders:
        out["encoder.angle"] = encoder.angle_noise_std
    for i, pose in enumerate(recording.poses):
        out |= {f"pose{i + 1}.position": pose.position_noise_std, f"pose{i + 1}.rotation": pose.rotation_noise_std}
    return {name: std for name, std in out.items() if std}


def with_noise(fit: Fit, rounds: int = ROUNDS, held: Collection[str] = ()) -> Fit:
    """Return a fit with the noise levels that it leaves, those of some groups `held`."""
    only = fit.noise.keys() - held if held else None
    return fit_with_noise(fit.model, fit.state, fit.noise, fit.anchor, rounds, only=only)


def with_settled_noise(fit: Fit) -> Fit:
    """Return the fit, its noise levels estimated once more where a sensor's is far from what it leaves.

    Levels are estimated beside what the model holds then; what came in last may explain what a level was raised for,
    and a level that stays too high is reported as a loud sensor.
    """
    found, told = levels(fit)[0], declared(fit.model)
    off = [np.log(max(found[n], FLOOR * std) / fit.noise[n]) for n, std in told.items() if n in found]
    return with_noise(fit, 2 * ROUNDS) if max(np.abs(off), default=0.0) > FAR else fit


@one_thread
def fit_with_noise(
    model: Model,
    state: State,
    noise: dict[str, float],
    anchor: Array | None,
    rounds: int = ROUNDS,
    motion: bool = False,
    only: Collection[str] | None = None,
) -> Fit:
    """Return the fit in which every group's noise level is its own estimate, at least near the declared one.

    The motion's roughness is estimated with `motion`, once, and then loosened: one roughness for rests and strokes
    alike would pull the strokes smooth, and what it takes from them would look like a mismatch. `only` names the
    groups whose level is estimated, where not all are. A law that takes in all that a sensor reads would leave that
    exact, and every number with it: no sensor's level goes below `model.least`.
    """
    floor = dict(model.least) | {name: FLOOR * std for name, std in declared(model).items()}
    laws = {n for n in noise if "@" in n and not n.startswith("smooth.")}
    floor |= {name: min(LAW_FLOOR, noise[name]) for name in laws}
    slow = laws | declared(model).keys()
    floor[GROUP] = LAW_FLOOR
    ruled = {f"smooth.{h.key(s.name)}" for h in model.hypotheses if h.effect.lawful for s in h.effect.states}
    rough = {name for name in noise if name.startswith("smooth.") and "@" not in name}
    named = {n for n in noise if n not in ruled and (only is None or n in only)}
    plan = [(motion, False)] * rounds + ([(True, True)] + [(False, False)] * LAST) * motion
    now = search(model, state, noise, anchor, steps=4)
    for free, last in plan:
        asked = named if free else named - rough
        fit, step = now[0], None if lawful(now[0]) else now[1]
        del now  # with the equations of a step that nobody asks for: memory
        found, leaning = _estimated(fit, step, asked)
        new = noise | {n: max(found.get(n, noise[n]), floor.get(n, 0.0)) for n in asked}
        # far off they fall slowly, as a free state gives way bit by bit
        for name in slow & new.keys() if only is None else ():
            ratio = new[name] / noise[name]
            if abs(np.log(ratio)) > FAR:
                new[name] = max(new[name] * ratio**FASTER, floor[name])
        # a law that is doubted before the motion has followed it is soon no law at all
        new |= {name: min(new[name], LAW_RISE * noise[name]) for name in laws & new.keys()}
        if last:
            new |= {name: LOOSENED * new[name] for name in rough}
        change = max(abs(np.log(new[name] / noise[name])) for name in noise)
        model = replace(model, tilts=leaning)
        noise, begun = new, fit.state
        del fit, step  # with its rows: memory
        now = search(model, begun, noise, anchor, steps=AGAIN, enough=FINE if model.tilts else ENOUGH)
        after, before = now[0].state.values, begun.values
        change = max([change, *(float(np.max(np.abs(after[n] - before[n]))) for n in model.tilts or {})])
        if change < SAME and now[0].steps < AGAIN and not free:
            break
    return replace(now[0], noise=noise)
