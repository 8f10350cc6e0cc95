"""What no effect explains: found by terms without a name, fitted exactly, and judged on data they have not seen.

Every term is held against the residuals; for the best its information is taken with motion, geometry and effects
free to follow, its weights' size chosen by evidence, and all of it or one channel of it refitted. Coloured noise
looks like slow terms: what is left of the residuals' colour after the refit divides the gain.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from imubench.diagnosis.candidates.both_mounts import gives_way
from imubench.diagnosis.config.discrepancy import TERM
from imubench.diagnosis.config.shared import CONFIDENCE, EVIDENCE
from imubench.diagnosis.discrepancy.best_term import best_term
from imubench.diagnosis.discrepancy.term_scores import FittedTerm
from imubench.diagnosis.discrepancy.terms import Unknown, channels_of, signals_of
from imubench.diagnosis.evidence import Trace
from imubench.diagnosis.noise.pooled import with_pooled_noise
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.residual_checks.excess_noise import excess_noise, left_over, off_its_equation
from imubench.diagnosis.residual_checks.localize import locate, shares
from imubench.diagnosis.residual_checks.regressors import regressors
from imubench.diagnosis.result import UNKNOWN, Finding, Parameter, Rejected, Where
from imubench.diagnosis.rules import RuleUse
from imubench.diagnosis.search.confidence import confidence, nameless
from imubench.diagnosis.search.moves.drop import price_of_dropping
from imubench.diagnosis.search.moves.swap_for_term import TermSwaps, swapped_for_terms
from imubench.diagnosis.search.nonlinear_spring import (
    left_by,
    nonlinear_finding,
    nonlinear_springs,
    suspected_findings,
    unheld,
)
from imubench.diagnosis.search.unnamed import Unknowns
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.refit import information

UNITS = {"gyro": "rad/s", "accel": "m/s^2", "torque": "N m"}


def unknowns(
    fit: Fit,
    where: Sequence[Where] = (),
    say: Callable[[str], None] = lambda _: None,
    use: RuleUse | None = None,
) -> Unknowns:
    """Return what a fit with all its named effects leaves unexplained, with terms for it in the model.

    `where` says where the nominal fit's residuals were; it serves where no term is found for what is left. Beside
    mounts that give way otherwise than straight springs do, terms would take in what these leave, and are not asked.
    `use` has the rules that may be applied; None: all.
    """
    use = use or RuleUse()
    if gives_way(fit):
        loose = unheld(fit)
        return Unknowns(tuple(left_by(h, fit) for h in loose), fit, tuple(loose))
    springs, unsure = nonlinear_springs(fit, say) if use.on("nonlinear-springs") else ([], {})
    use.holds("nonlinear-springs", lambda: bool(springs or unsure))
    fit = with_pooled_noise(springs[-1].fit if springs else fit)
    held = swapped_for_terms(fit, say) if use.on("term-for-effects") else TermSwaps([], fit, ())
    use.holds("term-for-effects", lambda: bool(held.terms or held.doubted or held.likely))
    found, fit = held.terms, held.fit
    while use.on("add-term") and len(found) < TERM.most_terms:
        say("looking for something without a name")
        best = best_term(with_pooled_noise(fit))
        if best is None:
            break
        found.append(best)
        use.fires("add-term")
        fit = best.fit
    out = [nonlinear_finding(b) for b in springs]
    for f in found:
        if f.term.at not in {o.at for o in out}:
            out.append(finding(f))
    out += [instead_of(*one) for one in held.likely if one[0].term.at not in {o.at for o in out}]
    bent = [f for f in suspected_findings(unsure, fit) if f.at not in {o.at for o in out}]
    out += use.those("suspected-springs", lambda: bent)
    loose = use.those("springs-leave-much", lambda: [h for h in unheld(fit) if h.at not in {o.at for o in out}])
    out += [left_by(h, fit) for h in loose]
    out += [] if out else use.those("off-its-equation", lambda: off_its_equation(fit))
    noisy = use.those("excess-noise", lambda: list(excess_noise(fit, where, {f.at for f in out})))
    strange = any(f.effect == UNKNOWN for f in noisy)
    sunk = use.those("negligible-names", lambda: negligible_names(fit, say)) if strange else []
    return Unknowns((*out, *noisy), fit, (*held.doubted, *unsure, *loose, *sunk))


def negligible_names(fit: Fit, say: Callable[[str], None] = lambda _: None) -> list[Hypothesis]:
    """Return the names of a fit that are worth less than what it leaves: beside that they explain next to nothing.

    Where much is left, almost any name gains on held-out data.
    """
    most, out = left_over(fit), []
    for h in [h for h in fit.model.judged if not isinstance(h.effect, Unknown)]:
        say(f"trying to do without {h.name}")
        with suppress(NotPositiveDefiniteError):
            out += [h] if price_of_dropping(fit, h)[0] < most else []
    return out


def finding(found: FittedTerm) -> Finding:
    """Return a fitted term as a finding, with the names that it equals."""
    sure = confidence(max(found.evidence - EVIDENCE.clear_nat, found.shape - TERM.shape_nat), 0.0)
    said = nameless(found.term.at, sure, sizes(found), found.heldout, place(found))
    equal = tuple(Rejected(h.effect.name, h.at, said.heldout_gain.value) for h in found.equal)
    return replace(said, equivalent=equal)


def instead_of(found: FittedTerm, names: Sequence[Hypothesis]) -> Finding:
    """Return a term that is likelier than the names that it equals as a finding that says so."""
    return replace(finding(replace(found, equal=tuple(names))), confidence=CONFIDENCE.doubtful)


def sizes(found: FittedTerm) -> dict[str, Parameter]:
    """Return the RMS of what a term adds, by part, with its standard deviation."""
    h, fit = found.hypothesis, found.fit
    columns = fit.model.parameters.columns(h.key("weight"))
    covariance = information(fit)[0][columns, columns]
    weight = fit.state.values[h.key("weight")]
    out = {}
    for part, signal in found.term.signals.items():
        flat = signal.astype(float).reshape(-1, found.term.count)
        square = flat.T @ flat / len(signal)
        size = float(np.linalg.norm(flat @ weight)) / len(signal) ** 0.5
        slope = square @ weight / max(size, 1e-300)
        std = max(float(slope @ covariance @ slope), 0.0) ** 0.5
        out[f"{part}_rms"] = Parameter(np.array(size), np.array(std), UNITS[part])
    return out


def place(found: FittedTerm) -> Where:
    """Return where a term acts: its channels by their power over the noise, and the bands and windows of what it is."""
    h, fit, term = found.hypothesis, found.fit, found.term
    weight = fit.state.values[h.key("weight")]
    traces, adds = [], []
    for rows, signal in signals_of(fit, term):
        n, m = rows.residual.value.shape
        adds.append((signal @ weight).reshape(n, m))
        part = rows.name.split(".")[1]
        named, time = channels_of(part, m), rows.time + fit.model.start
        traces.append(Trace(term.at, part, named, UNITS[part], time, adds[-1] + rows.whitened, 1.0))
    seen = locate(traces, {} if term.part == "torque" else regressors(fit))
    if seen:
        return replace(seen[0], depends_on=term.goes_with)
    names = [c for t in traces for c in t.channels]
    power = np.concatenate([np.sum(x**2, axis=0) for x in adds])
    return Where(term.at, shares(dict(zip(names, power, strict=True))), (), (), term.goes_with, 1.0)


__all__ = ["unknowns"]
