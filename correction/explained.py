"""The motion behind a recording, fitted anew with exactly the effects that a diagnosis names, at its numbers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.diagnosis.config.noise import REML
from imubench.diagnosis.config.solve import SOLVER
from imubench.diagnosis.criteria.conditional_aic import aic_gain_of, tally
from imubench.diagnosis.criteria.effect_dynamics import driven_by_motion
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.reml import fit_with_noise
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.problem.process_factors import state_rows
from imubench.diagnosis.result import Finding
from imubench.diagnosis.samples.screening import check_samples
from imubench.diagnosis.search.moves.dynamic_refits import calm_for_laws
from imubench.diagnosis.solve.gauss_newton import extended
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.diagnosis.solve.refit import log_evidence
from imubench.diagnosis.solve.threads import one_thread
from imubench.effects import VARIANTS
from imubench.effects.effect import Effect
from imubench.errors import InputError
from imubench.jets import Jet
from imubench.recording import Recording


@dataclass(frozen=True)
class StartedEffect:
    """An effect as a diagnosis tells it: where a fit starts, and what of it is held."""

    hypothesis: Hypothesis
    start: dict[str, Array]  # parameter (k,), in the fit's variable
    held: dict[str, Array]  # all of them, or none where the law needs numbers that a diagnosis does not tell

    @property
    def values(self) -> dict[str, Jet]:
        """The diagnosed parameters (1, k), as laws take them."""
        h, out = self.hypothesis, {}
        for p in (p for p in h.effect.parameters if h.key(p.name) in self.start):
            x = self.start[h.key(p.name)]
            out[p.name] = Jet((np.exp(x) if p.log else x)[None])
        return out


def started_effects(finding: Finding, recording: Recording) -> tuple[StartedEffect, ...]:
    """Return a finding as effects of a fit: one for each setting (the channels of a filter) that it leaves open.

    None where the effect is one of single samples. Raises `InputError` for an effect that does not exist, that this
    recording cannot have, or whose parameters are not those of its law.
    """
    where = f"finding {finding.effect} at {finding.at}"
    named = [e for e in VARIANTS if e.name == finding.effect]
    if not named:
        raise InputError(f"{where}: expected an effect of `imubench list`, got none of that name")
    if finding.at not in Effect.places(named[0], recording):
        places = ", ".join(Effect.places(named[0], recording)) or "no place"
        raise InputError(f"{where}: expected {places} in {recording.name} on rig {recording.rig}, got {finding.at}")
    fitted = [e for e in named if e.parameters or e.states]
    shapes = {name: p.value.shape for name, p in finding.parameters.items()}
    out = [_started(e, finding) for e in fitted if _shapes(e).items() <= shapes.items()]
    if fitted and not out:
        known, got = (
            ", ".join(f"{name} {shape}" for name, shape in all_.items()) for all_ in (_shapes(fitted[0]), shapes)
        )
        raise InputError(f"{where}: expected the parameters {known}, got {got or 'none'}")
    return tuple(out)


def _shapes(effect: Effect) -> dict[str, tuple[int, ...]]:
    return {p.name: p.shape for p in effect.parameters if p.reported}


def _started(effect: Effect, finding: Finding) -> StartedEffect:
    h = Hypothesis(effect, finding.at)
    start = {}
    for p in (p for p in effect.parameters if p.reported):
        value = finding.parameters[p.name].value.reshape(-1)
        start[h.key(p.name)] = np.log(np.maximum(value, 1e-9)) if p.log else value
    whole = all(p.reported for p in effect.parameters)
    if not whole:
        h = replace(h, effect=effect.starting(**{name: finding.parameters[name].value for name in _shapes(effect)}))
    return StartedEffect(h, start, start if whole else {})


def explained_fit(recording: Recording, findings: Sequence[Sequence[StartedEffect]]) -> Fit:
    """Return the fit of a recording's motion with these effects, their diagnosed numbers held.

    Of each finding one setting is taken, that of the best evidence. Samples that are no measurement (clipped,
    repeated, knocked, those of a slip) do not count.
    """
    samples = check_samples(recording)
    nominal = nominal_fit(samples.heard(recording), samples.masks, samples.humming, samples.wander)
    best = refitted(nominal, [settings[0] for settings in findings])
    for i, settings in enumerate(findings):
        for other in settings[1:]:
            tried = refitted(nominal, [other if j == i else s[0] for j, s in enumerate(findings)])
            best = max(best, tried, key=log_evidence)
    return best


@one_thread
def refitted(nominal: Fit, effects: Sequence[StartedEffect]) -> Fit:
    """Return the fit with effects, begun where their laws put their states.

    The noise of the sensors is estimated, that of a law is at its floor: estimated too, it may let go of the law. A
    spring's law multiplies what lies beyond the motion, so the motion is as rough as it was estimated to be, or as
    loose as the nominal fit has it: whichever predicts the samples better. A quick hand on foam needs the second.
    """
    step = nominal.model.tracks.knots.step
    starts = {k: v for t in effects for k, v in as_fitted(t, t.start, step).items()}
    begun = extended(nominal, tuple(t.hypothesis for t in effects), starts)
    masks = dict(begun.model.masks or {})
    for t in (t for t in effects if t.hypothesis.effect.place == "imu"):
        counts = ~off_its_law(t, begun.model)
        for name in (f"{t.hypothesis.at}.gyro", f"{t.hypothesis.at}.accel"):
            masks[name] = masks.get(name, counts) & counts
    held = {k: v for t in effects for k, v in as_fitted(t, t.held, step).items()}
    model, state, noise = replace(begun.model, fixed=held, masks=masks), begun.state, dict(begun.noise)
    lawful = [t.hypothesis for t in effects if t.hypothesis.effect.states and t.hypothesis.effect.lawful]
    fit = solve(
        model,
        driven_by_motion(model, state, lawful),
        calm_for_laws(begun, lawful),
        nominal.anchor,
        steps=SOLVER.refit_steps,
    )
    noise |= {rows.name: REML.law_floor for rows in state_rows(model, fit.state)}
    rough = {name: noise[name] for name in (f"smooth.{track}" for track in model.rig.widths) if name in noise}
    only = {rows.name for rows in fit.measured}

    def levelled(loosened: float) -> Fit:
        levels = noise | {name: std * loosened for name, std in rough.items()}
        return fit_with_noise(model, fit.state, levels, nominal.anchor, rounds=REML.last_rounds, only=only)

    tight = levelled(1 / REML.loosened)
    if not lawful:
        return tight
    loose = levelled(1.0)
    return loose if aic_gain_of(tight.noise, tally(tight), loose.noise, tally(loose)) > 0 else tight


def as_fitted(t: StartedEffect, told: Mapping[str, Array], step: float) -> dict[str, Array]:
    """Return parameters (k,) of an effect, by their names in a fit, as a fit with knots `step` s apart has its law."""
    h = t.hypothesis
    named = {p.name: told[h.key(p.name)] for p in h.effect.parameters if h.key(p.name) in told}
    return {h.key(name): value for name, value in h.effect.collocated(named, step).items()} if named else {}


def off_its_law(t: StartedEffect, model: Model) -> NDArray[np.bool_]:
    """Return the samples (n,) of an effect's sensor in which it moves as its law does not say."""
    time = next(i.time for i in model.recording.imus if i.name == t.hypothesis.at) - model.start
    out = np.zeros(time.size, dtype=bool)
    if t.held:
        for start, end in t.hypothesis.effect.blind({name: x.value[0] for name, x in t.values.items()}):
            out |= (time >= start) & (time <= end)
    return out
