"""Below a band that the data choose: how far off, and do regions hold the truth?  python -m benchmarks.banded [RUNS]

Each run is another rig, hand and IMU pair: every fifth rig is rigid, every fifth has IMUs on springs that let them
shift, the others have IMUs that rock, at 5 to 20 Hz, damped by 0.03 to 0.5. Hands move up to 0.5, 1 or 2 Hz, with or
without a tremor. The truth is the mean axis: a mount that gives way takes the axis along.
`python -m benchmarks.banded filtering` prints what filters alone do to rigid rigs without noise.
"""

import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.table import Row
from imubench.arrays import Array
from imubench.estimate import Estimate
from imubench.estimators import banded, olsson2020
from imubench.estimators.band_fits import band_fit, gyro_noise
from imubench.estimators.carried import below, filtered, runs_below
from imubench.estimators.olsson2020 import deviation
from imubench.paired import paired
from imubench.recording import Recording
from imubench.run import estimate
from imubench.scenarios.scenario import declared_mounts
from imubench.sim.imu_model import Declared, observe
from imubench.sim.motion import AngleMotion
from imubench.sim.play import play
from imubench.sim.profiles import profile
from imubench.sim.rigs import Mount, Rig, random_hinge, springs
from imubench.sim.signals import Signal, hand

CHI_SQUARE = 9.488  # 95 % of chi-square with 4 degrees of freedom
RUNS, LEAST, MOST = 200, 90.0, 99.0  # rigs; % of them
KINDS = ("rigid", "rocking", "rocking", "rocking", "shifting")
RATE = 400.0  # Hz of the simulation
TREMOR = 10.0  # Hz
COM, LEVER = 0.0015, 0.02  # m, of an IMU that rocks: its centre of mass off the pivot, and the most it sits above it


@dataclass(frozen=True)
class Case:
    """A recording, the mean hinge axes in its sensors' axes, and what it is."""

    recording: Recording
    axes: Array  # (2, 3)
    kind: str
    hand: float  # Hz


def case(seed: int) -> Case:
    """Return the recording of a seed: a random rig of the kind whose turn it is."""
    rng = np.random.default_rng([62, seed])
    kind, bandwidth, seconds = KINDS[seed % len(KINDS)], float(rng.choice([0.5, 1.0, 2.0])), float(rng.choice([30, 60]))
    rig = _mounted(random_hinge(rng), kind, rng)
    truth = play(rig, _motion(rng, seconds, bandwidth, float(rng.choice([0.0, 0.003, 0.01]))), seconds, RATE, threads=1)
    imu = profile("xsens_mtw")
    if rng.uniform() < 0.5:  # gyroscopes at rest before, as the paper's
        imu = replace(imu, gyro=replace(imu.gyro, bias_std=0.0))
    recording = observe(truth, imu, rng, f"banded-{seed}", Declared(mounts=declared_mounts(rig, rng)))
    axes = np.stack([s.joint_axis.mean(axis=0) for s in truth.sensors if s.joint_axis is not None])
    return Case(recording, axes / np.linalg.norm(axes, axis=1, keepdims=True), kind, bandwidth)


def _mounted(rig: Rig, kind: str, rng: np.random.Generator) -> Rig:
    frequency, damping = 5.0 * 4.0 ** rng.uniform(), 0.03 * 16.0 ** rng.uniform()

    def soft(mount: Mount) -> Mount:
        spring = springs(frequency * np.exp(rng.uniform(-0.25, 0.25, size=3)), damping)
        if kind == "shifting":
            return replace(mount, translation=spring)
        lever = np.array([0.0, 0.0, rng.uniform(0.0, LEVER)])
        return replace(mount, rotation=spring, com=rng.normal(scale=COM, size=3), lever=lever)

    return rig if kind == "rigid" else replace(rig, mounts=tuple(soft(mount) for mount in rig.mounts))


def _motion(rng: np.random.Generator, seconds: float, bandwidth: float, tremor: float) -> AngleMotion:
    def signal(std: float, offset: float = 0.0) -> Signal:
        slow, quick = hand(rng, seconds, std, bandwidth, offset), hand(rng, seconds, max(std * tremor, 1e-9), TREMOR)

        def both(time: Array) -> tuple[Array, Array, Array]:
            value, first, second = (a + b for a, b in zip(slow(time), quick(time), strict=True))
            return value, first, second

        return both

    heading, tilt, spin, angle = signal(0.8), signal(0.4), signal(0.8), signal(0.7, 0.6)
    return AngleMotion(
        heading=heading, tilt=tilt, spin=spin, angle=angle, x=signal(0.1), y=signal(0.1), z=signal(0.05, 1.0)
    )


@dataclass(frozen=True)
class Run:
    """What became of a case."""

    case: Case
    banded: Estimate
    all: Estimate  # by `olsson2020` on all samples

    @property
    def errors(self) -> tuple[float, float]:
        """The larger error of both axes in deg: banded, and of all samples."""
        banded, plain = (float(np.degrees(deviation(e.value, self.case.axes))) for e in (self.banded, self.all))
        return banded, plain

    @property
    def inside(self) -> bool:
        """Whether the 95 % region of the banded estimate holds the truth."""
        if self.banded.covariance is None:
            return False
        sign = 1.0 if np.sum(self.banded.value * self.case.axes) > 0 else -1.0
        off = (sign * self.case.axes - self.banded.value).ravel()
        return bool(off @ np.linalg.pinv(self.banded.covariance, rcond=1e-9, hermitian=True) @ off < CHI_SQUARE)


