"""Two million samples through every streaming estimator: rate and memory have to stay as they are.

    python -m benchmarks soaks                      all of them, one after the other
    python -m benchmarks.soaks SAMPLES [NAME ...]   some of them, or fewer samples

The limb and the hinge play the same pieces again and again, each time with fresh noise, so that the samples themselves
take no memory. A pendulum's pieces take turns with a sensor that is fixed, slides unfelt and felt, and hangs on a
spring. Only the estimator's processor time is counted. Other work on the machine makes that vary by a factor of two: so
over the last tenth a new estimator gets the same samples beside the old one, piece by piece, and the ratio of the two
tells whether time grows with the history.
"""

import ctypes
import gc
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.table import Row
from imubench import rotations
from imubench.arrays import Array
from imubench.estimators import frick_rahmatalla, guarded, plug_and_play, sliding, two_imu_centre
from imubench.estimators.arve import Arve
from imubench.estimators.arve_d import ArveD
from imubench.estimators.frick_rahmatalla import FrickRahmatalla
from imubench.estimators.gravity import GravityUkf
from imubench.estimators.guarded import GuardedPlugAndPlay
from imubench.estimators.mrvs import WindowMrvs
from imubench.estimators.plug_and_play import PlugAndPlay, Update, batches
from imubench.estimators.selection_online import OnlineSelection
from imubench.estimators.sliding import SlidingStream
from imubench.estimators.sliding_ekf import SlidingBank
from imubench.estimators.two_imu_centre import TwoImuCentre
from imubench.paired import Paired, paired
from imubench.recording import STANDARD_GRAVITY
from imubench.scenarios.moving_pivot import hip_mounts, pelvis, shared_centre
from imubench.scenarios.olsson2020.sequences import assemble
from imubench.scenarios.pendulum import SoftTissue, ellipse, limb
from imubench.sim.play import play
from imubench.sim.signals import Sines

SAMPLES = 2_000_000
PIECE = 30.0  # s of the pendulum: ten periods of its motion, which goes on in the next piece where it was
RATE = 100.0  # Hz, of the pendulum
NOISE = 0.0017, 0.02  # rad/s, m/s^2 per sample
KINDS: tuple[SoftTissue, ...] = ("none", "paper", "sliding", "sprung")
SLOWER = 1.25  # times the time of a new estimator, at most
GROWTH = 2.0  # MB of resident memory between the first tenth and the last, at most: what the fit in hand may hold
Piece = tuple[Array, ...]
"""Signals (n, 3) of one piece; of one IMU rates in rad/s, specific force and acceleration in m/s^2."""
Push = Callable[[Piece], Array]
"""Takes a piece and returns the last answer."""


def resident() -> float:
    """Return the resident memory of this process in MB, what the C library keeps of freed memory given back first.

    Without that a stream whose arrays all have other lengths seems to grow by 5 MB and more, and shrinks again.
    """
    gc.collect()
    with suppress(AttributeError, OSError):  # of glibc alone
        ctypes.CDLL(None).malloc_trim(0)
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def pendulum(rng: np.random.Generator) -> Iterator[Piece]:
    """Yield pieces of one IMU without end."""
    played = [play(limb(kind, frequency=2 / 3), ellipse(), PIECE, RATE).sensors[0] for kind in KINDS]
    true = [(t.gyro, t.specific_force, STANDARD_GRAVITY * rotations.to_matrix(t.quaternion)[:, 2]) for t in played]
    while True:
        for gyro, accel, up in true:
            f = accel + NOISE[1] * rng.normal(size=accel.shape)
            yield gyro + NOISE[0] * rng.normal(size=gyro.shape), f, f - up


def hip(rng: np.random.Generator) -> Iterator[Piece]:
    """Yield pieces of two IMUs on pelvis and thigh without end: rates of both, specific forces of both."""
    heave = {"z": Sines(0.02, 2.0)}  # m, Hz: twice a stride of 1 Hz
    truth = shared_centre((pelvis(stride=1.0), ellipse()), hip_mounts(rng), heave, PIECE, RATE)
    true = [x for key in ("gyro", "specific_force") for x in (getattr(s, key) for s in truth.sensors)]
    while True:
        yield tuple(
            x + std * rng.normal(size=x.shape) for x, std in zip(true, np.repeat(NOISE, 2).tolist(), strict=True)
        )


def hinge(rng: np.random.Generator) -> Iterator[Piece]:
    """Yield pieces of two IMUs without end: sequence 1 of Olsson 2020, 700 s at 50 Hz, in pieces of 50 s."""
    samples = paired(assemble("sequence1", seed=1).recording)
    parts = (samples.gyro1, samples.gyro2, samples.accel1, samples.accel2)
    while True:
        for first in range(0, samples.time.size, 2500):
            yield tuple(
                x[first : first + 2500] + std * rng.normal(size=x[first : first + 2500].shape)
                for x, std in zip(parts, (NOISE[0], NOISE[0], NOISE[1], NOISE[1]), strict=True)
            )


@dataclass(frozen=True)
class Soak:
    """One estimator: what it is fed, and how."""

    name: str
    pieces: Callable[[np.random.Generator], Iterator[Piece]]
    make: Callable[[], Push]


def by_sample(estimator: Callable[[Array, Array, Array], Array]) -> Push:
    """Return what pushes pieces of one IMU through an estimator of w, f and a."""

    def push(piece: Piece) -> Array:
        for w, f, a in zip(*piece, strict=True):
            answer = estimator(w, f, a)
        return answer

    return push


