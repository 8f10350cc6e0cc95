"""Where plug and play stops: the error over sensor biases, over soft mounts, over a time offset between the IMUs.

Every map but one is of the whole method, N_max = 500 samples and Algorithm 1, at the end of a sequence; that one has
soft mounts again, with all samples below a band that `olsson2020-banded` chooses. A map is made once a seed, coarse to
fine: a grid of every other level first, then the levels between, but only in those cells whose corners leave open on
which side of LIMIT they lie. The others are interpolated. A point that cannot be played, because springs do not hold
the sensor there, has no error: NaN.
"""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator

from imubench.arrays import Array
from imubench.estimators import banded
from imubench.recording import Recording
from imubench.reproduce.olsson2020.imperfection_runs import SHORT, end_axes
from imubench.reproduce.olsson2020.imperfections import NOMINAL, soft_mounts
from imubench.reproduce.paper import Arrays, Part
from imubench.scenarios.olsson2020.motions import paper_rig
from imubench.scenarios.olsson2020.plan import SEQUENCES as PLANS
from imubench.scenarios.olsson2020.sequences import add_bias, join
from imubench.scenarios.olsson2020.session import Session, record
from imubench.score import axis_deviation, rmsae
from imubench.sim.profiles import profile
from imubench.sim.sprung import UnheldSensorError

LIMIT = np.deg2rad(3.0)  # E_max of section 7.4
OPEN = 0.4, 2.5  # of LIMIT: a cell with corners on both sides of these, or between them, is refined
SHOWN = ("sequence1", "sequence3")  # all motions; and one that is informative for 20 s only
SHORTEST = dict.fromkeys(range(1, 15), 10.0) | {6: 20.0}  # s; where fine steps make the simulation slow
GYRO = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0)  # deg/s
ACCEL = (0.5, 1.0, 2.0, 4.0, 8.0, 11.0, 16.0)  # m/s^2
FREQUENCY = (4.2, 5.0, 6.0, 7.1, 8.5, 12.0, 17.0)  # Hz; softer ones hang over by more than small angles
DAMPING = (0.05, 0.1, 0.2, 0.4, 0.8)
OFFSET = (-50.0, -40.0, -30.0, -20.0, -10.0, -5.0, 0.0, 5.0, 10.0, 20.0, 30.0, 40.0, 50.0)  # ms

Point = Callable[[float, float], Array]
"""RMSAE in rad for each sequence of SHOWN, at a point of a map; `UnheldSensorError` where that cannot be played."""


@dataclass(frozen=True)
class Extent:
    """How much of the maps is computed."""

    gyro: tuple[float, ...]
    accel: tuple[float, ...]
    frequency: tuple[float, ...]
    damping: tuple[float, ...]
    offset: tuple[float, ...]
    bias_seeds: int
    soft_seeds: int
    offset_seeds: int


FULL = Extent(GYRO, ACCEL, FREQUENCY, DAMPING, OFFSET, 6, 2, 3)
QUICK = Extent(GYRO[::3], ACCEL[::3], (4.2, 8.5), (0.1, 0.8), (-50.0, 0.0, 50.0), 1, 1, 1)


@dataclass(frozen=True)
class Map:
    """The error over one or two things; a map over one has a single column."""

    name: str
    x: Array  # (a,)
    y: Array  # (b,)
    error: Array  # (2, a, b) rad, for SHOWN; root mean square over the seeds, NaN where one of them cannot be played
    computed: Array  # (a, b) part of the seeds for which the point was computed, not interpolated

    @property
    def played(self) -> NDArray[np.bool_]:
        """Which points (a, b) have an error, bool."""
        return np.asarray(np.isfinite(self.error[0]))


def error_of(recording: Recording, rng: np.random.Generator) -> float:
    """Return the RMSAE in rad over three starts of Algorithm 1 on selected samples."""
    return rmsae(axis_deviation(end_axes(recording, rng, 3), NOMINAL))


def _of_session(session: Session, seed: int) -> Array:
    rng = np.random.default_rng([seed, 6])
    return np.array([error_of(join(PLANS[n], session).recording, rng) for n in SHOWN])


def bias_map(seed: int, gyro: tuple[float, ...], accel: tuple[float, ...]) -> Arrays:
    """Return `error` (2, a, b) and `computed` (a, b) over biases in deg/s and m/s^2 in directions of the seed."""
    session = record(seed, durations=SHORT)
    sequences = [join(PLANS[n], session).recording for n in SHOWN]

    def at(gyro_bias: float, accel_bias: float) -> Array:
        errors = []
        for recording in sequences:
            rng = np.random.default_rng([seed, 7])  # the same directions at every point
            errors.append(error_of(add_bias(recording, rng, np.deg2rad(gyro_bias), accel_bias), rng))
        return np.array(errors)

    return coarse_to_fine(at, np.array(gyro), np.array(accel))


def soft_map(seed: int, frequency: tuple[float, ...], damping: tuple[float, ...]) -> Arrays:
    """Return `error` (2, a, b) and `computed` (a, b) over frequency in Hz and damping ratio of both soft mounts."""

    def at(hertz: float, ratio: float) -> Array:
        rig = paper_rig(mounts=soft_mounts(hertz, ratio))
        return _of_session(record(seed, rig, durations=SHORTEST), seed)

    return coarse_to_fine(at, np.array(frequency), np.array(damping))


