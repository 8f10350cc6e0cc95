"""Recordings of the pendulum on soft tissue, and what every one-IMU estimator makes of them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from imubench.arrays import Array
from imubench.estimators import frick_rahmatalla, mrvs, sliding
from imubench.estimators.centre_ekf import covariances_of
from imubench.estimators.centre_runs import track
from imubench.estimators.sliding_ekf import SlidingBank
from imubench.estimators.sliding_rows import Rows
from imubench.reproduce.arve.experiments import STATES
from imubench.reproduce.arve.runs import RATE, Runs, noisy, removed
from imubench.scenarios.moving_pivot import gait, moving, pendulum_truth
from imubench.scenarios.pendulum import DURATION, SoftTissue, ellipse, limb
from imubench.sim.play import play
from imubench.sim.rigs import springs
from imubench.sim.signals import Sines
from imubench.truth import SensorTruth

SHAPE = np.array([1.0, 0.25, 1.0])  # of the paper's amplitude, 20, 5 and 20 mm
NOISE = 0.0017, 0.02  # rad/s and m/s^2 per sample, what the estimators are told
SETTLED = 4.0  # s, from when streams are judged
DAMPING = 0.2  # of springs, unless something else is said
METHODS = ("arve", "arve-d", "mrvs", frick_rahmatalla.NAME, sliding.NAME)
KINDS = ("constant", "felt", "unfelt", "spring")


@dataclass(frozen=True)
class Cell:
    """One recording: the soft tissue, its numbers, its noise."""

    kind: SoftTissue
    amplitude: float = 0.02  # m, along x and z; a quarter along y
    frequency: float = 1.0  # Hz, of the slide, or the spring's
    phase: float = 0.0  # rad
    damping: float = DAMPING
    seed: int = 0
    gyro_noise: float = 1.0  # times the sensor's


def truth_of(cell: Cell) -> SensorTruth:
    """Play one cell's pendulum."""
    rig = limb(cell.kind, amplitude=cell.amplitude * SHAPE, frequency=cell.frequency, phase=cell.phase)
    if cell.kind == "sprung":
        hung = replace(rig.mounts[0], translation=springs(cell.frequency, cell.damping))
        rig = replace(rig, mounts=(hung,))
    return play(rig, ellipse(), DURATION, RATE).sensors[0]


def recorded(truth: SensorTruth, seed: int, gyro_noise: float = 1.0) -> Runs:
    """Return one run with the sensor's noise, that of the gyroscope times a factor."""
    runs = noisy(truth, seed)
    return replace(runs, gyro=truth.gyro + gyro_noise * (runs.gyro - truth.gyro))


def rows_of(runs: Runs, acceleration: Array) -> Rows:
    """Return the equations of the first run for `sliding`; it is told the sensor's noise, whatever the run has."""
    return Rows(runs.time, runs.gyro[0], runs.accel[0], runs.accel[0] - acceleration[0], *NOISE)


def distances(cells: Sequence[Cell], constant: bool = False) -> dict[str, Array]:
    """Return mean |dr| (cells,) in m by method, `kind` chosen by `sliding`, `half` of the path and its `peak` in m.

    The orientation is known. `constant`: the filters have their covariances for a constant r.
    """
    runs = [recorded(truth_of(c), c.seed, c.gyro_noise) for c in cells]
    acceleration = [removed(x, "known") for x in runs]
    true = np.stack([x.r for x in runs])
    gyro, felt, time = np.concatenate([x.gyro for x in runs]), np.concatenate(acceleration), runs[0].time
    done = {}
    for name, states in STATES.items():
        tracks = track(gyro, felt, time, states, covariances_of(name, "constant" if constant else "varying"))
        done[name] = _mean(tracks.r, true[:, tracks.first :])
    done["mrvs"] = _mean(mrvs.solve_differenced(gyro, felt, time)[0][:, None], true)
    half = frick_rahmatalla.HALF
    done[frick_rahmatalla.NAME] = _mean(frick_rahmatalla.follow(gyro, felt, time), true[:, half:-half])
    fitted = [sliding.best(rows_of(x, a)) for x, a in zip(runs, acceleration, strict=True)]
    answers = np.stack([sliding.answer(f, time)[0] for f in fitted])
    done[sliding.NAME] = _mean(answers, true)
    done["best constant"] = _mean(true.mean(axis=1, keepdims=True), true)
    done["kind"] = np.array([KINDS.index(f.name) for f in fitted])
    done["peak"] = np.array([np.linalg.norm(x.truth.displacement, axis=1).max() for x in runs])
    return done