def runs(seeds: range) -> Iterator[Run]:
    for seed in seeds:
        one = case(seed)
        yield Run(one, banded.estimate(one.recording), olsson2020.estimate(one.recording))


def run(count: int = RUNS) -> list[Row]:
    """Return rows of coverage and of error, for rigid rigs and for soft ones."""
    done = list(runs(range(count)))
    rows = []
    for what, kinds in (("rigid", ("rigid",)), ("shifting", ("shifting",)), ("rocking", ("rocking",))):
        some = [one for one in done if one.case.kind in kinds]
        said = [one for one in some if one.banded.status == "converged"]
        held = 100 * float(np.mean([one.inside for one in said]))
        ours, peer = np.array([one.errors for one in said]).T
        cells = (f"{np.median(e):.2f}, {np.quantile(e, 0.9):.2f}, {e.max():.2f}" for e in (ours, peer))
        name = f"axes of {what} IMUs, {len(said)} of {len(some)} rigs converged"
        rows.append(Row(f"{name}: truth in the 95 % region", f"{held:.0f} %", "-", "-", "90 to 100 %", held >= LEAST))
        better = float(np.median(ours) / np.median(peer))
        rows.append(
            Row(
                f"{name}: error in deg, median, 90 % and worst; peer: olsson2020 on all samples",
                *cells,
                f"{better:.2f}",
                "<= 1" if what == "rocking" else "<= 1.25",
                better <= (1.0 if what == "rocking" else 1.25),
            )
        )
    return rows


HANDS, BANDS = (0.5, 1.0, 2.0, 4.0), (8.0, 4.0, 3.0, 2.0, 1.0)  # Hz


def filtering(seeds: int) -> None:
    """Print what a filter does to rigid rigs without noise, each sensor in its own axes, and carried into one frame."""
    print("| hand, Hz | what |" + "".join(f" {hz:g} Hz |" for hz in BANDS))
    print("|---|---|" + "---:|" * len(BANDS))
    for bandwidth in HANDS:
        found = np.array([[_filtered(seed, bandwidth, hz) for hz in BANDS] for seed in range(seeds)])
        names = (
            "own axes: error, deg",
            "own axes: hinge leaves, rad/s",
            "carried: error, deg",
            "carried: hinge leaves, rad/s",
            "accelerations along the axis differ by, m/s^2",
        )
        for name, values in zip(names, np.median(found, axis=0).T, strict=True):
            print(f"| {bandwidth:g} | {name} |" + "".join(f" {v:.2g} |" for v in values), flush=True)


def _filtered(seed: int, bandwidth: float, hz: float) -> tuple[float, ...]:
    rng = np.random.default_rng([63, seed])
    rig = random_hinge(rng)
    truth = play(rig, _motion(rng, 30.0, bandwidth, 0.0), 30.0, RATE, threads=1)
    imu = replace(profile("perfect"), rate=100.0)
    recording = observe(truth, imu, rng, "clean", Declared(mounts=declared_mounts(rig, rng)))
    axes = np.stack([s.joint_axis[0] for s in truth.sensors if s.joint_axis is not None])
    own = estimate("seel2012", recording, hz)
    carried = band_fit(paired(recording), hz, gyro_noise(recording))
    mine = np.degrees(np.arccos(np.clip(np.abs(np.sum(own.value * axes, axis=1)), 0.0, 1.0)).max())
    pieces = runs_below(paired(recording), hz)
    frames = np.stack([np.linalg.qr(np.c_[axis, np.eye(3)[:, :2]])[0].T for axis in axes])
    frames *= np.sign(np.sum(frames[:, :1] * axes[:, None], axis=2, keepdims=True))
    frames[:, 2] = np.cross(frames[:, 0], frames[:, 1])
    at = below(pieces, frames)
    left = np.linalg.norm(at.rates[0, :, 1:], axis=1) - np.linalg.norm(at.rates[1, :, 1:], axis=1)
    few = filtered(pieces)
    apart = np.linalg.norm(np.cross(few.gyro1, axes[0]), axis=1) - np.linalg.norm(np.cross(few.gyro2, axes[1]), axis=1)
    forces = at.forces[0, :, 0] - at.forces[1, :, 0]
    rms = [float(np.sqrt(np.mean(x**2))) for x in (apart, left, forces)]
    return float(mine), rms[0], float(np.degrees(deviation(carried.axes, axes))), rms[1], rms[2]


def main(count: int, first: int) -> None:
    """Print every run, then the rows."""
    print("| seed | kind | hand, Hz | band, Hz | error, deg | of all samples | 2 sigma, deg | inside |")
    print("|---:|---|---:|---:|---:|---:|---:|---|")
    for seed, one in zip(range(first, first + count), runs(range(first, first + count)), strict=True):
        d = one.banded.details
        sure = np.degrees(max(d.get("uncertainty_1", np.pi), d.get("uncertainty_2", np.pi)))
        ours, plain = one.errors
        print(
            f"| {seed} | {one.case.kind} | {one.case.hand:g} | {d['band']:.3g} | {ours:.2f} | {plain:.2f} | {sure:.2f} "
            f"| {'yes' if one.inside else 'no'} |",
            flush=True,
        )


if __name__ == "__main__" and sys.argv[1:2] == ["filtering"]:
    filtering(int(sys.argv[2]) if len(sys.argv) > 2 else 5)
elif __name__ == "__main__":
    main(*(int(x) for x in (*sys.argv[1:], *("60", "0")[len(sys.argv) - 1 :])))
