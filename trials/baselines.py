"""Other ways to answer, on the same cases, as diagnoses that are scored alike.

residual size   the misfit of the declared model alone: an `unknown` where it is largest, or nothing
L1              all effects without states at once, from the nominal fit's linear step, sparse by an L1 penalty

The third one, the oracle, has a file of its own.
"""

from collections.abc import Sequence

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.problem.batch_model import started
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.result import UNKNOWN, Diagnosis, Finding, FitQuality, Interval
from imubench.diagnosis.search.selected import candidates
from imubench.diagnosis.solve.gauss_newton import all_rows, factored

SURE = 0.95  # what a baseline says of everything that it finds: it has no probabilities
NO_GAIN = Interval(0.0, (0.0, 0.0))
ROUNDS = 2000  # of coordinate descent; it stops where nothing moves
CLOSE = 1e-6  # of a bound


def residual_size(ours: Diagnosis, alarm_misfit: float) -> Diagnosis:
    """Return what the declared model's misfit alone says, from what the diagnosis says of it."""
    loud = ours.misfit[0] > alarm_misfit and bool(ours.where)
    return answer(ours.rig, [Finding(UNKNOWN, ours.where[0].at, SURE, {}, NO_GAIN)] if loud else [])


def answer(rig: str, found: Sequence[Finding]) -> Diagnosis:
    """Return the diagnosis that has these findings and says no more."""
    named = any(f.named for f in found)
    verdict = "explained" if named else "unexplained" if found else "no mismatch"
    return Diagnosis(
        "recording",
        rig,
        verdict,  # type: ignore[arg-type]
        (1.0, 1.0),
        (),
        tuple(found),
        (),
        FitQuality((1.0, 1.0)),
        "",
        0.0,
    )


def l1(fit: Fit) -> Diagnosis:
    """Return the effects that stay under an L1 penalty, largest first.

    Parameters in units of their own bound; the penalty sqrt(2 log p) is what the largest of p of pure noise reaches.
    """
    tried = [h for h in candidates(fit.model) if not h.effect.states]
    matrix, force, spans = joint(fit, tried)
    scale = 1 / np.sqrt(np.diagonal(matrix))
    z = lasso(matrix * np.outer(scale, scale), -force * scale, float(np.sqrt(2 * np.log(len(force)))))
    sizes = {h: float(np.linalg.norm(z[span])) for h, span in zip(tried, spans, strict=True)}
    there: dict[tuple[str, str], float] = {}
    for h, size in sizes.items():
        if size > CLOSE:
            there[h.effect.name, h.at] = max(there.get((h.effect.name, h.at), 0.0), size)
    best = sorted(there, key=lambda place: -there[place])
    return answer(fit.model.recording.rig, [Finding(name, at, SURE, {}, NO_GAIN) for name, at in best])


def joint(fit: Fit, tried: Sequence[Hypothesis]) -> tuple[Array, Array, list[slice]]:
    """Return the information (k, k) and gradient (k,) of all parameters at once, the motion and the geometry free."""
    model = fit.model.with_effects((*fit.model.hypotheses, *tried))
    rows = all_rows(model, started(model, fit.state), fit.noise, fit.anchor, fit.loose)
    normal, solution, _ = factored(model, rows)
    columns = [model.parameters.places([h.key(p.name) for p in h.effect.parameters]) for h in tried]
    ends = np.cumsum([len(c) for c in columns])
    spans = [slice(int(end) - len(c), int(end)) for c, end in zip(columns, ends, strict=True)]
    return *solution.reduced(normal.gradient, normal.corner_gradient, np.concatenate(columns)), spans


def lasso(matrix: Array, force: Array, penalty: float) -> Array:
    """Return z (k,) that minimises z' matrix z / 2 - force' z + penalty |z|_1, the diagonal of matrix being 1."""
    z = np.zeros(len(force))
    product = np.zeros(len(force))  # matrix @ z
    for _ in range(ROUNDS):
        most = 0.0
        for k in range(len(z)):
            open_ = force[k] - product[k] + z[k]
            new = np.sign(open_) * max(abs(open_) - penalty, 0.0)
            if new != z[k]:
                product += matrix[:, k] * (new - z[k])
                most = max(most, abs(new - z[k]))
                z[k] = new
        if most < CLOSE:
            break
    return z
