"""What terms promise before any is fitted: their information with motion, geometry and effects free to follow."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.discrepancy import BASIS, TERM
from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.criteria.score_test import at_best_size, each
from imubench.diagnosis.criteria.trial import Gain
from imubench.diagnosis.discrepancy.candidate_terms import jumps, terms
from imubench.diagnosis.discrepancy.terms import Term, Unknown, UnknownTorque, signals_of
from imubench.diagnosis.noise.colour_bound import louder_where
from imubench.diagnosis.noise.coloured import Spectra, noise_spectra
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.problem.residuals import CHANNELS
from imubench.diagnosis.solve.schur import Base
from imubench.diagnosis.solve.threads import one_thread
from imubench.recording import Imu


@dataclass(frozen=True)
class Guess:
    """A term, or a channel of one, and what it promises."""

    term: Term
    std: float
    evidence: float  # nat, with noise as coloured as it may be
    white: float  # nat, with white noise
    shape: float = -np.inf  # nat, of a slow error by its shape, its price taken off


@dataclass(frozen=True)
class FittedTerm:
    """A term in the fit."""

    hypothesis: Hypothesis
    term: Term
    fit: Fit
    freer: Fit  # the same with its motion held less smooth
    evidence: float  # nat, colour and the number of terms taken off
    heldout: Gain
    louder: float  # times white noise, what is left where the term has its power
    shape: float = -np.inf  # nat, of a slow error by its shape
    equal: tuple[Hypothesis, ...] = ()  # names that explain as much


def promising(fit: Fit) -> tuple[list[Guess], int]:
    """Return terms and single channels of terms, the best evidence on white noise first, and how many were tried.

    Terms are ranked by the residuals that they go with, and the best taken exactly. Those that the motion follows leave
    none of their own: what moves both parts of an IMU, and what a lone gyroscope reads. They are taken exactly, all.
    """
    tried, followed, ranked = 0, list[Term](), list[tuple[float, Term]]()
    alone = len(fit.model.recording.imus) == 1
    for term in terms(fit):
        tried += len(set(term.channel)) + 1
        if term.part == "both" or (term.part == "gyro" and alone):
            followed.append(term)
        else:
            ranked = sorted([*ranked, (_best(*_plain(fit, term), term).evidence, term)], key=lambda r: -r[0])[
                : TERM.exact
            ]
    if not ranked:  # an encoder alone, and no equation of motion
        return [], 0
    shown = noise_spectra(fit)  # first: it holds factors of its own while it is made
    base = Base.of(fit)
    guesses = _exact(base, shown, [*(term for _, term in ranked), *followed])
    guesses.sort(key=lambda g: -g.evidence)
    likely = [g.term for g in guesses if g.evidence > EVIDENCE.needed_nat]
    triples = {(t.at, t.part) for i, t in enumerate(likely) if i < TERM.likely or t.drift}
    for imu in fit.model.recording.imus:
        for part in CHANNELS:
            if (imu.name, part) in triples:
                guesses += _jumped(base, shown, imu, part)
                tried += 4 * TERM.jumps  # of three channels, or all
    return sorted(guesses, key=lambda g: -g.white), 2 * tried  # of two sizes: neighbours are hardly another


def _jumped(base: Base, shown: Mapping[str, Spectra], imu: Imu, part: str) -> list[Guess]:
    """Return the best jump of one triple, sought on a grid and then on a finer one."""
    low, high = (float(t) - base.fit.model.start for t in (imu.time[0], imu.time[-1]))
    for _ in range(2):
        step = (high - low) / (TERM.jumps + 1)
        starts = np.asarray(low + step * np.arange(1, TERM.jumps + 1), dtype=float)
        tried = _exact(base, shown, jumps(base.fit, imu, part, starts))
        best = max(range(TERM.jumps), key=lambda i: tried[i].evidence)
        low, high = starts[best] - step, starts[best] + step
    return [tried[best]]


@one_thread
def _exact(base: Base, shown: Mapping[str, Spectra], chosen: Sequence[Term]) -> list[Guess]:
    """Return what terms promise once motion, geometry and effects have followed them; a drift, beyond colour."""
    made = {hypothesis_of(term, 1.0): term for term in chosen}
    out = []
    for h, information, gradient in each(base, made):
        louder = colour(base.fit, made[h], shown) if made[h].drift else 1.0
        out.append(_best(information, gradient, made[h], louder))
    return out


def hypothesis_of(term: Term, std: float) -> Hypothesis:
    """Return a term as an effect at its place, its weights' prior `std`."""
    kind = UnknownTorque if term.part == "torque" else Unknown
    return Hypothesis(kind(term, std), term.at)


def _plain(fit: Fit, term: Term) -> tuple[Array, Array]:
    """Return information (k, k) and gradient (k,) of a term as if motion could follow a share of it everywhere."""
    total, force = np.zeros((term.count, term.count)), np.zeros(term.count)
    for rows, signal in signals_of(fit, term):
        total += signal.T @ signal
        force += signal.T @ rows.whitened.reshape(-1)
    return BASIS.followed * total, force


def _best(matrix: Array, gradient: Array, term: Term, louder: float = 1.0) -> Guess:
    """Return the whole term or the one channel of it, and the size of its weights, that have most evidence.

    `louder`: how much louder than white the noise may be there.
    """
    out, white = Guess(term, 1.0, -np.inf, -np.inf), -np.inf
    channels = sorted(set(term.channel))
    for channel in [None, *channels] if len(channels) > 1 else [None]:
        own = np.arange(term.count) if channel is None else np.flatnonzero(np.array(term.channel) == channel)
        values, vectors = np.linalg.eigh(matrix[np.ix_(own, own)])
        pull = (vectors.T @ gradient[own]) ** 2
        chosen = term if channel is None else term.only(channel)
        white = max(white, at_best_size(values, pull, BASIS.sizes)[0])
        evidence, std = at_best_size(values, pull, BASIS.sizes, louder)
        if evidence > out.evidence:
            out = Guess(chosen, std, evidence, 0.0)
    return replace(out, white=white)


def colour(fit: Fit, term: Term, shown: Mapping[str, Spectra] | None = None) -> float:
    """Return how much louder than white the noise may be where a term has its power, at least 1.

    `shown` is the noise's colour, where it is known already: it is the same for every term of a fit.
    """
    signals = [(rows.name, rows.time, x) for rows, x in signals_of(fit, term)]
    shown = noise_spectra(fit) if shown is None else shown
    here, above = ({}, shown) if term.drift else (shown, {})
    return louder_where(signals, here, above, fit.model.averaging)


__all__ = ["FittedTerm", "Guess", "colour", "hypothesis_of", "promising"]
