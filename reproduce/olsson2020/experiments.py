"""The experiments of sections 7.2 to 7.5, cut into parts of some seconds. Every function runs in any process.

Random numbers belong to what they are for (experiment, sequence, second or run), not to the part that draws
them: how the work is cut changes no result.
"""

import io
from contextlib import redirect_stdout
from itertools import product

import numpy as np

from imubench.arrays import Array
from imubench.estimators.hinge_constraints import weigh
from imubench.estimators.olsson2020 import algorithm1
from imubench.estimators.plug_and_play import uniform_start
from imubench.estimators.spherical import coordinates
from imubench.estimators.uncertainty import Acceptance
from imubench.paired import paired
from imubench.reproduce.olsson2020 import data
from imubench.reproduce.olsson2020.settings import (
    ACCEL_BIAS,
    BIAS_E_MAX,
    BIAS_N_MIN,
    E_MAX,
    GYRO_BIAS,
    N_MAX,
    N_MINS,
    SEQUENCES,
)
from imubench.reproduce.olsson2020.solving import Minima
from imubench.reproduce.paper import Arrays
from imubench.scenarios.olsson2020.sequences import add_bias
from imubench.score import axis_deviation

GRID_POINTS = np.concatenate([np.eye(3), -np.eye(3)])
SELECTING, RUNNING, BIASED, ELSEWHERE = 1, 2, 3, 4  # keep the random numbers of the experiments apart


def random_for(experiment: int, name: str, seed: int, number: int) -> tuple[np.random.Generator, np.random.Generator]:
    """Return the generators of starts and of Monte Carlo draws, for a second or a run of a sequence."""
    starts, draws = np.random.default_rng([seed, experiment, SEQUENCES.index(name), number]).spawn(2)
    return starts, draws


