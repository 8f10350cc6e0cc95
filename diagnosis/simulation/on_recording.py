"""A model that was found in one recording, rolled out through another recording's free swings.

Friction, springs, body, mounts and the laws of the sensors are those of the `model/` folder, and its MJCF file is what
MuJoCo plays. Of the other recording come the states at the windows' starts, from a fit of its motion without any
effect, refined under each model on the first second; and what it declares, which is the model beside it.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from imubench.arrays import Array
from imubench.correction.read_model import read_model
from imubench.diagnosis.evidence import Swing
from imubench.diagnosis.noise.declared_noise import declared_by
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.residual_checks import fit_summary
from imubench.diagnosis.result import UNKNOWN, Simulation
from imubench.diagnosis.samples.screening import check_samples
from imubench.diagnosis.simulation.channels import dense_rate, judged_channels, read_out
from imubench.diagnosis.simulation.judge import Judge, counting, rolled
from imubench.diagnosis.simulation.learned import Part
from imubench.diagnosis.simulation.sim_model import SimModel, sim_model
from imubench.diagnosis.simulation.splice import rolled_truth
from imubench.errors import InputError
from imubench.progress import Step, silent
from imubench.recording import Recording, span_of


@dataclass(frozen=True)
class OnRecording:
    """How far a model is from another recording."""

    model_of: str  # the recording that the model was found in
    recording: str  # that it is judged on
    simulation: Simulation  # `before` is the model that this recording declares


def judged_on(folder: Path, recording: Recording, step: Step = silent) -> OnRecording:
    """Return how far a `model/` folder is from a recording's free swings, beside the model that this declares.

    Args:
        folder: of a diagnosis of the same rig.
        recording: with free swings and a body.
        step: told what is being done.

    Raises:
        InputError: a file is missing or damaged, the rigs differ, or the recording has nothing to roll out.
    """
    told, found = of_folder(Path(folder), recording)
    if recording.body is None or not recording.free_swings:
        raise InputError(f"{recording.name}: expected [[free_swing]] windows and a [body] to roll out, got none")
    with step("fit the motion"):
        samples = check_samples(recording)
        known = samples.heard(recording)
        fit = nominal_fit(known, samples.masks, samples.humming, samples.wander)
        levels = fit_summary.weighed(fit, declared_by(recording), samples.white).levels
    with step("roll both models out"):
        simulation = beside_declared(fit, found, {level.group: level.used for level in levels}, told)
    return OnRecording(told, recording.name, simulation)


def of_folder(folder: Path, recording: Recording) -> tuple[str, SimModel]:
    """Return the recording that a `model/` folder was made from, and its model; `InputError` for another rig.

    What happened at some moment of its own recording, a slip or a signal without a name, is not in it.
    """
    model = read_model(folder)
    if model.rig.family != recording.rig:
        raise InputError(
            f"{folder}: expected a model of rig {recording.rig}, as {recording.name} is, got {model.rig.family}"
        )
    rig = replace(model.rig, mounts=tuple(replace(mount, slip=None) for mount in model.rig.mounts))
    effects = tuple((at, link) for at, link in model.effects if link.effect != UNKNOWN)
    return model.recording, SimModel(rig, effects, span_of(recording)[0])


def beside_declared(fit: Fit, found: SimModel, noise: dict[str, float], told: str) -> Simulation:
    """Return how far the declared model and one that was `found` elsewhere are from a recording's free swings."""
    recording = fit.model.recording
    measured = judged_channels(recording, noise)
    parts = tuple(Part(start, end, 0, True) for start, end in sorted(recording.free_swings))
    judge = Judge(recording, measured, counting(measured, fit), noise, parts, ((), ()), foretells=True)
    started = rolled(judge, fit, found, parts, found.rig.dry_friction)
    if not started:
        raise InputError(f"{recording.name}: expected free swings of 1.5 s on a base that stands still, got none")
    windows = tuple((w.start, w.end) for w in started)
    judge = replace(judge, windows=(windows, ()))
    declared = sim_model(fit)
    declared = SimModel(declared.rig, declared.effects, declared.start)  # the encoder's error is this recording's own
    before = [judge.started(fit, declared, window) for window in windows]
    with_it, without = (played_in(judge, model, w) for model, w in ((found, started), (declared, before)))
    return Simulation(
        "rolled out",
        windows,
        told != recording.name,
        {c.name: judge.off(c, without[c.name], with_it[c.name]) for c in measured},
    )


def played_in(judge: Judge, model: SimModel, windows: tuple[Swing, ...] | list[Swing]) -> dict[str, Array]:
    """Return every channel as a model's roll-out has it in some windows; what was measured elsewhere."""
    out = {c.name: np.array(c.measured) for c in judge.channels}
    for window in windows:
        truth = rolled_truth(model.rig, window, dense_rate(judge.recording), model.start)
        read = read_out(model, judge.recording, truth, window.start)
        for c in judge.channels:
            own = (c.time >= window.start) & (c.time <= window.end)
            out[c.name][own] = read[c.name][own]
    return out


__all__ = ["OnRecording", "judged_on"]
