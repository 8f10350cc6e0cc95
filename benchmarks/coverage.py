"""Do the 95 % regions of Algorithm 4's estimates hold the truth?  python -m benchmarks.coverage [RUNS]

Each run is another rig, motion and noise. A region is that of the first accepted estimate, at the time it is accepted.
"""

import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.hinge_rigs import HingeRig, random_rig
from benchmarks.table import Row
from imubench.arrays import Array
from imubench.estimators.guarded import Guard, bias_spread, jackknife_spread
from imubench.estimators.hinge_fit import covariance
from imubench.estimators.plug_and_play import Fit, PlugAndPlay, Settings, batches
from imubench.estimators.uncertainty import deviations, paper_covariance, two_sigma
from imubench.paired import Paired
from imubench.rotations import exp, rotate

NOISE = 0.0044, 0.015  # rad/s, m/s^2 a sample: an MTw at 50 Hz
CHI_SQUARE = 9.488  # 95 % of chi-square with 4 degrees of freedom
RATE, COUNT = 50.0, 2000
GYRO_BIAS, ACCEL_BIAS = np.deg2rad(0.5), 0.1  # rad/s, m/s^2: norms, as the paper's sensors have
ROCKING = 0.05  # rad, rms, of a mount that leans as its specific force does

REGIONS = "ellipsoid", "mu + 2 sigma of both axes"
RUNS, LEAST, MOST = 500, 90.0, 99.0  # rigs; % of them

Make = Callable[[int], HingeRig]
Covariances = dict[str, Array | None]


def rig(seed: int, **options: float) -> HingeRig:
    """Return a noisy rig; `planar` with every other seed."""
    planar = bool(options.pop("planar", 0.0))
    clean = random_rig(np.random.default_rng([1, seed]), COUNT, RATE, planar=planar, **({"lever": 0.0} | options))  # type: ignore[arg-type]
    return clean.noisy(np.random.default_rng([2, seed]), *NOISE)


def biased(seed: int) -> HingeRig:
    """Return a rig whose four sensors have biases of the paper's size, in any direction."""
    one, rng = rig(seed), np.random.default_rng([3, seed])
    b = rng.normal(size=(2, 2, 1, 3))
    b /= np.linalg.norm(b, axis=-1, keepdims=True)
    return replace(one, gyro=one.gyro + GYRO_BIAS * b[0], accel=one.accel + ACCEL_BIAS * b[1])


def leaning(seed: int) -> HingeRig:
    """Return a rig whose second sensor leans on its foam in proportion to the specific force, without delay."""
    one, rng = rig(seed), np.random.default_rng([4, seed])
    com = rng.normal(size=3)
    lean = np.cross(com, one.accel[1])
    lean *= ROCKING / np.sqrt(np.mean(np.sum((lean - lean.mean(axis=0)) ** 2, axis=1)))
    lean -= lean.mean(axis=0)  # of the mean lean, nothing can be known
    turn = exp(-lean)
    rates = rotate(turn, one.gyro[1]) + np.gradient(lean, one.time, axis=0)
    return replace(one, gyro=np.stack([one.gyro[0], rates]), accel=np.stack([one.accel[0], rotate(turn, one.accel[1])]))


CASES: dict[str, Make] = {
    "free motion, white noise": lambda seed: rig(seed),
    "planar motion, white noise": lambda seed: rig(seed, planar=1.0),
    "lever arms of 2 cm": lambda seed: rig(seed, lever=0.02),
    "biases of 0.5 deg/s and 0.1 m/s^2": biased,
    "a mount that leans by 3 deg rms": leaning,
}


HOLD = "free motion, white noise", "planar motion, white noise"


@dataclass(frozen=True)
class Run:
    """Whether each region held the truth, and the error in rad."""

    inside: dict[str, bool]
    error: float


def regions(fit: Fit, settings: Settings) -> Covariances:
    """Return the covariances (4, 4) that the regions are made from."""
    jackknife = jackknife_spread(fit, settings, Guard().groups)
    return {
        "eq. (57)": paper_covariance(fit.best),
        "Estimate.covariance": covariance(fit.constraints, fit.best),
        "guard: pieces and biases": jackknife + bias_spread(fit, settings, Guard()),
    }


def judge(one: HingeRig, seed: int) -> Run | None:
    """Return what became of the first estimate accepted of a rig; None if none was."""
    stream = PlugAndPlay(rng=np.random.default_rng(seed))
    for batch in batches(Paired(one.time, one.gyro[0], one.accel[0], one.gyro[1], one.accel[1])):
        update = stream.update(batch)
        if update.accepted:
            break
    else:
        return None
    best = update.fit.best
    truth = one.axes if np.sum(best.axes * one.axes) > 0 else -one.axes
    step = np.einsum("itk,ik->it", best.tangents, truth).ravel()
    z = deviations(step)
    inside: dict[str, bool] = {}
    for name, p in regions(update.fit, stream.settings).items():
        inside[f"{name}: {REGIONS[0]}"] = p is not None and bool(step @ np.linalg.solve(p, step) < CHI_SQUARE)
        inside[f"{name}: {REGIONS[1]}"] = p is not None and bool((z < two_sigma(p)).all())
    return Run(inside, float(np.arccos(np.clip(np.sum(best.axes * truth, axis=1), -1, 1)).max()))


def runs(make: Make, count: int) -> Iterator[Run]:
    for seed in range(count):
        run = judge(make(seed), seed)
        if run is not None:
            yield run


def run() -> list[Row]:
    """Return a row for each of the cases in which the assumptions hold; the others are for `main`."""
    rows = []
    for name in HOLD:
        done = list(runs(CASES[name], RUNS))
        held = {key: 100 * float(np.mean([one.inside[key] for one in done])) for key in done[0].inside}
        ours = [held[f"Estimate.covariance: {region}"] for region in REGIONS]
        peer = [held[f"eq. (57): {region}"] for region in REGIONS]
        cells = (" %, ".join(f"{part:.1f}" for part in side) + " %" for side in (ours, peer))
        what = f"truth in the 95 % region of Algorithm 4's estimate, {name}, {RUNS} rigs: {', '.join(REGIONS)}"
        met = all(LEAST <= part <= MOST for part in ours)
        rows.append(Row(what, *cells, "-", f"{LEAST:.0f} to {MOST:.0f} %", met))
    return rows


def main(count: int) -> None:
    """Print what each kind of region holds, in every case."""
    for name, make in CASES.items():
        done = list(runs(make, count))
        errors = np.degrees([run.error for run in done])
        print(f"{name}: {len(done)} of {count} accepted, error {np.median(errors):.2f} deg, {errors.max():.2f} at most")
        for key in done[0].inside:
            print(f"    {key}: {100 * np.mean([run.inside[key] for run in done]):.1f} %", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else RUNS)
