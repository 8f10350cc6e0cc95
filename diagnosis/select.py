"""Which effects the fit needs: score all, refit the best few exactly, keep what predicts, drop what it does without."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from imubench.diagnosis.blocks import NotPositiveDefiniteError
from imubench.diagnosis.coherence import follows_motion
from imubench.diagnosis.fit import Fit, solve
from imubench.diagnosis.heldout import Gain, Held, gain, held_out
from imubench.diagnosis.model import Hypothesis, Model
from imubench.diagnosis.noise import declared, fit_with_noise
from imubench.diagnosis.refit import extended, guess_of, log_evidence, refit
from imubench.diagnosis.score import Score, score
from imubench.effects import possible

MOST = 5  # effects in one diagnosis
TRIED = 3  # of the best scores, refitted exactly in each round
NEAR = 0.1  # of the best promise: a score below is not worth a refit
UNEXPLAINED = 1.4  # misfit above which a sensor's own motion is tried too; a declared noise explains up to 1.6
RELATED = 3.0  # of follows_motion, from which they are tried as well; clean recordings stay below 2
NEEDED = 5.0  # nat of evidence before an effect is looked at on held-out data: odds of 150 for some 60 candidates
SEED = 20201  # of the bootstrap, so that a diagnosis repeats itself


@dataclass(frozen=True)
class Trial:
    """A refit with one effect more, and what it gained on the data it was fitted to."""

    hypothesis: Hypothesis
    fit: Fit
    gain: float  # nat
    evidence: float  # nat


@dataclass(frozen=True)
class Kept:
    """An effect that stays."""

    hypothesis: Hypothesis
    evidence: float  # nat, over the model without it
    heldout: Gain
    rivals: tuple[Trial, ...]  # refitted in its round, in its place


@dataclass(frozen=True)
class Selection:
    """What was found, and the fits before and after."""

    nominal: Fit
    fit: Fit
    kept: tuple[Kept, ...]
    rejected: tuple[tuple[Hypothesis, float], ...]  # nat on held-out data, or of evidence where that was enough
    scores: tuple[Score, ...]  # of the nominal fit
    before: Held
    after: Held


def candidates(model: Model) -> list[Hypothesis]:
    """Return every effect at every place of a recording where it could act."""
    return [Hypothesis(effect, at) for effect, at in possible(model.recording) if effect.parameters or effect.states]


def plain_trials(fit: Fit, scores: list[Score], say: Callable[[str], None]) -> list[Trial]:
    """Return exact refits of the best scores, best evidence first."""
    best = max((s.evidence for s in scores), default=0.0)
    chosen = [s for s in scores if s.evidence > max(NEEDED, NEAR * best)][:TRIED]
    base = log_evidence(fit)
    out = []
    for s in chosen:
        say(f"refitting with {s.hypothesis.name}")
        tried = refit(fit, (*fit.model.hypotheses, s.hypothesis), guess_of(s.hypothesis, s.estimate))
        out.append(Trial(s.hypothesis, tried, fit.cost - tried.cost, log_evidence(tried) - base))
    return sorted(out, key=lambda t: -t.evidence)


def state_trials(fit: Fit, stateful: list[Hypothesis], say: Callable[[str], None]) -> list[Trial]:
    """Return refits with effects that have a life of their own, noise levels estimated anew, best evidence first."""
    out = []
    for h in stateful:
        say(f"refitting with {h.name}")
        begun = extended(fit, (*fit.model.hypotheses, h))
        try:
            tried = solve(begun.model, begun.state, calm(begun), fit.anchor, steps=4)
            tried = fit_with_noise(tried.model, tried.state, tried.noise, fit.anchor, rounds=1)
            same = solve(fit.model, fit.state, {n: tried.noise[n] for n in fit.noise}, fit.anchor, steps=3)
        except NotPositiveDefiniteError:
            continue
        out.append(Trial(h, tried, same.cost - tried.cost, log_evidence(tried) - log_evidence(same)))
    return sorted(out, key=lambda t: -t.evidence)


def calm(fit: Fit) -> dict[str, float]:
    """Return noise levels to begin a spring's fit with: ten times the declared, so that its law outweighs a misfit."""
    told = declared(fit.model)
    return {name: 10 * told[name] if name in told else std for name, std in fit.noise.items()}


