"""A diagnosis that is told the effects of its case, and only has to see them.

Each is fitted exactly, the best first, beside those that are in already; it is found where its evidence asks for it by
the diagnosis' own threshold. A fault of the samples is found where the raw checks see it, a louder noise where the fit
leaves more than a declared level may be off. What the oracle misses the data do not show, or no fit of ours; what it
finds and the diagnosis misses is the search's.
"""

from collections.abc import Callable, Iterator

from imubench.diagnosis.candidates.begin import Beginning
from imubench.diagnosis.candidates.grids import placed_at_best_start
from imubench.diagnosis.config.shared import DECLARED_NOISE, EVIDENCE
from imubench.diagnosis.criteria.score_test import score
from imubench.diagnosis.criteria.trial import Trial
from imubench.diagnosis.noise.declared_noise import declared
from imubench.diagnosis.noise.noise_levels import levels
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.residual_checks.excess_noise import louder_noise
from imubench.diagnosis.result import Diagnosis, Finding
from imubench.diagnosis.search.moves.add import plain_trials
from imubench.diagnosis.search.moves.add_dynamic import state_trials
from imubench.diagnosis.search.moves.dynamic_order import ANYWAY
from imubench.diagnosis.search.selected import candidates
from imubench.diagnosis.solve.refit import information
from imubench.diagnosis.solve.schur import Base
from imubench.diagnosis.verdict.effect_parameters import parameters
from imubench.trials.baselines import NO_GAIN, SURE, answer
from imubench.trials.match import inside
from imubench.trials.seal import Truth

Places = set[tuple[str, str]]
"""Effects, each with its place."""


def oracle(start: Beginning, truth: Truth) -> Diagnosis:
    """Return which of a case's own effects are found."""
    told = {(e["effect"], e["at"]) for e in (truth["effects"][i] for i in inside(truth))}
    samples = (*start.samples.findings, *start.samples.unless_stopped)
    read_off = [f for f in samples if (f.effect, f.at) in told]
    told -= {(f.effect, f.at) for f in read_off}
    fit = fitted(start.fit, told)
    _, std = information(fit)
    held = [h for h in fit.model.hypotheses if (h.effect.name, h.at) in told]
    found = [Finding(h.effect.name, h.at, SURE, parameters(h, fit, std), NO_GAIN) for h in held]
    return answer(fit.model.recording.rig, [*found, *read_off, *noises(fit, told)])


def fitted(fit: Fit, told: Places) -> Fit:
    """Return the fit with those of the effects that evidence asks for, the best first."""
    left = [h for h in candidates(fit.model) if (h.effect.name, h.at) in told]
    while left:
        tried = [t for t in trials(fit, left) if t.evidence > EVIDENCE.needed_nat]
        if not tried:
            break
        best = max(tried, key=lambda t: t.evidence)
        fit = with_noise(best.fit)
        left = [h for h in left if (h.effect.name, h.at) != (best.hypothesis.effect.name, best.hypothesis.at)]
    return fit


def trials(fit: Fit, told: list[Hypothesis], say: Callable[[str], None] = lambda _: None) -> list[Trial]:
    """Return exact refits with one more of some effects."""
    plain, lively = ([h for h in told if bool(h.effect.states) == states] for states in (False, True))
    base = Base.of(fit)
    at_start, judged = placed_at_best_start(base, plain)
    return [*plain_trials(fit, [*score(fit, at_start, base), *judged], say), *state_trials(fit, lively, say, ANYWAY)]


def noises(fit: Fit, told: Places) -> Iterator[Finding]:
    """Yield the louder noises among the effects that the fit leaves."""
    usual = declared(fit.model)
    found, leverage = levels(fit)
    for name in (r.name for r in fit.measured if r.name in usual):
        at, part = name.split(".")
        if (f"{part}_noise", at) in told and (found[name] / usual[name]) ** 2 > DECLARED_NOISE.most_power:
            yield louder_noise(name, found[name], leverage[name])
