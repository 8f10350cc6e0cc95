"""The step of a diagnosis in which MuJoCo judges what was found."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from imubench.correction.found_rig import possible_moments
from imubench.diagnosis.budget import Budget
from imubench.diagnosis.evidence import Evidence
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.residual_checks import fit_summary
from imubench.diagnosis.residual_checks.localize import locate
from imubench.diagnosis.residual_checks.regressors import regressors
from imubench.diagnosis.result import UNKNOWN, Finding, Simulation, Where
from imubench.diagnosis.simulation.beside import beside
from imubench.diagnosis.simulation.lost_samples import lost, tones
from imubench.diagnosis.simulation.sim_model import finding_of, named
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.errors import InputError
from imubench.recording import Recording

UNPLAYED = "the simulation beside the recording"


def judged_by_simulation(
    evidence: Evidence,
    declared: Fit,
    best: Fit,
    findings: Sequence[Finding],
    others: Mapping[tuple[str, str], Fit],
    budget: Budget,
) -> tuple[Simulation | None, Evidence, tuple[Where, ...]]:
    """Return how far MuJoCo's simulations are from a recording, the evidence with these, and where findings act.

    Nothing where MuJoCo cannot play the model or where half of the recording does not hold its motion, and the notes of
    the evidence say so; nothing either where the time limit came first.

    Args:
        evidence: of the diagnosis.
        declared: the fit of the declared model.
        best: that with all findings.
        findings: in the order of the diagnosis.
        others: `best` solved again without one of its effects, by effect and place.
        budget: of the diagnosis.
    """
    noise = {level.group: level.used for level in evidence.levels}
    found, why = None, ""
    with budget.rest(UNPLAYED):
        try:
            found = beside(best.model.recording, declared, best, noise, others, evidence.recording)
            why = "" if found else "MuJoCo cannot play what was found"
        except (InputError, NotPositiveDefiniteError, np.linalg.LinAlgError) as error:
            why = str(error)
    if found is None and why:
        note = f"No simulation was played beside the recording: {why}."
        return None, replace(evidence, notes=(*evidence.notes, note)), ()
    if found is None:
        return None, evidence, ()
    evidence = replace(evidence, notes=(*evidence.notes, *note_of_body(evidence.recording)))
    nameless = any(f.effect == UNKNOWN for f in evidence.motion.fitted)  # its signal is what its own motion leaves
    if found.numbers is not None:
        evidence = replace(
            evidence,
            mounts=fit_summary.mounts(found.numbers),
            taught=tuple(finding_of(found.numbers, h) for h in named(found.numbers)),
        )
    evidence = replace(
        evidence,
        prescribed=None if nameless else found.motion,
        simulated=found.channels,
        comparisons=tuple(found.findings.get((f.effect, f.at), ()) for f in findings),
        posed=found.posed,
        rolled_out=found.windows,
    )
    fitted = {(h.effect.name, h.at) for h in best.model.hypotheses}
    acting = found.added
    if not acting:  # what is found in the samples themselves is in no fit
        acting = lost(found.channels, best.model.masks or {}, {f.at for f in findings if f.effect != UNKNOWN})
        acting += tones(found.channels, [f for f in findings if (f.effect, f.at) not in fitted])
    return found.simulation, evidence, locate(acting, regressors(best), noise=0.0)


def note_of_body(recording: Recording) -> tuple[str, ...]:
    """Return in words which moments of inertia are played where no body has those that are declared."""
    if recording.body is None:
        return ()
    told, played = recording.body.inertia, possible_moments(recording.body.inertia)
    if np.array_equal(told, played):
        return ()
    said, instead = (", ".join(f"{x:.4g}" for x in moments) for moments in (told, played))
    return (f"No body has the declared moments of inertia {said} kg m^2: the simulation has {instead}.",)


__all__ = ["judged_by_simulation"]
