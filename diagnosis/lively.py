"""Effects that have a life of their own: screened by their laws, tried on a part, fitted to the whole."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from imubench.diagnosis.blocks import NotPositiveDefiniteError
from imubench.diagnosis.equations import state_rows
from imubench.diagnosis.excerpt import excerpt, loudest
from imubench.diagnosis.fit import Fit, all_rows, settled, solve
from imubench.diagnosis.model import Hypothesis
from imubench.diagnosis.noise import declared, fit_with_noise
from imubench.diagnosis.refit import extended
from imubench.diagnosis.screen import Screened, led, screen
from imubench.diagnosis.trial import NEEDED, SCREENED, TRIED, Trial
from imubench.diagnosis.worth import worth

ROUNDS = 3  # of their noise estimation
MORE = 2  # rounds for the best of them on the whole recording
DOUBTED, LEFT = 4.0, 0.05  # times a law's std, and of what drives it, that may be left; beyond, its state is a spline
IMPLAUSIBLE = 4.0  # of its prior's standard deviations, on every axis
RIVALS = 0.3  # of the best one's promise: a state effect below is not worth a refit


def state_trials(fit: Fit, stateful: list[Hypothesis], say: Callable[[str], None]) -> list[Trial]:
    """Return refits with effects that have a life of their own, best evidence first; none where none is needed.

    They are screened and tried on the seconds that leave most unexplained; only the best is fitted to all, first in
    the list. What the others gained there is scaled to the length of the whole.
    """
    window = loudest(fit, SCREENED)
    whole = window == fit.span
    short = fit if whole else excerpt(fit, *window)
    short = fit_with_noise(short.model, short.state, short.noise, short.anchor, rounds=2)  # as what it is held against
    say("screening effects with states")
    screened = [s for s in screen(short, stateful) if s.evidence > NEEDED]
    tried: list[tuple[Trial, list[Screened]]] = []
    likely = [s for s in screened if s.evidence > RIVALS * screened[0].evidence][:TRIED]
    for one in likely:
        say(f"refitting with {one.hypothesis.name}")
        with suppress(NotPositiveDefiniteError):
            tried.append((_lively(short, [one]), [one]))
    worth_it = {t.hypothesis.name for t, _ in tried if t.evidence > NEEDED}
    both = [p for p in pairs(likely) if worth_it & {s.hypothesis.name for s in p}]  # one alone is worth something too
    tried += _paired(short, tried, both, say)
    tried = sorted((t for t in tried if t[0].evidence > NEEDED and resolved(t[0])), key=lambda t: -t[0].evidence)
    if not tried:
        return []
    (best, some), *others = tried
    if whole:
        return [_against(fit, [best.hypothesis, *best.also], best.fit), *(t for t, _ in others)]
    say(f"refitting with {best.hypothesis.name} on the whole recording")
    ways: list[Trial] = []
    with suppress(NotPositiveDefiniteError):
        ways.append(_grown(fit, best))
    if not ways or ways[0].evidence < best.evidence:
        with suppress(NotPositiveDefiniteError):
            ways.append(_lively(fit, some, rounds=ROUNDS + MORE))
    if not ways:
        return []
    grown = max(ways, key=lambda t: t.evidence)
    if not resolved(grown):
        return []
    scale = grown.evidence / best.evidence
    rest = [replace(t, evidence=t.evidence * scale) for t, _ in others if scale > 0]
    return [grown, *rest]


def _paired(
    short: Fit, single: list[tuple[Trial, list[Screened]]], both: list[list[Screened]], say: Callable[[str], None]
) -> list[tuple[Trial, list[Screened]]]:
    """Return the best refit with two, begun where one of them alone had come to, or as both were screened.

    One way is enough where something else alone explains more than that, and none is needed where the better one of
    them leaves nothing that the other would explain.
    """
    out: list[tuple[Trial, list[Screened]]] = []
    for some in both:
        if not _left_for_two(single, some):
            continue
        say(f"refitting with {' and '.join(s.hypothesis.name for s in some)}")
        alone = {t.hypothesis.name: t for t, _ in single}
        names = {s.hypothesis.name for s in some}
        rival = max((t.evidence for name, t in alone.items() if name not in names), default=-np.inf)
        ways = [(alone[a.hypothesis.name], b) for a, b in (some, some[::-1]) if a.hypothesis.name in alone]
        for way in (*ways, None):
            with suppress(NotPositiveDefiniteError):
                out.append((_lively(short, some) if way is None else _joined(short, *way), some))
                if out[-1][0].evidence < rival:
                    break
    return sorted(out, key=lambda t: -t[0].evidence)[:1]


def _left_for_two(single: list[tuple[Trial, list[Screened]]], some: list[Screened]) -> bool:
    """Return whether a screening beside the better one of two promises anything of the other."""
    names = [s.hypothesis for s in some]
    best = max((t for t, _ in single if t.hypothesis in names), key=lambda t: t.evidence)
    return any(s.evidence > NEEDED for s in screen(best.fit, [h for h in names if h != best.hypothesis]))


def resolved(trial: Trial) -> bool:
    """Return whether every law holds, with plausible numbers, and a rate in Hz that its sensor's samples can show."""
    fit, rates = trial.fit, {imu.name: imu.rate for imu in trial.fit.model.recording.imus}
    found = (trial.hypothesis, *trial.also)
    for h in found:
        for p in [p for p in h.effect.parameters if p.log]:
            value = fit.state.values[h.key(p.name)]
            if p.unit == "Hz" and h.at in rates and float(np.exp(value).min()) > rates[h.at]:
                return False  # not on any axis
            if np.all(np.abs(value - p.centre) > IMPLAUSIBLE * p.std):
                return False
    return all(left < max(DOUBTED, LEFT * drive) for left, drive in laws(fit, found))