def _mean(r: Array, true: Array) -> Array:
    return np.asarray(np.linalg.norm(r - true, axis=-1).mean(axis=-1))


def streamed(runs: Runs, acceleration: Array, window: float = sliding.WINDOW) -> Array:
    """Return r (n, 3) in m of the first run by `sliding-stream`."""
    stream = sliding.SlidingStream(*NOISE, window=window)
    samples = zip(runs.gyro[0], runs.accel[0], acceleration[0], strict=True)
    return np.array([stream.update(*x, 1 / RATE) for x in samples])


def banked(runs: Runs, acceleration: Array) -> Array:
    """Return r (n, 3) in m of the first run by the bank of filters with the slide in their state."""
    bank = SlidingBank()
    return np.array([bank.update(w, a, 1 / RATE) for w, a in zip(runs.gyro[0], acceleration[0], strict=True)])


def compared(runs: Runs, acceleration: Array, constant: bool = False) -> dict[str, Array]:
    """Return mean |dr| in m of ArVE_d, MrVS, `sliding` and, from SETTLED on, the filter and `sliding-stream`."""
    late = round(SETTLED * RATE)
    tracks = track(
        runs.gyro, acceleration, runs.time, 12, covariances_of("arve-d", "constant" if constant else "varying")
    )
    fit = sliding.best(rows_of(runs, acceleration))
    stream = streamed(runs, acceleration)
    return {
        "arve-d": _mean(tracks.r[0], runs.r[tracks.first :]),
        "arve-d late": _mean(tracks.r[0, late - tracks.first :], runs.r[late:]),
        "mrvs": _mean(mrvs.solve_differenced(runs.gyro[0], acceleration[0], runs.time)[0], runs.r),
        "sliding": _mean(sliding.answer(fit, runs.time)[0], runs.r),
        "stream": _mean(stream[late:], runs.r[late:]),
        "kind": np.array(KINDS.index(fit.name)),
        "residual": np.array(fit.noise),
    }


# --- what the estimator does not assume ---


Slide = tuple[Sines, Sines, Sines]


def slide(amplitude: ArrayLike, frequency: ArrayLike, phase: ArrayLike = 0.0) -> Slide:
    """Return a slide along SHAPE: amplitudes in m along x, frequencies in Hz, phases in rad, each (k,)."""
    x, y, z = (Sines(s * np.asarray(amplitude, dtype=float), frequency, phase) for s in SHAPE)
    return x, y, z


def many(rng: np.random.Generator, low: float, high: float, size: float) -> Slide:
    """Return 24 sines an axis from `low` to `high` Hz, of `size` m RMS along x and z."""
    x, y, z = (
        Sines(s * size * np.sqrt(2 / 24), rng.uniform(low, high, 24), rng.uniform(0, 2 * np.pi, 24)) for s in SHAPE
    )
    return x, y, z


def unassumed(name: str, seed: int) -> SensorTruth:
    """Play one of the cases that no model of `sliding` holds."""
    rng = np.random.default_rng([5, seed])
    rig = limb("sliding")
    if name == "pivot":
        return pendulum_truth(moving(ellipse(), gait(rng, scale=0.1)), DURATION, RATE)[1].sensors[0]
    if name == "uneven spring":
        rig = limb("sprung")
        mount = replace(rig.mounts[0], translation=springs(np.array([3.0, 4.0, 5.0]), DAMPING))
    else:
        paths = {
            "drift": slide(0.02, 0.04, float(rng.uniform(0, 2 * np.pi))),
            "beating": slide([0.01, 0.005, 0.005], [1.0, 0.75, 1.25], 0.4),
            "band": many(rng, 0.2, 3.0, 0.014),
        }
        mount = replace(rig.mounts[0], path=paths[name])
    return play(replace(rig, mounts=(mount,)), ellipse(), DURATION, RATE).sensors[0]


UNASSUMED = {
    "drift": "a slow wave of 20 mm, 0.04 Hz",
    "beating": "20 mm at 1 Hz, coming and going every 4 s",
    "band": "24 sines an axis from 0.2 to 3 Hz, 14 mm RMS",
    "uneven spring": "springs of 3, 4 and 5 Hz along x, y and z",
    "pivot": "r constant, the joint centre moves as a hip's by 0.3 m/s^2 RMS",
}
WAYS = ("told", "ukf")  # of taking gravity out when the orientation is not known
