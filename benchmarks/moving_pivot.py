"""One IMU and two where the joint centre accelerates as in walking: python -m benchmarks.moving_pivot [SEEDS] [IMAGE]

Prints the tables of docs/moving-pivot.md and, with IMAGE, draws its figure. Every seed is another draw of phases, step
rate, pelvis sensor and noise. Errors of filters are means over time from 2 s on, of batches over seeds alone.
"""

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.estimators import hinge_position, two_imu_centre
from imubench.estimators.centre_ekf import Covariances, covariances_of
from imubench.estimators.centre_runs import track
from imubench.estimators.gravity import linear_acceleration
from imubench.estimators.mrvs import solve_differenced
from imubench.estimators.two_imu_model import Noise
from imubench.recording import Recording
from imubench.scenarios.hinge import hand_motion
from imubench.scenarios.moving_pivot import gait, hip_mounts, knee, knee_rig, moving, pelvis, shared_centre, thigh
from imubench.scenarios.pendulum import ellipse
from imubench.sim.imu_model import observe
from imubench.sim.imu_profile import ImuProfile
from imubench.sim.motion import AngleMotion
from imubench.sim.play import play
from imubench.sim.profiles import profile
from imubench.sim.rigs import random_hinge
from imubench.sim.signals import STILL, Signal, Sines
from imubench.truth import Truth

