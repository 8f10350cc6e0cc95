"""How far off the axes are on imperfect rigs: at the end of each sequence, and as table 1 has it."""

from typing import Any

import numpy as np

from imubench.arrays import Array
from imubench.estimators.olsson2020 import algorithm1
from imubench.estimators.plug_and_play import batches, uniform_start
from imubench.estimators.selection import select
from imubench.estimators.selection_online import OnlineSelection
from imubench.estimators.uncertainty import Acceptance
from imubench.paired import Paired, paired
from imubench.recording import Recording
from imubench.reproduce.olsson2020 import data
from imubench.reproduce.olsson2020.imperfections import IMPERFECTIONS, NOMINAL, record_with
from imubench.reproduce.olsson2020.settings import (
    ACCEL_BIAS,
    BIAS_E_MAX,
    BIAS_N_MAX,
    BIAS_N_MIN,
    DURATIONS,
    GYRO_BIAS,
    SEQUENCES,
)
from imubench.reproduce.olsson2020.solving import Minima
from imubench.reproduce.paper import Arrays
from imubench.scenarios.olsson2020.plan import SEQUENCES as PLANS
from imubench.scenarios.olsson2020.sequences import add_bias, join
from imubench.score import axis_deviation
from imubench.sim.sprung import UnheldSensorError

SHORT = dict.fromkeys(range(1, 15), 24.0)  # s; the first 10 s of 3 and 10 are still motion of segment 1 alone
SHORTER = dict.fromkeys(range(1, 15), 12.0) | {3: 22.0, 10: 22.0, 6: 20.0}  # s, for springs
STARTS = 3  # random starts of each estimate
ESTIMATES = ("selection", "all samples")
SHAPES = {
    "socket tilt": 1.5, "axis coupling": 1.4, "gyro misalignment": 1.9,
    "play under load": 2.0, "play under hands": 2.0, "soft socket": 15.0, "time offset": 20.0,
}  # fmt: skip
"""Levels whose table 1 is made: where the sweep reaches 1.5 deg, or else the most that is plausible. The clean rig,
level 0 of any, stands beside them."""
ACCEPTING = ("socket tilt",)
"""Those that are also run through Algorithm 4, second by second, which takes a minute each."""


def end_axes(recording: Recording, rng: np.random.Generator, starts: int) -> Array:
    """Return the axes (starts, 2, 3) that Algorithm 1 finds from N_max = 500 selected samples and random starts."""
    samples = paired(recording)
    chosen = select(samples.gyro1, samples.gyro2, samples.accel1, samples.accel2, BIAS_N_MAX)
    c = data.weighed(chosen)
    return np.array([algorithm1(c, uniform_start(rng))[0].axes for _ in range(starts)])


def end_axes_of_all(recording: Recording, rng: np.random.Generator, starts: int) -> Array:
    """Return the axes (starts, 2, 3) that Algorithm 1 finds from all samples and random starts."""
    samples = paired(recording)
    c = data.weighed_until(samples, samples.time.size)
    return np.array([algorithm1(c, uniform_start(rng))[0].axes for _ in range(starts)])


def sweep(name: str, levels: tuple[float, ...], seed: int) -> Arrays:
    """Return `deviation` (levels, 4 sequences, 2 estimates, starts, 2) in rad from nominal at the sequences' ends.

    It is NaN at a level whose springs do not hold the sensor: that rig cannot be played.
    """
    durations = SHORTER if IMPERFECTIONS[name].slow else SHORT
    found = []
    for level in levels:
        try:
            session = record_with(name, level, seed, durations)
        except UnheldSensorError:
            found.append(np.full((len(SEQUENCES), len(ESTIMATES), STARTS, 2), np.nan))
            continue
        rng = np.random.default_rng([seed, 3])
        recordings = [join(PLANS[n], session).recording for n in SEQUENCES]
        axes = [[f(one, rng, STARTS) for f in (end_axes, end_axes_of_all)] for one in recordings]
        found.append(axis_deviation(np.array(axes), NOMINAL))
    return {"deviation": np.array(found)}


def table_at_end(name: str, level: float, seed: int, runs: int, biased: bool) -> Arrays:
    """Return `deviation` (4, runs, 2) in rad from nominal at the sequences' ends, N_max = 500, one random start a run.

    With `biased` every run adds biases of its own, as in section 7.5.
    """
    session = record_with(name, level, seed, SHORTER if IMPERFECTIONS[name].slow else SHORT)
    found = []
    for k, n in enumerate(SEQUENCES):
        rng = np.random.default_rng([seed, 4, k])
        recording = join(PLANS[n], session).recording
        made = [add_bias(recording, rng, GYRO_BIAS, ACCEL_BIAS) for _ in range(runs)] if biased else [recording]
        found.append(np.concatenate([end_axes(one, rng, runs // len(made)) for one in made]))
    return {"deviation": axis_deviation(np.array(found), NOMINAL)}


def table_when_accepted(name: str, level: float, seed: int, runs: int, biased: bool) -> Arrays:
    """Return what section 7.5 measures: `deviation` (4, runs, 2) in rad from nominal when Algorithm 4 accepts.

    `seconds` (4, runs) says when that was; a run that never accepts ends with its last estimate, `accepted` is false.
    """
    session = record_with(name, level, seed, DURATIONS)
    columns: tuple[list[Any], ...] = ([], [], [])  # axes, seconds, accepted
    for k, n in enumerate(SEQUENCES):
        rng = np.random.default_rng([seed, 5, k])
        recording = join(PLANS[n], session).recording
        if biased:
            made = (paired(add_bias(recording, rng, GYRO_BIAS, ACCEL_BIAS)) for _ in range(runs))
            found = [run for samples in made for run in _stream(samples, rng, 1)]
        else:
            found = _stream(paired(recording), rng, runs)
        for column, values in zip(columns, zip(*found, strict=True), strict=True):
            column.append(values)
    axes, seconds, accepted = (np.array(column) for column in columns)
    return {"deviation": axis_deviation(axes, NOMINAL), "seconds": seconds, "accepted": accepted}


def _stream(samples: Paired, rng: np.random.Generator, runs: int) -> list[tuple[Array, int, bool]]:
    """Run Algorithms 1 to 4 second by second, `runs` of them side by side until the last has accepted."""
    stream = OnlineSelection(BIAS_N_MAX)
    waiting = {m: Acceptance(BIAS_E_MAX, BIAS_N_MIN) for m in range(runs)}
    found: dict[int, tuple[Array, int, bool]] = {}
    for k, batch in enumerate(batches(samples)):
        chosen = stream.update(batch.gyro1, batch.gyro2, batch.accel1, batch.accel2)
        minima = Minima(data.weighed(chosen), rng)
        for m in list(waiting):
            verdict = waiting[m].update(*minima.estimate(uniform_start(rng)))
            found[m] = (verdict.axes, k + 1, verdict.accepted)
            if verdict.accepted:
                del waiting[m]
        if not waiting:
            break
    return [found[m] for m in range(runs)]
