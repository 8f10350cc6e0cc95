"""A fit at the noise levels that it leaves: each group's own estimate, at least near the declared one."""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.noise import REML
from imubench.diagnosis.config.shared import DECLARED_NOISE
from imubench.diagnosis.config.solve import ALGEBRA, SOLVER
from imubench.diagnosis.noise.debias import law_parameters, noise_pull
from imubench.diagnosis.noise.declared_noise import declared
from imubench.diagnosis.noise.noise_levels import levels, levels_of
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Prior, State
from imubench.diagnosis.problem.residuals import SWING_EQUATION
from imubench.diagnosis.remembered import remembered
from imubench.diagnosis.solve.gauss_newton import Step, factored
from imubench.diagnosis.solve.levenberg_marquardt import search
from imubench.diagnosis.solve.threads import one_thread


def _estimated(
    fit: Fit, step: Step | None, names: Collection[str], share: float
) -> tuple[dict[str, float], dict[str, Prior]]:
    """Return the noise levels of some groups and how laws lean, without the matrices that these are read off.

    Of the pull on a law's numbers a share is taken.

    `step` led to the fit, where one did: its equations are as good as the fit's own, but for how laws lean.
    """
    if step and step.damping < REML.faint_damping and not law_parameters(fit):
        return levels_of(fit, step.solution, step.linear, names)[0], {}
    normal, solution, parts = factored(fit.model, fit.rows)
    return levels_of(fit, solution, parts, names)[0], noise_pull(fit, normal, solution, parts, share=share)


def with_noise(fit: Fit, rounds: int = REML.rounds, held: Collection[str] = ()) -> Fit:
    """Return a fit with the noise levels that it leaves, those of some groups `held`."""
    only = fit.noise.keys() - held if held else None
    return fit_with_noise(fit.model, fit.state, fit.noise, fit.anchor, rounds, only=only)


def with_settled_noise(fit: Fit) -> Fit:
    """Return the fit, its noise levels estimated once more where a sensor's is far from what it leaves.

    Levels are estimated beside what the model holds then; what came in last may explain what a level was raised for,
    and a level that stays too high is reported as a loud sensor.
    """
    found, told = levels(fit)[0], declared(fit.model)
    off = [
        np.log(max(found[n], DECLARED_NOISE.least_std * std) / fit.noise[n]) for n, std in told.items() if n in found
    ]
    return with_noise(fit, 2 * REML.rounds) if max(np.abs(off), default=0.0) > REML.far else fit


@remembered
@one_thread
def fit_with_noise(
    model: Model,
    state: State,
    noise: dict[str, float],
    anchor: Array | None,
    rounds: int = REML.rounds,
    motion: bool = False,
    only: Collection[str] | None = None,
) -> Fit:
    """Return the fit in which every group's noise level is its own estimate, at least near the declared one.

    The motion's roughness is estimated with `motion`, once, and then loosened: one roughness for rests and strokes
    alike would pull the strokes smooth, and what it takes from them would look like a mismatch. `only` names the
    groups whose level is estimated, where not all are. A law that takes in all that a sensor reads would leave that
    exact, and every number with it: no sensor's level goes below `model.least`.
    """
    floor = dict(model.least) | {name: DECLARED_NOISE.least_std * std for name, std in declared(model).items()}
    laws = {n for n in noise if "@" in n and not n.startswith("smooth.")}
    floor |= {name: min(REML.law_floor, noise[name]) for name in laws}
    slow = laws | declared(model).keys()
    floor[SWING_EQUATION] = REML.law_floor
    ruled = {f"smooth.{h.key(s.name)}" for h in model.hypotheses if h.effect.lawful for s in h.effect.states}
    rough = {name for name in noise if name.startswith("smooth.") and "@" not in name}
    named = {n for n in noise if n not in ruled and (only is None or n in only)}
    plan = [(motion, False)] * rounds + ([(True, True)] + [(False, False)] * REML.last_rounds) * motion
    now = search(model, state, noise, anchor, steps=4)
    share, moved = 1.0, np.zeros(1)  # a pull that turns back leads beyond: it is halved, as in `debiased_fit.settled`
    for free, last in plan:
        asked = named if free else named - rough
        fit, step = now[0], None if law_parameters(now[0]) else now[1]
        del now  # with the equations of a step that nobody asks for: memory
        found, leaning = _estimated(fit, step, asked, share)
        new = noise | {n: max(found.get(n, noise[n]), floor.get(n, 0.0)) for n in asked}
        # far off they fall slowly, as a free state gives way bit by bit
        for name in slow & new.keys() if only is None else ():
            ratio = new[name] / noise[name]
            if abs(np.log(ratio)) > REML.far:
                new[name] = max(new[name] * ratio**REML.faster, floor[name])
        # a law that is doubted before the motion has followed it is soon no law at all
        new |= {name: min(new[name], REML.law_rise * noise[name]) for name in laws & new.keys()}
        if last:
            new |= {name: REML.loosened * new[name] for name in rough}
        change = max(abs(np.log(new[name] / noise[name])) for name in noise)
        model = replace(model, tilts=leaning)
        noise, begun = new, fit.state
        del step  # memory
        if model.tracks.knots.count > ALGEBRA.knots_beside:
            del fit  # with its rows, of which the search would take those that hold: memory
        now = search(
            model,
            begun,
            noise,
            anchor,
            steps=SOLVER.few_steps,
            enough=SOLVER.fine_gain if model.tilts else SOLVER.least_gain,
        )
        after, before = now[0].state.values, begun.values
        move = np.concatenate([np.zeros(1), *(after[n] - before[n] for n in model.tilts or {})])
        share, moved = share / 2 if move.size == moved.size and move @ moved < 0 else share, move
        change = max(change, float(np.max(np.abs(move))))
        if change < REML.settled and now[0].steps < SOLVER.few_steps and not free:
            break
    return now[0]