SCALES = (0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
DURATION, AFTER, RATE = 10.0, 2.0, 100.0
AWINDA = profile("xsens_mtw_awinda")
Play = Callable[[np.random.Generator, float], Truth]


@dataclass(frozen=True)
class Case:
    """One seed of one experiment."""

    recording: Recording
    truth: Truth

    @property
    def r(self) -> Array:
        """The true vectors (2, 3) in m, which do not vary."""
        return np.stack([s.joint_vector[0] for s in self.truth.sensors])

    def off(self, r: Array) -> Array:
        """Return |dr| (..., 2) in m of vectors (..., 2, 3), on a hinge without the part along it that none shows."""
        error = r - self.r
        axes = [s.joint_axis for s in self.truth.sensors if s.joint_axis is not None]
        if axes:
            along = np.stack([a[0] for a in axes]) / np.sqrt(2)
            error = error - np.einsum("...ia,ia->...", error, along)[..., None, None] * along
        return np.asarray(np.linalg.norm(error, axis=-1))

    def centre_rms(self) -> float:
        """The RMS acceleration of the joint centre in m/s^2."""
        return float(np.sqrt(np.mean(np.sum(self.truth.segments[0].acceleration ** 2, axis=-1))))


def hip(rng: np.random.Generator, scale: float, on: AngleMotion, under: AngleMotion) -> Truth:
    return shared_centre((under, on), hip_mounts(rng), gait(rng, scale=scale), DURATION)


def bending(rng: np.random.Generator, scale: float, across: float) -> Truth:
    return play(knee_rig(rng), moving(knee(across=across), gait(rng, "knee", scale)), DURATION)


def by_hand(rng: np.random.Generator, scale: float) -> Truth:
    return play(random_hinge(rng), moving(hand_motion(rng, DURATION), gait(rng, "knee", scale)), DURATION)


CIRCLING: Play = partial(hip, on=ellipse(), under=pelvis())
MOTIONS: dict[str, Play] = {
    "hip, thigh circles as in the paper, pelvis as in walking": CIRCLING,
    "hip in walking": partial(hip, on=thigh(), under=pelvis()),
    "hip in walking, pelvis turns a fifth as much": partial(hip, on=thigh(), under=pelvis(scale=0.2)),
    "hip, thigh circles, pelvis does not turn": partial(hip, on=ellipse(), under=pelvis(scale=0.0)),
    "knee in walking, 5 deg out of the plane": partial(bending, across=1.0),
    "knee in walking, 1 deg out of the plane": partial(bending, across=0.2),
    "knee in walking, in a plane": partial(bending, across=0.0),
    "hinge turned by a hand, centre as a knee": by_hand,
}


def cases(play: Play, scale: float, seeds: int, imu: ImuProfile = AWINDA, late: float = 0.0) -> list[Case]:
    """Return one case a seed; the clock of imu2 is `late` s behind."""
    found = []
    for seed in range(seeds):
        rng = np.random.default_rng([4, seed])
        truth = play(rng, scale)
        profiles = {"imu1": imu, "imu2": replace(imu, clock_offset=late)}
        found.append(Case(observe(truth, profiles, rng), truth))
    return found


def known(case: Case) -> Array:
    """Return the acceleration (n, 3) of imu2, gravity taken out by the true orientation."""
    up = rotations.to_matrix(case.truth.sensors[1].quaternion)[:, 2, :]
    every = round(1 / RATE / (case.truth.time[1] - case.truth.time[0]))
    return np.asarray(case.recording.imu("imu2").accel - 9.81 * up[::every])


def one_imu(found: Sequence[Case], told: bool = False, how: str = "known") -> Array:
    """Return the mean |dr| (seeds,) in m of ArVE_d on imu2; `told` the size of the centre's acceleration as noise."""
    time = found[0].recording.imu("imu2").time
    gyro = np.stack([c.recording.imu("imu2").gyro for c in found])
    if how == "known":
        acceleration, settings = np.stack([known(c) for c in found]), covariances_of("arve-d", "constant")
    else:
        acceleration = np.stack([linear_acceleration(c.recording, "ukf", "imu2") for c in found])
        settings = covariances_of("arve-d", "constant", "ukf")
    return np.array(
        [_tracked(c, w, a, time, settings, told) for c, w, a in zip(found, gyro, acceleration, strict=True)]
    )


def _tracked(case: Case, w: Array, a: Array, time: Array, settings: Covariances, told: bool) -> float:
    if told:
        std = float(np.hypot(settings.acceleration_noise_std, case.centre_rms() / np.sqrt(3)))
        settings = replace(settings, acceleration_noise_std=std)
    tracks = track(w[None], a[None], time, 12, settings)
    errors = np.linalg.norm(tracks.r[0] - case.r[1], axis=-1)
    return float(errors[time[tracks.first :] > AFTER].mean())


def mean_vector(found: Sequence[Case]) -> Array:
    """Return |dr| (seeds,) in m of MrVS on imu2 over the record, with the true orientation."""
    errors = []
    for case in found:
        imu = case.recording.imu("imu2")
        r, _ = solve_differenced(imu.gyro, known(case), imu.time)
        errors.append(float(np.linalg.norm(r - case.r[1])))
    return np.array(errors)


def batch(found: Sequence[Case]) -> Array:
    """Return |dr| (seeds, 2) in m of hinge-position over the record."""
    return np.array([case.off(hinge_position.estimate(case.recording).value) for case in found])


@dataclass(frozen=True)
class Streamed:
    """What the two-IMU filter made of some cases."""

    error: Array  # (seeds, 2) m, mean over time
    std: Array  # (seeds, 2) m, of the worst direction at the end, across a hinge
    squared: Array  # (seeds,) squared error over covariance at the end, a number, 1 if it is as large as it says
    innovation: Array  # (seeds,) the same of its innovations


def streamed(found: Sequence[Case]) -> Streamed:
    """Return what the two-IMU filter makes of the cases; where it says it saw nothing, NaN."""
    rows = []
    for case in found:
        answer = two_imu_centre.estimate(case.recording)
        innovation = answer.details["innovation_squared"]
        if answer.time is None or answer.covariance is None:
            rows.append([np.nan] * 5 + [innovation])
            continue
        late = case.off(answer.value[answer.time > AFTER]).mean(axis=0)
        error, P = (answer.value[-1] - case.r).ravel(), answer.covariance[-1]
        stds = [np.sqrt(np.linalg.eigvalsh(P[i : i + 3, i : i + 3])[-1]) for i in (0, 3)]
        rows.append([*late, *stds, error @ np.linalg.solve(P, error) / 6, innovation])
    table = np.array(rows)
    return Streamed(table[:, :2], table[:, 2:4], table[:, 4], table[:, 5])


def mm(errors: Array) -> str:
    """Return mean and largest in mm."""
    return f"{1e3 * np.mean(errors):.3g} ({1e3 * np.max(errors):.3g})"


def by_scale(seeds: int) -> tuple[Array, dict[str, Array]]:
    """Return the RMS accelerations (scales,) in m/s^2 and each method's errors (scales, seeds) in m; print a table."""
    methods: dict[str, Callable[[Sequence[Case]], Array]] = {
        "one IMU: MrVS": mean_vector,
        "one IMU: ArVE_d": one_imu,
        "one IMU: ArVE_d, told of the acceleration as noise": partial(one_imu, told=True),
        "one IMU: ArVE_d, gravity by the UKF": partial(one_imu, how="ukf"),
        "two IMUs: hinge-position, batch": lambda found: batch(found)[:, 1],
        "two IMUs: two-imu-centre, r_2": lambda found: streamed(found).error[:, 1],
        "two IMUs: two-imu-centre, r_1": lambda found: streamed(found).error[:, 0],
    }
    rms, errors = [], {name: [] for name in methods}  # type: tuple[list[float], dict[str, list[Array]]]
    print("| centre, m/s^2 RMS | " + " | ".join(methods) + " |\n|---:|" + "---:|" * len(methods))
    for scale in SCALES:
        found = cases(CIRCLING, scale, seeds)
        rms.append(float(np.mean([c.centre_rms() for c in found])))
        for name, method in methods.items():
            errors[name].append(method(found))
        print(f"| {rms[-1]:.2f} | " + " | ".join(mm(e[-1]) for e in errors.values()) + " |", flush=True)
    return np.array(rms), {name: np.array(e) for name, e in errors.items()}


def by_motion(seeds: int) -> None:
    """Print what the methods make of each motion at full acceleration."""
    print("\n| motion | MrVS r_2 | ArVE_d r_2 | batch r_1 | batch r_2 | r_1 | r_2 | std r_1 | std r_2 | NEES | NIS |")
    print("|---|" + "---:|" * 10)
    for name, play_ in MOTIONS.items():
        found = cases(play_, 1.0, seeds)
        both, s = batch(found), streamed(found)
        cells = [mm(e) for e in (mean_vector(found), one_imu(found), *both.T, *s.error.T)]
        cells += [f"{1e3 * x:.3g}" for x in s.std.mean(axis=0)]
        cells += [f"{s.squared.mean():.2f}", f"{s.innovation.mean():.2f}"]
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


def by_sensor(seeds: int) -> None:
    """Print what sensor errors beyond white noise do, on the first motion at full acceleration."""
    print("\n| sensors | hinge-position r_2 | two-imu-centre r_1 | r_2 | NEES | NIS |\n|---|---:|---:|---:|---:|---:|")
    biased = replace(profile("xsens_mtw"), rate=RATE)
    rows = {
        "MTw Awinda, white noise": (AWINDA, 0.0),
        "MTw, with its biases, 0.29 deg/s and 0.058 m/s^2 an axis": (biased, 0.0),
        "MPU-9250, not calibrated": (profile("mpu9250"), 0.0),
        "Awinda, clock of imu2 1 ms late": (AWINDA, 0.001),
        "Awinda, clock of imu2 5 ms late": (AWINDA, 0.005),
        "Awinda, clock of imu2 20 ms late": (AWINDA, 0.020),
    }
    for name, (imu, late) in rows.items():
        found = cases(CIRCLING, 1.0, seeds, imu, late)
        s = streamed(found)
        cells = [mm(batch(found)[:, 1]), *(mm(e) for e in s.error.T), f"{s.squared.mean():.3g}"]
        print(f"| {name} | " + " | ".join(cells) + f" | {s.innovation.mean():.2f} |", flush=True)


def by_gravity(seeds: int) -> None:
    """Print what becomes of the answers with another gravity, of which nobody is told."""
    print("\n| gravity, m/s^2 | r_1 | r_2 |\n|---:|---:|---:|")
    found = cases(CIRCLING, 1.0, seeds)
    for gravity in (0.0, 3.7, 9.81, 25.0):
        s = streamed([_heavier(c, gravity - 9.81) for c in found])
        print(f"| {gravity} | {mm(s.error[:, 0])} | {mm(s.error[:, 1])} |", flush=True)


def _heavier(case: Case, more: float) -> Case:
    every = round(1 / RATE / (case.truth.time[1] - case.truth.time[0]))
    imus = tuple(
        replace(imu, accel=imu.accel + more * rotations.to_matrix(s.quaternion[::every])[:, 2, :])
        for imu, s in zip(case.recording.imus, case.truth.sensors, strict=True)
    )
    return Case(replace(case.recording, imus=imus), case.truth)


@dataclass(frozen=True)
class Later:
    """A signal that sets in smoothly, within about a second, at `start` s."""

    signal: Signal
    start: float

    def __call__(self, time: Array) -> tuple[Array, Array, Array]:
        t = np.clip(time - self.start, 0.0, None)
        value, first, second = self.signal(t)
        left = np.exp(-(t**3))
        r, dr, ddr = 1 - left, 3 * t**2 * left, (6 * t - 9 * t**4) * left
        return r * value, dr * value + r * first, ddr * value + 2 * dr * first + r * second


def by_rest(seeds: int) -> None:
    """Print the errors some seconds after a rest of three, which the filter has had to start from."""
    seconds = (4.0, 5.0, 6.0, 8.0, 13.9)
    print("\n| after a rest of 3 s | " + " | ".join(f"{t:.1f} s" for t in seconds) + " |\n|---|" + "---:|" * 5)
    errors = []
    for seed in range(seeds):
        rng = np.random.default_rng([4, seed])
        mounts, centre = hip_mounts(rng), {k: Later(v, 3.0) for k, v in gait(rng).items()}
        turning = [
            replace(m, **{k: Later(getattr(m, k), 3.0) for k in ("heading", "tilt", "spin")})
            for m in (pelvis(), ellipse())
        ]
        truth = shared_centre((turning[0], turning[1]), mounts, centre, 14.0)
        case = Case(observe(truth, AWINDA, rng), truth)
        answer = two_imu_centre.estimate(case.recording)
        assert answer.time is not None
        errors.append(case.off(answer.value)[np.searchsorted(answer.time, np.array(seconds) - 1e-6)])
    for i, row in enumerate(np.array(errors).transpose(2, 1, 0)):
        print(f"| r_{i + 1} | " + " | ".join(mm(e) for e in row) + " |", flush=True)


def by_slide(seeds: int) -> None:
    """Print how far a sensor that slides by 20 mm along x and z is followed, and felt, by frequency."""
    print("\n| slide, Hz | r taken as constant | NIS | as varying | NIS |\n|---:|---:|---:|---:|---:|")
    for hertz in (0.05, 0.1, 0.3, 1.0):
        rows: list[list[float]] = []
        for seed in range(seeds):
            rng = np.random.default_rng([4, seed])
            slide = Sines(0.02, hertz)
            one, two = hip_mounts(rng)
            two = replace(two, path=(slide, STILL, slide))
            truth = shared_centre((pelvis(), ellipse()), (one, two), gait(rng), DURATION)
            recording = observe(truth, AWINDA, rng)
            rows.append([])
            for density in (Noise().r_density, 0.006):
                answer = two_imu_centre.estimate(
                    recording, replace(two_imu_centre.noise_of(recording), r_density=density)
                )
                assert answer.time is not None
                late = answer.time > AFTER
                true = np.stack([np.interp(answer.time, truth.time, c) for c in truth.sensors[1].joint_vector.T], -1)
                error = np.linalg.norm(answer.value[late, 1] - true[late], axis=-1).mean()
                rows[-1] += [float(error), answer.details["innovation_squared"]]
        a, b, c, d = np.array(rows).T
        print(f"| {hertz} | {mm(a)} | {b.mean():.2f} | {mm(c)} | {d.mean():.2f} |", flush=True)


def draw(rms: Array, errors: dict[str, Array], path: Path) -> None:
    """Draw the errors against the acceleration of the joint centre, mean and range over seeds."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.2, 4.6), layout="constrained")
    axes = figure.subplots()
    x = np.maximum(rms, rms[1] / 3)  # rest has no place on a logarithmic axis
    colours = ("#c8641e", "#c0392b", "#e3a06a", "#8c2f5b", "#2e8b57", "#1f6fb4", "#5aa9d6")
    for (name, e), colour in zip(errors.items(), colours, strict=True):
        style = "--" if name.startswith("two IMUs: hinge") or name.endswith("r_1") else "-"
        axes.plot(x, 1e3 * e.mean(axis=1), style, marker=".", color=colour, label=name)
        axes.fill_between(x, 1e3 * e.min(axis=1), 1e3 * e.max(axis=1), color=colour, alpha=0.12, lw=0)
    axes.set(xscale="log", yscale="log", xlabel="RMS acceleration of the joint centre, m/s²", ylabel="mean |Δr|, mm")
    axes.set_xticks(x, ["rest", *(f"{v:.2f}" for v in rms[1:])])
    axes.minorticks_off()
    axes.axhline(20.0, color="#9aa3ab", lw=0.8, ls=":")
    axes.text(x[0], 21.0, "a tenth of |r|", fontsize=8, color="#55606a")
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(axis="y", color="#e6e9ec", lw=0.6)
    axes.legend(frameon=False, fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    figure.savefig(path, dpi=130)


def main(seeds: int, image: Path | None) -> None:
    rms, errors = by_scale(seeds)
    if image is not None:
        draw(rms, errors, image)
    by_motion(seeds)
    by_sensor(seeds)
    by_gravity(seeds)
    by_rest(seeds)
    by_slide(seeds)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10, Path(sys.argv[2]) if len(sys.argv) > 2 else None)