def banded_map(seed: int, frequency: tuple[float, ...], damping: tuple[float, ...]) -> Arrays:
    """Return as `soft_map`, at every point, of `olsson2020-banded`: all samples, below a band of its own choosing.

    `error` is NaN at a point that cannot be played.
    """
    error = np.full((len(SHOWN), len(frequency), len(damping)), np.nan)
    for i, hertz in enumerate(frequency):
        for k, ratio in enumerate(damping):
            with suppress(UnheldSensorError):
                session = record(seed, paper_rig(mounts=soft_mounts(hertz, ratio)), durations=SHORTEST)
                axes = [banded.estimate(join(PLANS[n], session).recording).value for n in SHOWN]
                error[:, i, k] = [rmsae(axis_deviation(a, NOMINAL)) for a in axes]
    return {"error": error, "computed": np.ones((len(frequency), len(damping)))}


def offset_line(seed: int, offset: tuple[float, ...]) -> Arrays:
    """Return `error` (2, a, 1) over the offset in ms of imu2's stamps, and `computed` (a, 1), all ones."""
    errors = []
    for milliseconds in offset:
        late = replace(profile("xsens_mtw"), clock_offset=1e-3 * milliseconds)
        session = record(seed, imus={"imu1": profile("xsens_mtw"), "imu2": late}, durations=SHORTEST)
        errors.append(_of_session(session, seed))
    return {"error": np.array(errors).T[:, :, None], "computed": np.ones((len(offset), 1))}


def coarse_to_fine(at: Point, x: Array, y: Array) -> Arrays:
    """Return `error` (2, a, b) over levels x (a,) and y (b,), and which points (a, b) were `computed`.

    Every other level comes first, and the last; the others only where the corners around leave LIMIT open, or one of
    them cannot be played. `error` is NaN at a point that cannot.
    """
    error = np.full((len(SHOWN), x.size, y.size), np.nan)
    computed = np.zeros((x.size, y.size), dtype=bool)

    def compute(i: int, k: int) -> None:
        computed[i, k] = True
        with suppress(UnheldSensorError):
            error[:, i, k] = at(x[i], y[k])

    rows, columns = _every_other(x.size), _every_other(y.size)
    for i in rows:
        for k in columns:
            compute(i, k)
    coarse = np.log(error[:, rows][:, :, columns])
    fine = np.stack(np.meshgrid(np.log(x), np.log(y), indexing="ij"), axis=-1)
    rough = np.array([RegularGridInterpolator((np.log(x[rows]), np.log(y[columns])), c)(fine) for c in coarse])
    for i, k in np.argwhere(~computed):
        around = coarse[:, _neighbours(rows, i)][:, :, _neighbours(columns, k)].reshape(len(SHOWN), -1)
        low, high = around.min(axis=1), around.max(axis=1)
        settled = (low >= np.log(OPEN[1] * LIMIT)) | (high <= np.log(OPEN[0] * LIMIT))  # not where one is NaN
        if not settled.all():
            compute(i, k)
    return {"error": np.where(computed, error, np.exp(rough)), "computed": computed.astype(float)}


def _every_other(count: int) -> list[int]:
    return list(range(count)) if count < 4 else sorted({*range(0, count, 2), count - 1})


def _neighbours(places: list[int], at: int) -> list[int]:
    """Return the positions in `places` that enclose the level number `at`."""
    after = int(np.searchsorted(places, at))
    return [after] if places[after] == at else [after - 1, after]


def banded_levels(e: Extent) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the frequencies in Hz and damping ratios of the banded map: every other one, and the last."""
    x, y = (tuple(v[i] for i in _every_other(len(v))) for v in (e.frequency, e.damping))
    return x, y


def parts(e: Extent) -> list[Part]:
    """Return all the work of the maps."""
    todo = []
    for seed in range(e.soft_seeds):
        arguments = {"seed": seed, "frequency": e.frequency, "damping": e.damping}
        todo.append(Part(f"map-soft-{seed}", "soft-mount map", 5 * sum(e.frequency), soft_map, arguments))
        x, y = banded_levels(e)
        arguments = {"seed": seed, "frequency": x, "damping": y}
        todo.append(Part(f"map-banded-{seed}", "soft-mount map", 10.0 * len(x) * len(y), banded_map, arguments))
    for seed in range(e.offset_seeds):
        arguments = {"seed": seed, "offset": e.offset}
        todo.append(Part(f"map-offset-{seed}", "time-offset map", 1.0 * len(e.offset), offset_line, arguments))
    for seed in range(e.bias_seeds):
        arguments = {"seed": seed, "gyro": e.gyro, "accel": e.accel}
        todo.append(Part(f"map-bias-{seed}", "bias map", 0.2 * len(e.gyro) * len(e.accel), bias_map, arguments))
    return todo


def gather(e: Extent, done: Mapping[str, Arrays]) -> dict[str, Map]:
    """Return the maps `bias`, `soft`, `banded` and `offset` from the finished parts."""
    grids = {
        "bias": (e.gyro, e.accel, e.bias_seeds),
        "soft": (e.frequency, e.damping, e.soft_seeds),
        "banded": (*banded_levels(e), e.soft_seeds),
        "offset": (e.offset, (0.0,), e.offset_seeds),
    }
    maps = {}
    for name, (x, y, seeds) in grids.items():
        found = [done[f"map-{name}-{seed}"] for seed in range(seeds)]
        error = np.sqrt(np.mean([f["error"] ** 2 for f in found], axis=0))
        maps[name] = Map(name, np.array(x), np.array(y), error, np.mean([f["computed"] for f in found], axis=0))
    return maps
