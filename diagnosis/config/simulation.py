"""Thresholds of simulations beside a recording, and of experiments that would tell effects apart."""

from dataclasses import dataclass

from imubench.setting import setting


@dataclass(frozen=True)
class RollOutConfig:
    """A model played from its start on."""

    step_s: float = setting(
        1e-3, "s", "of the integration: Runge and Kutta's error of a swing of 1 Hz is 1e-9 rad a second", "numerics"
    )
    chunk_s: float = setting(30.0, "s", "that are integrated at once: memory does not grow with the swing", "time")
    sensor_mass: float = setting(
        1e-9, "of the segment's mass", "that a sensor has: MuJoCo takes no massless body", "numerics"
    )
    start_s: float = setting(1.0, "s", "that the state at the start is fitted to", "judgement")
    difference: float = setting(
        1e-6,
        "rad, rad/s, prior std",
        "of differences; a torque's prior is up to a thousand times the torque, and friction and drag all but cancel "
        "in a swing: the response is linear over it to 1e-4, and rounding is 1e-7 of it",
        "numerics",
    )
    near: float = setting(
        10.0,
        "of the noise",
        "RMS of a limb's roll-outs from which numbers are learned: a milliradian at 10 rad/s; a limb that is farther "
        "off lacks more than that",
        "physics",
    )
    least_s: float = setting(
        1.5, "s", "of a window that is rolled out: over less hardly more than its start shows", "judgement"
    )
    bin_s: float = setting(
        0.25, "s", "over which that is averaged: no sensor is blind to a swing for so long", "physics"
    )


ROLL_OUT = RollOutConfig()


@dataclass(frozen=True)
class SimulatedBesideConfig:
    """A simulation beside the recording."""

    start_rate_hz: float = setting(
        200.0,
        "Hz",
        "of rows while a start is looked for: cubics between them are off by 1e-5 rad/s at swings' rates",
        "numerics",
    )
    tells: float = setting(
        4.0, "of another half's std", "with a sixteenth of its samples a half still teaches it something", "judgement"
    )
    least_half: float = setting(0.2, "of a stretch", "that each half of it has at least", "judgement")
    most_times: int = setting(20_000, "times", "at which motion is summed up: 30 ms apart in ten minutes", "time")
    law_std: float = setting(
        0.01,
        "of a law's std",
        "force noise of std s, 100 rows a second, rings a spring of 18 Hz with Q = 17 by 3 s",
        "physics",
    )
    channels: int = setting(3, "channels", "that are shown of a finding, the worst first", "convention")

    @property
    def start_step_s(self) -> float:
        """In s, of the integration meanwhile, two a row: Runge and Kutta's error is 1e-8 rad in a second."""
        return 0.5 / self.start_rate_hz


SIMULATED_BESIDE = SimulatedBesideConfig()


@dataclass(frozen=True)
class SwingWindowConfig:
    """Where a segment swings freely."""

    grid_s: float = setting(
        0.01, "s", "between the times that are asked: a hand takes hundredths of a second to let go", "physics"
    )
    moving_rad_s: float = setting(0.3, "rad/s", "a swing from rest has this after hundredths of a second", "physics")
    catch_s: float = setting(0.3, "s", "in which a hand stops a limb", "physics")
    level: float = setting(0.05, "of the weight's torque", "an attitude is known to some degrees", "judgement")


SWING_WINDOW = SwingWindowConfig()


@dataclass(frozen=True)
class ExperimentConfig:
    """Motions that would tell effects apart."""

    recording_s: float = setting(20.0, "s", "of a motion that is asked for", "judgement")
    nearly: float = setting(
        0.9, "of the best", "from there the motion that comes first in the menu, the simpler one, is named", "judgement"
    )
    step_s: float = setting(0.005, "s", "of an integrated swing", "numerics")
    release_rad: float = setting(1.0, "rad", "from hanging, of a swing that is let go", "physics")
    spin_rad_s: float = setting(2.0, "rad/s", "of a spin", "physics")
    held_rad: float = setting(0.6, "rad", "how far a held joint may be bent meanwhile", "physics")


EXPERIMENT = ExperimentConfig()