def laws(fit: Fit, hypotheses: Sequence[Hypothesis]) -> list[tuple[float, float]]:
    """Return what is left of each law of some effects, and what drives it (were their states at rest), in its stds.

    Foam is no linear spring: its law leaves several stds, which is little of what rocks an IMU on it.
    """
    own = [h.key(s.name) for h in hypotheses for s in h.effect.states]
    still = fit.state.coefficients.copy()
    for name in own:
        still[:, fit.model.tracks.columns(name)] = 0.0
    rest = replace(fit.state, coefficients=still)
    rows = [r for h in hypotheses for r in state_rows(fit.model, rest, h)]
    return [(fit.noise[r.name], float(np.sqrt(np.mean(r.whitened**2)))) for r in rows if r.name in fit.noise]


def pairs(screened: list[Screened]) -> list[list[Screened]]:
    """Return the best two where they are of one kind at both sensors: one alone would have to stand for both."""
    of_sensors = [s for s in screened if s.hypothesis.at in ("imu1", "imu2")]
    if not of_sensors:
        return []
    best = of_sensors[0].hypothesis
    same = [s for s in of_sensors if s.hypothesis.at != best.at and s.hypothesis.effect.name == best.effect.name]
    return [[of_sensors[0], same[0]]] if same else []


def _lively(fit: Fit, some: list[Screened], rounds: int = ROUNDS) -> Trial:
    """Return the refit with state effects, begun as their laws say and where a law outweighs the measurements.

    From the screening's stiff and damped starts: the motion of a fit that knows no spring holds the spring's own, and
    a law already tuned to it would answer with a resonance.
    """
    hypotheses = [s.hypothesis for s in some]
    guess = {name: value for s in some for name, value in s.values.items()}
    begun = extended(fit, (*fit.model.hypotheses, *hypotheses), guess)
    noise = dict(begun.noise)
    for s in some:
        noise |= s.noise
    start = _calm_for_laws(replace(begun, noise=noise), hypotheses)
    tried = solve(begun.model, led(begun.model, begun.state, hypotheses), start, fit.anchor, steps=4)
    tried = fit_with_noise(tried.model, tried.state, tried.noise, fit.anchor, rounds=rounds)
    return _against(fit, hypotheses, tried)


def _joined(fit: Fit, alone: Trial, other: Screened) -> Trial:
    """Return the refit with a second state effect, begun where the first alone had come to."""
    h, found = other.hypothesis, alone.fit
    guess = {name: value for name, value in found.state.values.items() if name not in fit.model.priors}
    begun = extended(found, (*found.model.hypotheses, h), guess | dict(other.values))
    noise = begun.noise | found.noise | other.noise
    tried = solve(begun.model, led(begun.model, begun.state, [h]), noise, fit.anchor, steps=4)
    tried = fit_with_noise(tried.model, tried.state, tried.noise, fit.anchor, rounds=ROUNDS)
    return _against(fit, [alone.hypothesis, h], tried)


def _grown(fit: Fit, trial: Trial) -> Trial:
    """Return a trial on a part of the recording as one on all of it, from the parameters and the noise found there."""
    hypotheses = [trial.hypothesis, *trial.also]
    guess = {name: value for name, value in trial.fit.state.values.items() if name not in fit.model.priors}
    begun = extended(fit, (*fit.model.hypotheses, *hypotheses), guess)
    laws_loose = {n: begun.noise[n] for h in hypotheses for n in begun.noise if n.startswith(f"{h.name}.")}
    noise = begun.noise | trial.fit.noise | laws_loose
    quiet = _calm_for_laws(replace(begun, noise=noise), hypotheses)
    driven = led(begun.model, begun.state, hypotheses)  # by a motion that holds the spring's own, it may resound
    states = [begun.state, driven]
    states += [settled(begun.model, s, quiet, fit.anchor, fit.loose) for s in states]
    cost = [sum(r.cost for r in all_rows(begun.model, s, quiet, fit.anchor, fit.loose)) for s in states]
    begun = solve(begun.model, states[int(np.argmin(cost))], quiet, fit.anchor, steps=4)
    tried = fit_with_noise(begun.model, begun.state, noise, fit.anchor, rounds=ROUNDS)
    return _against(fit, hypotheses, tried)


def _against(fit: Fit, hypotheses: list[Hypothesis], tried: Fit) -> Trial:
    """Return a refit beside the fit without its effects."""
    return Trial(hypotheses[0], tried, worth(fit, tried), tuple(hypotheses[1:]))


def _calm_for_laws(fit: Fit, hypotheses: Sequence[Hypothesis]) -> dict[str, float]:
    """Return the fit's noise levels, calm where an effect has a law to outweigh a misfit; a free state would vanish."""
    return calm(fit) if any(h.effect.lawful for h in hypotheses) else fit.noise


def calm(fit: Fit) -> dict[str, float]:
    """Return noise levels to begin a spring's fit with: ten times the declared, so that its law outweighs a misfit."""
    told = declared(fit.model)
    return {name: 10 * told[name] if name in told else std for name, std in fit.noise.items()}