def grid_starts(count: int) -> Array:
    """Return starts (count, 4) from section 7.2's 36 pairs of axes, evenly picked: both pairings alike."""
    pairs = list(product(GRID_POINTS, repeat=2))
    return np.array([coordinates(np.array(pairs[k * len(pairs) // count])) for k in range(count)])


def weights(count: int) -> Array:
    """Return `count` values of w0, logarithmic from 1e-3 to 1e10 (section 7.2)."""
    return np.logspace(-3, 10, count)


def cost_surface(seed: int, number: int, degrees: float) -> Arrays:
    """Return both sums of squares of eq. (23) over (theta2, phi2), the first axis true (figure 2).

    `gyro` and `accel` (a, b) in rad^2/s^2 and m^2/s^4, over `theta` (a,) and `phi` (b,) in rad.
    """
    samples, true = data.motion(number, seed), data.session(seed).axes
    theta = np.deg2rad(np.arange(-90.0, 90.0 + degrees / 2, degrees))
    phi = np.deg2rad(np.arange(-90.0, 270.0 + degrees / 2, degrees))
    rate1 = np.linalg.norm(np.cross(samples.gyro1, true[0]), axis=1)
    force1 = samples.accel1 @ true[0]
    gyro, accel = np.empty((theta.size, phi.size)), np.empty((theta.size, phi.size))
    for i, t in enumerate(theta):
        axes = np.stack([np.cos(t) * np.cos(phi), np.cos(t) * np.sin(phi), np.full_like(phi, np.sin(t))])
        along = samples.gyro2 @ axes
        across = np.sqrt(np.maximum(np.sum(samples.gyro2**2, axis=1)[:, None] - along**2, 0.0))
        gyro[i] = np.sum((rate1[:, None] - across) ** 2, axis=0)
        accel[i] = np.sum((force1[:, None] - samples.accel2 @ axes) ** 2, axis=0)
    return {"theta": theta, "phi": phi, "gyro": gyro, "accel": accel}


def weighting(seed: int, number: int, w0: Array, starts: int) -> Arrays:
    """Return the deviations (weights, starts, 2) in rad of Algorithm 1 on all samples of a motion (figure 5)."""
    samples, true = data.motion(number, seed), data.session(seed).axes
    found = []
    for ratio in w0:
        c = weigh(
            samples.gyro1, samples.gyro2, samples.accel1, samples.accel2, np.sqrt(ratio), 1.0 / np.sqrt(ratio)
        )  # eq. (70)
        found.append([algorithm1(c, start)[0].axes for start in grid_starts(starts)])
    return {"deviation": axis_deviation(np.array(found), true)}


def authors_weighting(seed: int, number: int, w0: Array, starts: int) -> Arrays:
    """Return what `weighting` returns, by the authors' own code as ported in qmt, where that is installed."""
    import qmt

    samples, true = data.motion(number, seed), data.session(seed).axes
    arrays = [np.array(a) for a in (samples.accel1, samples.accel2, samples.gyro1, samples.gyro2)]
    found = []
    for ratio in w0:
        for start in grid_starts(starts):
            options = {"w0": float(ratio), "x0": start.reshape(-1, 1), "quiet": True}
            with redirect_stdout(io.StringIO()):  # it prints every step
                pair = qmt.jointAxisEstHingeOlsson(*arrays, options)[:2]
            found.append([np.asarray(axis, dtype=float).ravel() for axis in pair])
    return {"deviation": axis_deviation(np.array(found).reshape(len(w0), starts, 2, 3), true)}


def over_time(seed: int, name: str, n_max: int, every: int) -> Arrays:
    """Return the deviations (t, 2) in rad of an estimate each `every` s, all from random starts (figure 6).

    `n_max` = 0 takes all samples so far.
    """
    whole = data.sequence(name, seed)
    samples = paired(whole.recording)
    found = []
    for k in data.whole_seconds(whole)[every - 1 :: every]:
        if n_max:
            c = data.weighed(data.selections(name, seed, n_max)[k])
        else:
            c = data.weighed_until(samples, int(np.searchsorted(samples.time, k + 1 - 1e-6)))
        found.append(algorithm1(c, uniform_start(random_for(SELECTING, name, seed, k)[0]))[0].axes)
    return {"deviation": axis_deviation(np.array(found), whole.axes)}


def selected(seed: int, name: str, n_max: int) -> Arrays:
    """Return the numbers (seconds, n_max) of the samples held after each second, -1 beyond their count (figure 7)."""
    chosen = data.selections(name, seed, n_max)
    held = {"gyro": np.full((len(chosen), n_max), -1), "accel": np.full((len(chosen), n_max), -1)}
    for k, one in enumerate(chosen):
        held["gyro"][k, : one.gyro.size] = one.gyro
        held["accel"][k, : one.accel.size] = one.accel
    return dict(held)


def runs(seed: int, name: str, n_max: int, first: int, last: int, count: int) -> Arrays:
    """Return `axes` (seconds, runs, 2, 3) and `local` (seconds, runs, 2) in rad of seconds [first, last) (section 7.4).

    All runs see the same samples, each starts somewhere else in every second.
    """
    axes, local = np.empty((last - first, count, 2, 3)), np.empty((last - first, count, 2))
    for k, chosen in enumerate(data.selections(name, seed, n_max)[first:last]):
        starts, draws = random_for(RUNNING, name, seed, first + k)
        minima = Minima(data.weighed(chosen), draws)
        for m in range(count):
            axes[k, m], local[k, m] = minima.estimate(uniform_start(starts))
    return {"axes": axes, "local": local}


def biased_runs(seed: int, name: str, n_max: int, first: int, last: int) -> Arrays:
    """Return what `runs` returns, for runs [first, last), every run with biases of its own (section 7.5).

    A run ends where Algorithm 4 accepts; what would come after is NaN.
    """
    whole = data.sequence(name, seed)
    seconds = len(data.whole_seconds(whole))
    axes, local = np.full((seconds, last - first, 2, 3), np.nan), np.full((seconds, last - first, 2), np.nan)
    for m in range(first, last):
        starts, draws = random_for(BIASED, name, seed, m)
        recording = add_bias(whole.recording, starts, GYRO_BIAS, ACCEL_BIAS)
        judge = Acceptance(BIAS_E_MAX, BIAS_N_MIN)
        for k, chosen in enumerate(data.select_all(recording, n_max)):
            found = Minima(data.weighed(chosen), draws).estimate(uniform_start(starts))
            axes[k, m - first], local[k, m - first] = found
            if judge.update(*found).accepted:
                break
    return {"axes": axes, "local": local}


def other_session(seed: int, name: str, session: int, count: int) -> Arrays:
    """Return what `runs` returns for `count` runs in another session, until all are accepted with each n_min of 8.3.

    The session is the one of seed `seed` + `session`; what would come after is NaN.
    """
    whole = data.sequence(name, seed + session)
    axes, local = (np.full((len(data.whole_seconds(whole)), count, *shape), np.nan) for shape in ((2, 3), (2,)))
    judges = [Acceptance(E_MAX, max(N_MINS)) for _ in range(count)]
    waiting = np.ones(count, dtype=bool)
    for k, chosen in enumerate(data.select_all(whole.recording, N_MAX)):
        starts, draws = random_for(ELSEWHERE, name, seed + session, k)
        minima = Minima(data.weighed(chosen), draws)
        for m in range(count):
            axes[k, m], local[k, m] = minima.estimate(uniform_start(starts))
            waiting[m] &= not judges[m].update(axes[k, m], local[k, m]).accepted
        if not waiting.any():
            break
    return {"axes": axes, "local": local}
