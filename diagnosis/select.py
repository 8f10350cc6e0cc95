"""Which effects the fit needs: score all, refit the best few exactly, keep what predicts, drop what it does without."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from imubench.diagnosis.fit import Fit, solve
from imubench.diagnosis.heldout import Gain, Held, gain, held_out
from imubench.diagnosis.model import Hypothesis, Model
from imubench.diagnosis.noise import fit_with_noise
from imubench.diagnosis.refit import extended, guess_of, log_evidence, refit
from imubench.diagnosis.score import Score, score
from imubench.effects import EFFECTS

MOST = 5  # effects in one diagnosis
TRIED = 3  # of the best scores, refitted exactly in each round
NEAR = 0.1  # of the best promise: a score below is not worth a refit
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
    recording = model.recording
    places = {
        "imu": [i.name for i in recording.imus],
        "joint": ["joint"] if recording.rig != "free" else [],
        "body": ["body"] if recording.free_swings else [],
        "world": ["world"],
    }
    return [
        Hypothesis(e, at)
        for e in EFFECTS.values()
        if recording.rig in e.rigs and e.parameters + e.states
        for at in places[e.place]
    ]


def trials(fit: Fit, scores: list[Score], stateful: list[Hypothesis], say: Callable[[str], None]) -> list[Trial]:
    """Return exact refits of the most promising hypotheses, best evidence first."""
    best = max((s.evidence for s in scores), default=0.0)
    chosen = [s for s in scores if s.evidence > max(NEEDED, NEAR * best)][:TRIED]
    base = log_evidence(fit)
    out = []
    for h, guess in [(s.hypothesis, guess_of(s.hypothesis, s.estimate)) for s in chosen] + [(h, {}) for h in stateful]:
        say(f"refitting with {h.name}")
        tried = refit(fit, (*fit.model.hypotheses, h), guess)
        out.append(Trial(h, tried, fit.cost - tried.cost, log_evidence(tried) - base))
    return sorted(out, key=lambda t: -t.evidence)


def select(nominal: Fit, say: Callable[[str], None] = lambda _: None) -> Selection:
    """Return the effects that the recording needs."""
    fit, kept, rejected = nominal, [], []
    first: tuple[Score, ...] = ()
    before = start = held_out(nominal)
    rng = np.random.default_rng(SEED)
    everything = candidates(nominal.model)
    while len(kept) < MOST:
        say("scoring every effect")
        left = [h for h in everything if h not in fit.model.hypotheses]
        scores = score(fit, [h for h in left if not h.effect.states])
        first = first or tuple(scores)
        tried = trials(fit, scores, [h for h in left if h.effect.states], say)
        if not tried or tried[0].evidence < NEEDED:
            break
        best = tried[0]
        say(f"predicting held-out data with {best.hypothesis.name}")
        better = fit_with_noise(best.fit.model, best.fit.state, best.fit.noise, fit.anchor, rounds=3)
        ruler = solve(fit.model, fit.state, {n: better.noise[n] for n in fit.noise}, fit.anchor, steps=3)
        after = held_out(better)
        won = gain(held_out(ruler), after, rng)
        if won.low <= 0:
            rejected.append((best.hypothesis, won.value))
            break
        kept.append(Kept(best.hypothesis, best.evidence, won, tuple(tried[1:])))
        fit, before = better, after
    fit, kept, dropped = prune(fit, kept, say)
    first_at_end = solve(
        nominal.model, nominal.state, {n: fit.noise[n] for n in nominal.noise}, nominal.anchor, steps=3
    )
    start = held_out(first_at_end) if kept else start
    return Selection(nominal, fit, tuple(kept), (*rejected, *dropped), first, start, held_out(fit) if kept else start)


def prune(
    fit: Fit, kept: list[Kept], say: Callable[[str], None]
) -> tuple[Fit, list[Kept], list[tuple[Hypothesis, float]]]:
    """Return the fit without the effects that it no longer needs, weakest first."""
    dropped: list[tuple[Hypothesis, float]] = []
    while len(kept) > 1:
        base = log_evidence(fit)
        losses = []
        for k in kept:
            say(f"trying to do without {k.hypothesis.name}")
            rest = tuple(h for h in fit.model.hypotheses if h != k.hypothesis)
            without = extended(fit, rest)
            without = solve(without.model, without.state, without.noise, fit.anchor, steps=4)
            losses.append((base - log_evidence(without), k, without))
        loss, k, without = min(losses, key=lambda x: x[0])
        kept = [replace(k, evidence=loss) for loss, k, _ in losses]
        if loss > NEEDED:
            return fit, kept, dropped
        dropped.append((k.hypothesis, loss))
        kept = [other for other in kept if other.hypothesis != k.hypothesis]
        fit = fit_with_noise(without.model, without.state, without.noise, fit.anchor, rounds=2)
    return fit, kept, dropped
