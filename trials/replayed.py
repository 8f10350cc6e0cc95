"""What a diagnosis' simulations are worth: whether what it found is in the simulator, and whether that shows.

`before`, `after` and `fit` are what `simulation` in diagnosis.json says of channel c: RMS of the declared model, of the
model with all findings, and of the motion fit with the same numbers; s is its noise. `disk` is the RMS over the same
samples of what MuJoCo plays of the `model/` that was written. `left` is what the effects add to the channel beyond what
any motion and the mounts can take up (`proof.excess`), `concealed` what they add to it at all.

    misfit(x) = mean over c of (x_c / s_c)^2
    modelled:  misfit(after) <= 1.1 misfit(fit)
               misfit(after) <= 1.1 of the held-out misfit that the diagnosis states (its share of noise not taken off),
                                both over the noise that it found, sqrt(s_c^2 + step^2 / 12) where readings are rounded
               (disk_c / s_c)^2 <= (fit_c / s_c)^2 + 0.1 misfit(fit)    on every channel
    shown:     sqrt(before_c^2 - after_c^2) >= left_c / 2      on the channel c where left_c / s_c is largest

In `after` and `fit` each half of the recording is played and fitted with numbers of the other half, so that neither has
learned what it is judged on; a hand's motion is that of all samples, for nothing else could tell it. Springs are held
to their laws in `fit`, as in a replay; where they do not obey them both are as far off, and the second line says so.
`disk` has the numbers of the whole recording: it says that the model on disk is the one that was judged. It counts by
channel, for in a mean of twelve one wrong number would pass.

The motion of a fit follows every sample and so takes up a share h of the noise, a third of it at 100 Hz: with the true
numbers misfit(fit) is 1 - h, and so is that of a replay whose motion is prescribed to it. A roll-out follows no sample,
and with the true numbers its misfit is 1. In a free swing that is rolled out misfit(fit) is therefore the misfit of
samples that the fit did not follow, which the diagnosis states (every sample predicted from all others), and fit_c,
which has another h on every channel, is after_c.

`shown` is not asked of an effect that adds less than `SEEN` standard deviations to that channel, over all its samples.
Then before^2 - after^2 has the mean left^2 and, by the noise, the standard deviation 2 s left / sqrt(n), a quarter of
that at 8: the half that is asked for, a quarter of left^2, is three of these below the mean.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from imubench import format1
from imubench.correction.read_model import Model, read_model
from imubench.diagnosis.config.correction import REPLAY
from imubench.diagnosis.result import Diagnosis, Finding, Simulation
from imubench.diagnosis.samples.screening import check_samples
from imubench.diagnosis.simulation.channels import Channel, channels, dense_rate, read_out
from imubench.diagnosis.simulation.model_folder import played_early
from imubench.diagnosis.simulation.sim_model import SimModel
from imubench.diagnosis.windows import Window, covered
from imubench.effects import EFFECTS, traits_of
from imubench.effects.traits import Fault
from imubench.errors import InputError
from imubench.proof.excess import Excess, excess
from imubench.recording import Recording
from imubench.trials.make import rebuilt
from imubench.trials.match import inside, paired, sure
from imubench.trials.seal import Truth

MODEL = "model"  # the folder beside diagnosis.json
NEAR = 1.1  # times the fit's own misfit: what a replay may be, the interface's aim
HALF = 0.5  # of what the declared model cannot take up: what must show; of the largest channel: what counts as large
SEEN = 8.0  # standard deviations that a channel is off by; see above
AT_THE_JOINT = ("joint", "encoder")


@dataclass(frozen=True)
class Replayed:
    """What the simulations of one diagnosis were worth. None: the question does not arise in this case."""

    replay: float | None = None  # misfit of the held-out replay over that of the fit
    disk: float | None = None  # the same of the model on disk, by the channel where that is worst
    held_out: bool | None = None  # whether every number was learned on other samples
    rolled_out: bool | None = None  # whether free swings were played by forces alone
    modelled: bool | None = None  # whether both are near
    channel: str = ""  # where the effects are strongest beyond what a motion takes up
    showed: float | None = None  # by how much of that the declared model is worse there
    shown: bool | None = None  # whether by half of it
    sensor: bool | None = None  # whether the first sensor of `where` is right
    first_channel: bool | None = None  # whether its first channel is right, too


def replayed(truth: Truth, d: Diagnosis, answer: Path, recording: Path) -> Replayed:
    """Return what the simulations of a diagnosis were worth.

    Args:
        truth: of the case.
        d: its diagnosis.
        answer: the folder that holds diagnosis.json, and `model/` where one was written.
        recording: the folder of the recording that was diagnosed.
    """
    found = sure(d.findings)
    if not truth["observable"] or not truth["effects"] or not found:
        return Replayed()
    rolled = d.simulation is not None and d.simulation.how == "rolled out"
    told: dict[str, Excess] = {}
    if "mounts" in truth:  # of the generator, which knows its own motion
        told = excess(rebuilt(truth), d.simulation.windows_s if d.simulation and rolled else ())
    sensor, first_channel = pointed(truth, d, told)
    if not inside(truth) or len(paired(truth, found)) < len(truth["effects"]):
        return Replayed(sensor=sensor, first_channel=first_channel)
    disk_off = on_disk(answer / MODEL, recording, d.simulation)
    replay, disk = nearness(over_noise_found(d), disk_off, d.fit.heldout[1] if rolled else None)
    channel, showed = shown(d.simulation, told)
    return Replayed(
        replay,
        disk,
        None if d.simulation is None else d.simulation.heldout,
        None if d.simulation is None else rolled,
        replay is not None and disk is not None and max(replay, disk, stated(d)) <= NEAR,
        channel,
        showed,
        (showed is not None and showed >= HALF) if channel else None,
        sensor,
        first_channel,
    )


def nearness(
    simulation: Simulation | None, disk: Mapping[str, float], heldout: float | None = None
) -> tuple[float | None, float | None]:
    """Return the misfit of the held-out replay over the fit's, and how far the model on `disk` is; see the module.

    The second is 1 + max over c of ((disk_c / s_c)^2 - (fit_c / s_c)^2) / misfit(fit), of a roll-out
    1 + max over c of ((disk_c / s_c)^2 - (after_c / s_c)^2) / `heldout`. None where there is no simulation, no channel
    that the fit has, or no model.

    Args:
        simulation: of the diagnosis.
        disk: RMS by channel.
        heldout: misfit of the fit on samples that its motion did not follow; None: a prescribed motion follows them.
    """
    if simulation is None:
        return None, None
    known = {name: (c, c.fit) for name, c in simulation.channels.items() if c.fit}
    if not known:
        return None, None
    fitted = float(np.mean([(fit / c.noise) ** 2 for c, fit in known.values()]))
    own = fitted if heldout is None else heldout
    replay = float(np.mean([(c.after / c.noise) ** 2 for c, _ in known.values()])) / own
    if not known.keys() <= disk.keys():
        return replay, None
    aside = {name: fit if heldout is None else c.after for name, (c, fit) in known.items()}
    return replay, 1 + max((disk[name] ** 2 - aside[name] ** 2) / c.noise**2 for name, (c, _) in known.items()) / own


def stated(d: Diagnosis) -> float:
    """Return the misfit of the held-out replay over the held-out misfit that a diagnosis states of its fit."""
    simulation = over_noise_found(d)
    assert simulation is not None
    return float(np.mean([(c.after / c.noise) ** 2 for c in simulation.channels.values()])) / max(
        d.fit.heldout[1], 1e-9
    )


def over_noise_found(d: Diagnosis) -> Simulation | None:
    """Return the simulation of a diagnosis over the noise that it found: louder than declared, or beside rounding."""
    if d.simulation is None:
        return None
    found, channels = noise_found(d.findings), {}
    for name, c in d.simulation.channels.items():
        std, step = found.get(name[: name.rfind("_")], (0.0, 0.0))
        channels[name] = replace(c, noise=float(np.hypot(max(c.noise, std), step / 12**0.5)))
    return replace(d.simulation, channels=channels)


def noise_found(findings: Iterable[Finding]) -> dict[str, tuple[float, float]]:
    """Return the noise std and the step of rounding that are told, 0 for none, by triple: imu1.gyr, imu1.acc."""
    out: dict[str, tuple[float, float]] = {}
    for f in findings:
        fault = traits_of(f.effect).fault
        if fault not in (Fault.NOISY, Fault.ROUNDED):
            continue
        (told,) = f.parameters.values()
        name = f"{f.at}.{'gyr' if told.unit == 'rad/s' else 'acc'}"
        std, step = out.get(name, (0.0, 0.0))
        size = float(told.value)
        out[name] = (max(std, size), step) if fault is Fault.NOISY else (std, max(step, size))
    return out


def shown(simulation: Simulation | None, told: Mapping[str, Excess]) -> tuple[str, float | None]:
    """Return the channel where the effects are strongest, and the share of `left` by which the declared model is worse.

    "" where no channel is off by enough to be seen; None where the simulation does not say.
    """
    if not told:
        return "", None
    name, most = max(told.items(), key=lambda item: item[1].left / item[1].noise)
    if most.deviations < SEEN:
        return "", None
    if simulation is None or name not in simulation.channels:
        return name, None
    c = simulation.channels[name]
    return name, float(np.sqrt(max(c.before**2 - c.after**2, 0.0))) / most.left


def pointed(truth: Truth, d: Diagnosis, told: Mapping[str, Excess]) -> tuple[bool, bool | None]:
    """Return whether the first sensor of `where` is right, and its first channel; None where nothing tells.

    A sensor is right that is the place of an effect, or of what is always equivalent to it; of an effect in the rig the
    joint, its encoder, and every IMU with a channel that has half of what the largest has. A channel of an IMU is right
    that has half of what the sensor's largest has. All over the noise, as `concealed`.
    """
    if not d.where:
        return False, False if told else None
    first = d.where[0]
    at = {a["at"] for answers in truth["answers"] for a in answers}
    size = {name: x.concealed / x.noise for name, x in told.items()}
    largest = max(size.values(), default=0.0)
    own = max((x for name, x in size.items() if name.startswith(f"{first.at}.")), default=0.0)
    in_the_rig = any(not place.startswith("imu") for place in at)
    right = first.at in at or (in_the_rig and (first.at in AT_THE_JOINT or 0 < HALF * largest <= own))
    if not told or not first.channels:
        return right, None if not told else False
    if not first.at.startswith("imu"):
        return right, right
    channel = f"{first.at}.{next(iter(first.channels))}"
    return right, right and size.get(channel, 0.0) >= HALF * own > 0


def on_disk(folder: Path, recording: Path, simulation: Simulation | None) -> dict[str, float]:
    """Return the RMS by channel of what a `model/` plays less what was measured; {} where none can be played.

    Over the samples that are judged: inside the simulation's windows, without those that the raw checks took out, and
    without those in which their sensor slips: how is not known to the sample, and the fit leaves them out, too.
    """
    if simulation is None or not folder.is_dir():
        return {}
    try:
        model = read_model(folder)
        measured = format1.read(recording)[0]
        samples = check_samples(measured)
        heard = samples.heard(measured)
        truth, first = played_early(model)
        played = read_out(SimModel(model.rig, model.effects, model.start), heard, truth, first)
    except InputError:
        return {}
    margin = REPLAY.end_rows / dense_rate(heard) if simulation.how == "rolled out" else 0.0
    windows = [(start + margin, end - margin) for start, end in simulation.windows_s]
    out = {}
    for c in channels(heard):
        own = covered(c.time, windows) & _counts(c, samples.masks, heard) & ~covered(c.time, slipping(model, c.group))
        if own.any():
            out[c.name] = float(np.sqrt(np.mean((played[c.name] - c.measured)[own] ** 2)))
    return out


def slipping(model: Model, group: str) -> list[Window]:
    """Return when the sensor of a group slips in a model, s of the recording's clock."""
    laws = [law for law in EFFECTS.values() if law.onset]
    slips = [m.slip for imu, m in zip(model.rig.tree.imus, model.rig.mounts, strict=True) if imu == group.split(".")[0]]
    return [
        (start + model.start, end + model.start)
        for slip in slips
        if slip is not None
        for law in laws
        for start, end in law.blind({law.onset: np.array([slip.time])})
    ]


def _counts(c: Channel, masks: Mapping[str, NDArray[np.bool_]], recording: Recording) -> NDArray[np.bool_]:
    """Return which samples (n,) of a channel the raw checks left; a pose has channels only where it was seen."""
    if c.group not in masks:
        return np.ones(c.time.size, dtype=bool)
    poses = {f"pose{i}": pose.time for i, pose in enumerate(recording.poses, 1)}
    stamps = poses.get(c.group.partition(".")[0], c.time)
    return masks[c.group][np.isin(stamps, c.time)]


__all__ = ["Replayed", "nearness", "on_disk", "pointed", "replayed", "shown"]
