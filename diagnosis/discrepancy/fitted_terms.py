"""Terms without a name in the fit: what one gains there, its prior, its freedoms and coloured noise taken off."""

from dataclasses import replace

import numpy as np

from imubench.diagnosis.config.criteria import HELD_OUT
from imubench.diagnosis.config.discrepancy import TERM
from imubench.diagnosis.config.shared import EVIDENCE, STATISTICS
from imubench.diagnosis.criteria.conditional_aic import aic_gain
from imubench.diagnosis.criteria.cross_validation import predicted
from imubench.diagnosis.criteria.score_test import gain_of_weights
from imubench.diagnosis.discrepancy.candidate_terms import sensor_terms, torque_terms
from imubench.diagnosis.discrepancy.term_scores import FittedTerm, Guess, colour, hypothesis_of
from imubench.diagnosis.discrepancy.terms import Term
from imubench.diagnosis.noise.looser_motion import rougher
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis, State
from imubench.diagnosis.solve.levenberg_marquardt import at_noise_of
from imubench.diagnosis.solve.refit import evidence_over, information, refit


def fitted_term(fit: Fit, guess: Guess, price: float) -> FittedTerm:
    """Return a term's exact refit, its evidence less `price`, and what it predicts.

    What is worth much has bent the motion that its signals were taken from: they are taken again from the motion that
    it leaves, while that explains more.
    """
    found = refit_once(fit, guess, price)
    for _ in range(TERM.retakes):
        if found.evidence < TERM.bends_nat or guess.term.timed:
            break
        further = refit_once(fit, replace(guess, term=taken_again(fit, found)), price)
        if not further.heldout.is_sure() or aic_gain(found.fit, further.fit) < EVIDENCE.clear_nat:
            break
        found = further
    return found


def taken_again(fit: Fit, found: FittedTerm) -> Term:
    """Return a term of the fit with its signals taken from the motion that is left where it is in the fit."""
    values = {name: value for name, value in found.fit.state.values.items() if name in fit.model.priors}
    moved = replace(fit, state=State(found.fit.state.coefficients, values))
    old = found.term
    imu = next((i for i in fit.model.recording.imus if i.name == old.at), None)
    new = torque_terms(moved) if imu is None else sensor_terms(moved, imu)
    term = next(t for t in new if (t.part, t.goes_with) == (old.part, old.goes_with))
    return term if len(term.channel) == len(old.channel) else term.only(old.channel[0])


def refit_once(fit: Fit, guess: Guess, price: float) -> FittedTerm:
    """Return a term's exact refit with its signals as they are.

    The evidence is the lesser one of the motion as rough as the fit has it, and of a rougher: what a motion held too
    smooth does not follow goes with the motion.
    """
    h = hypothesis_of(guess.term, guess.std)
    tried = refit(fit, (*fit.model.hypotheses, h), steps=4)
    better = with_noise(tried, 2)
    ruler = at_noise_of(fit, better)
    heldout = predicted(
        ruler,
        better,
        np.random.default_rng(STATISTICS.seed),
        TERM.block_s if guess.term.timed else HELD_OUT.block_s,
    )
    louder = colour(better, guess.term)
    freer = rougher(better)
    evidence = min(gain_of_term(ruler, better, h, louder), gain_of_term(rougher(ruler), freer, h, louder)) - price
    evidence = max(evidence, guess.shape)
    return FittedTerm(h, guess.term, better, freer, evidence, heldout, louder, guess.shape)


def gain_of_term(before: Fit, after: Fit, h: Hypothesis, louder: float) -> float:
    """Return the nat that a term is worth at equal noise levels, where noise is so many times louder than white.

    Beside louder noise its weights win less, and their freedom costs less.
    """
    won = before.cost - after.cost
    freedom = won - evidence_over(before, after)
    columns = after.model.parameters.columns(h.key("weight"))
    values, vectors = np.linalg.eigh(np.linalg.inv(information(after)[0][columns, columns]))
    pull = (values * (vectors.T @ after.state.values[h.key("weight")])) ** 2
    (parameter,) = h.effect.parameters
    own = values - 1 / parameter.std**2
    (white, price), (left, lower) = (gain_of_weights(own, pull, parameter.std, times) for times in (1.0, louder))
    share = left / white if white > 0 else 1 / louder
    return (won - smoothness_gain(before, after)) * share - freedom + price - lower


def smoothness_gain(before: Fit, after: Fit) -> float:
    """Return the nat by which the motion of a fit is smoother than before; 0 where it is rougher.

    A term in what the sensor itself reads may be the motion: the less of it is in the splines, the less their prior
    asks for it, and no sample is explained.
    """
    smooth = [sum(r.cost for r in fit.rows if r.name.startswith("smooth.")) for fit in (before, after)]
    return max(float(smooth[0] - smooth[1]), 0.0)
