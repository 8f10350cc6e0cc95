"""A scenario: a rig, a motion and an IMU, all random by seed."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from imubench import rotations
from imubench.recording import Imu, Recording
from imubench.sim.imu_model import Declared, DeclaredMount, observe
from imubench.sim.imu_profile import ImuProfile
from imubench.sim.injected import Injected, carried, injected_profile, injected_rig, injected_samples
from imubench.sim.motion import Motion
from imubench.sim.play import play
from imubench.sim.profiles import profile
from imubench.sim.rigs import Mount, Rig
from imubench.truth import Truth


@dataclass(frozen=True)
class Experiment:
    """What happened, and what its owner declares about it."""

    rig: Rig
    truth: Truth
    declared: Declared


Play = Callable[[np.random.Generator, float, Sequence[Injected]], Experiment]
"""Takes what draws, how long in s, and the effects to be played."""


@dataclass(frozen=True)
class Scenario:
    """A named experiment that can be repeated with any seed."""

    name: str
    summary: str
    estimator: str | None  # the one that `run` takes by default
    profile: str  # of sim/profiles.toml
    play: Play
    rig: str = "hinge"
    seconds: float = 60.0  # s
    swings: bool = False  # moved by no outside force

    def record(
        self, seed: int, imu: ImuProfile | None = None, seconds: float | None = None, effects: Sequence[Injected] = ()
    ) -> tuple[Recording, Truth]:
        """Return the recording and what really happened; the same seed gives the same numbers.

        Args:
            seed: of everything that is drawn. What another argument changes leaves the other draws alone.
            imu: another than the scenario's own.
            seconds: s, instead of the scenario's own.
            effects: left-out physics, which the recording's owner does not declare.

        Raises:
            InputError: a duration that the motion cannot have, or an effect that cannot be played.
        """
        playing, observing, sampling = np.random.default_rng(seed).spawn(3)
        experiment = self.play(playing, self.seconds if seconds is None else seconds, effects)
        nominal = profile(self.profile) if imu is None else imu
        parts = {s.name: injected_profile(_per_sample(nominal), s.name, effects) for s in experiment.truth.sensors}
        name = f"{self.name.replace('/', '-')}-{seed}"
        used = parts if effects else nominal
        recording = observe(experiment.truth, used, observing, name, experiment.declared)
        if effects:
            own = zip(recording.imus, sampling.spawn(len(recording.imus)), strict=True)
            told = (injected_samples(_as_declared(i, nominal), effects, rng) for i, rng in own)
            recording = replace(recording, imus=tuple(told))
        return recording, experiment.truth


def prescribed(
    rig: Rig, motion: Motion, seconds: float, rng: np.random.Generator, effects: Sequence[Injected] = ()
) -> Experiment:
    """Play a motion on a rig, effects in it, for so many s; its owner declares the mounts as measured.

    Raises `InputError` for a motion that is shorter, or effects that the rig cannot have.
    """
    mounts = declared_mounts(rig, rng)
    declared = Declared(mounts=mounts, gravity=rig.gravity)
    motion, rig = carried(motion, injected_rig(rig, mounts, effects), effects, rng.spawn(1)[0])
    return Experiment(rig, play(rig, motion, seconds), declared)


def _per_sample(imu: ImuProfile) -> ImuProfile:
    """Return an IMU with its noise as a std per sample, which an effect on its bandwidth leaves alone."""
    gyro, accel = (
        replace(channel, noise_density=0.0, noise_std=channel.sample_noise_std(imu.rate))
        for channel in (imu.gyro, imu.accel)
    )
    return replace(imu, gyro=gyro, accel=accel)


def _as_declared(imu: Imu, nominal: ImuProfile) -> Imu:
    """Return an IMU's samples with what its owner believes about it."""
    return replace(
        imu,
        gyro_noise_std=nominal.gyro.declared_noise_std(imu.rate),
        accel_noise_std=nominal.accel.declared_noise_std(imu.rate),
        gyro_range=nominal.gyro.range,
        accel_range=nominal.accel.range,
    )


def declared_mounts(
    rig: Rig, rng: np.random.Generator, position_std: float = 0.005, rotation_std: float = 0.02
) -> dict[str, DeclaredMount]:
    """Return the mount poses as an owner would measure them: off by the stds, in m and rad, that he declares."""

    def measured(mount: Mount) -> DeclaredMount:
        position = mount.position + rng.normal(scale=position_std, size=3)
        turned = rotations.multiply(mount.quaternion, rotations.exp(rng.normal(scale=rotation_std, size=3)))
        return DeclaredMount(position, turned, position_std, rotation_std)

    return {f"imu{i + 1}": measured(mount) for i, mount in enumerate(rig.mounts)}