def misfit(fit: Fit) -> float:
    """Return the mean over the sensors of noise power left over noise power declared; 1 where none is declared."""
    told = declared(fit.model)
    return float(np.mean([(fit.noise[n] / std) ** 2 for n, std in told.items() if n in fit.noise] or [1.0]))


def select(nominal: Fit, say: Callable[[str], None] = lambda _: None) -> Selection:
    """Return the effects that the recording needs."""
    fit, rejected = nominal, []
    kept = [Kept(h, np.inf, Gain(0.0, 0.0, 0.0, np.zeros(1)), ()) for h in nominal.model.hypotheses]
    first: tuple[Score, ...] = ()
    start = held_out(nominal)
    rng = np.random.default_rng(SEED)
    everything = candidates(nominal.model)
    while len(kept) < MOST:
        say("scoring every effect")
        taken = {h.name for h in fit.model.hypotheses}
        left = [h for h in everything if h.name not in taken]
        scores = score(fit, [h for h in left if not h.effect.states])
        first = first or tuple(scores)
        tried = [t for t in plain_trials(fit, scores, say) if t.evidence > NEEDED]
        better = with_noise(tried[0]) if tried else fit
        if misfit(better) > UNEXPLAINED or max(follows_motion(better).values(), default=0.0) > RELATED:
            lively = state_trials(fit, [h for h in left if h.effect.states and not h.effect.variant], say)
            lively = [t for t in lively if t.evidence > NEEDED]
            if lively and (not tried or misfit(lively[0].fit) < misfit(better)):
                tried, better = lively + tried, with_noise(lively[0])
        if not tried:
            break
        best = tried[0]
        say(f"predicting held-out data with {best.hypothesis.name}")
        ruler = solve(fit.model, fit.state, {n: better.noise[n] for n in fit.noise}, fit.anchor, steps=3)
        after = held_out(better)
        won = gain(held_out(ruler), after, rng)
        if won.low <= 0:
            rejected.append((best.hypothesis, won.value))
            break
        kept.append(Kept(best.hypothesis, best.evidence, won, tuple(tried[1:])))
        fit = better
    fit, kept, dropped = prune(fit, kept, say)
    first_at_end = solve(
        nominal.model, nominal.state, {n: fit.noise[n] for n in nominal.noise}, nominal.anchor, steps=3
    )
    start = held_out(first_at_end) if kept else start
    return Selection(nominal, fit, tuple(kept), (*rejected, *dropped), first, start, held_out(fit) if kept else start)


def with_noise(trial: Trial) -> Fit:
    """Return a trial's fit with the noise levels that it leaves."""
    fit = trial.fit
    return fit_with_noise(fit.model, fit.state, fit.noise, fit.anchor, rounds=3)


def prune(
    fit: Fit, kept: list[Kept], say: Callable[[str], None]
) -> tuple[Fit, list[Kept], list[tuple[Hypothesis, float]]]:
    """Return the fit without the effects that it no longer needs, weakest first."""
    dropped: list[tuple[Hypothesis, float]] = []
    while kept:
        base = log_evidence(fit)
        losses = []
        for k in kept:
            say(f"trying to do without {k.hypothesis.name}")
            rest = tuple(h for h in fit.model.hypotheses if h != k.hypothesis)
            without = extended(fit, rest)
            without = solve(without.model, without.state, without.noise, fit.anchor, steps=4)
            losses.append((base - log_evidence(without), k, without))
        loss, k, without = min(losses, key=lambda x: x[0])
        kept = [_judged(replace(k, evidence=loss), without, fit) for loss, k, without in losses]
        if loss > NEEDED:
            return fit, kept, dropped
        dropped.append((k.hypothesis, loss))
        kept = [other for other in kept if other.hypothesis != k.hypothesis]
        fit = fit_with_noise(without.model, without.state, without.noise, fit.anchor, rounds=2)
    return fit, kept, dropped


def _judged(kept: Kept, without: Fit, fit: Fit) -> Kept:
    """Return an effect that was in the model from the start with what it gains on held-out data."""
    if kept.heldout.value or kept.evidence < NEEDED:
        return kept
    return replace(kept, heldout=gain(held_out(without), held_out(fit), np.random.default_rng(SEED)))