def sliding_stream() -> Push:
    """As docs/soft-tissue.md has it: gravity by the filter."""
    gravity, centre, step = GravityUkf(), SlidingStream(*NOISE), 1 / RATE
    return by_sample(lambda w, f, a: centre.update(w, f, gravity.update(w, f, step), step))


def of_acceleration(update: Callable[[Array, Array, float], Array]) -> Push:
    return by_sample(lambda w, f, a: update(w, a, 1 / RATE))


def window_mrvs() -> Push:
    centre, count = WindowMrvs(), iter(range(sys.maxsize))
    return by_sample(lambda w, f, a: centre.update(w, a, next(count) / RATE))


def gravity_filter() -> Push:
    gravity = GravityUkf()
    return by_sample(lambda w, f, a: gravity.update(w, f, 1 / RATE))


def second_by_second(update: Callable[[Paired], Update]) -> Push:
    def push(piece: Piece) -> Array:
        gyro1, gyro2, accel1, accel2 = piece
        for batch in batches(Paired(np.arange(len(gyro1)) / 50.0, gyro1, accel1, gyro2, accel2)):
            found = update(batch).estimate.value
        return found

    return push


def online_selection() -> Push:
    selection = OnlineSelection(1000)

    def push(piece: Piece) -> Array:
        for first in range(0, len(piece[0]), 50):
            selected = selection.update(*(x[first : first + 50] for x in piece))
        return selected.accel1

    return push


def two_imus() -> Push:
    centre = TwoImuCentre()

    def push(piece: Piece) -> Array:
        for w1, w2, f1, f2 in zip(*piece, strict=True):
            found = centre.update(np.array([w1, w2]), np.array([f1, f2]), 1 / RATE)
        return found

    return push


SOAKS = {
    soak.name: soak
    for soak in (
        Soak(f"{sliding.STREAM} with gravity-ukf", pendulum, sliding_stream),
        Soak("gravity-ukf", pendulum, gravity_filter),
        Soak("arve", pendulum, lambda: of_acceleration(Arve().update)),
        Soak("arve-d", pendulum, lambda: of_acceleration(ArveD().update)),
        Soak("mrvs-window", pendulum, window_mrvs),
        Soak(frick_rahmatalla.NAME, pendulum, lambda: of_acceleration(FrickRahmatalla(np.zeros(3)).update)),
        Soak("sliding filter bank", pendulum, lambda: of_acceleration(SlidingBank().update)),
        Soak(plug_and_play.NAME, hinge, lambda: second_by_second(PlugAndPlay().update)),
        Soak(guarded.NAME, hinge, lambda: second_by_second(GuardedPlugAndPlay().update)),
        Soak("online selection, survivors", hinge, online_selection),
        Soak(two_imu_centre.NAME, hip, two_imus),
    )
}


def timed(push: Push, piece: Piece) -> tuple[float, Array]:
    """Return the processor time in s that a piece takes, and the last answer."""
    start = time.process_time()
    answer = push(piece)
    return time.process_time() - start, answer


def run_one(soak: Soak, samples: int = SAMPLES) -> Row:
    """Push samples through one estimator; `ValueError` for fewer than 100,000, a tenth of which is a few pieces."""
    if samples < 100_000:
        raise ValueError(f"samples: expected 100000 or more, got {samples}")
    push, pieces = soak.make(), soak.pieces(np.random.default_rng(1))
    tenth, done, young = samples // 10, 0, None
    took: dict[str, list[float]] = {name: [0.0, 0.0] for name in ("first", "last", "beside", "new")}
    before = after = 0.0
    while done < samples:
        piece = next(pieces)
        (seconds, answer), count = timed(push, piece), len(piece[0])
        if done >= samples - tenth:
            parts = [("last", seconds)]
            if young is None:  # one piece to warm up
                after, young = resident(), soak.make()
                timed(young, piece)
            else:
                parts += [("beside", seconds), ("new", timed(young, piece)[0])]
        else:
            parts = [("first", seconds)] if done < tenth else []
        for name, s in parts:
            took[name] = [took[name][0] + s, took[name][1] + count]
        done += count
        if done >= tenth and not before:
            before = resident()
    rate = {name: count / seconds for name, (seconds, count) in took.items()}
    ratio, growth = rate["new"] / rate["beside"], after - before
    return Row(
        f"{soak.name}, {done:,} samples: per processor second in the last tenth, in the first",
        f"{rate['last']:,.0f}",
        f"{rate['first']:,.0f}",
        f"{ratio:.2f} of a new one's time; {growth:+.1f} MB",
        f"<= {SLOWER:g}; <= {GROWTH:g} MB",
        bool(np.isfinite(answer).all()) and ratio <= SLOWER and growth <= GROWTH,
    )


def run(samples: int = SAMPLES, names: Sequence[str] = ()) -> list[Row]:
    """Return a row for each estimator."""
    return [run_one(SOAKS[name], samples) for name in names or SOAKS]


if __name__ == "__main__":
    for one in sys.argv[2:] or SOAKS:
        row = run_one(SOAKS[one], int(sys.argv[1]))
        print(f"| {row.what} | {row.ours} | {row.peer} | {row.ratio} | {row.required} | {row.met} |", flush=True)
