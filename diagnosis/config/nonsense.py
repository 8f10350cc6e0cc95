"""Thresholds of recordings that no simulation of their rig can be compared with."""

from dataclasses import dataclass

from imubench.setting import setting


@dataclass(frozen=True)
class StretchConfig:
    """Which part of a recording is looked at."""

    grid_hz: float = setting(50.0, "Hz", "a hand moves below 10 Hz, and the checks filter lower than that", "physics")
    least_rate_hz: float = setting(
        10.0, "Hz", "the mean interval of a slower sensor is longer than what the checks compare", "physics"
    )
    most_s: float = setting(120.0, "s", "of a recording that are looked at", "time")
    least_share: float = setting(0.1, "of rate and length", "that samples must make up", "judgement")
    rough_s: float = setting(10.0, "s", "of a recording that a rough fit takes", "time")
    rough_steps: int = setting(
        12,
        "steps",
        "of the solver: a right reading takes two to eight, and one that is not there yet is wrong",
        "trials",
    )
    known_mount_rad: float = setting(
        0.3, "rad", "a mount that is declared no better tells no order of axes", "judgement"
    )


STRETCH = StretchConfig()


@dataclass(frozen=True)
class AxisOrderConfig:
    """Axes in another order or of another sign, and IMUs in each other's place."""

    window_s: float = setting(
        8.0,
        "s",
        "over which the velocity is compared: long beside a stroke, short beside what a bias of 0.05 rad/s turns",
        "physics",
    )
    bias_rad_s: float = setting(0.03, "rad/s", "the size of a bias, as a prior", "judgement")
    worse: float = setting(
        2.0,
        "times what the best other reading leaves",
        "of the velocity, and of the misfit; right axes stay well below, simulated and real (lab 029). A likelihood "
        "ratio would be sure of less, but what an effect leaves is not noise",
        "trials",
    )
    least_m_s: float = setting(
        0.1, "m/s", "what a degree of tilt makes in a second; below, a resting sensor's drift decides", "physics"
    )
    clearly: float = setting(0.7, "of the next best reading's misfit", "RMS: half its power", "judgement")
    turned_rad: float = setting(
        0.8, "rad", "less is a mount that sits askew, not one axis in another's place (1.57)", "physics"
    )
    near_rad: float = setting(
        0.05,
        "rad",
        "and three standard deviations: 2 % of directions are as near to one of the 23 others by chance",
        "statistics",
    )
    odd_misfit: float = setting(
        0.2,
        "misfit",
        "from which on the other order is tried; a recording with nothing wrong has 0.09 to 0.26",
        "trials",
    )


AXIS_ORDER = AxisOrderConfig()


@dataclass(frozen=True)
class SharedMotionConfig:
    """Whether two sensors saw one motion."""

    folds: int = setting(4, "parts", "each of which is foretold from the others", "statistics")
    blocks: int = setting(2, "blocks", "of each part: one early and one late in the recording", "statistics")
    ridge: float = setting(
        1e-3, "of the signals' mean power", "directions that hardly vary are not divided by", "numerics"
    )
    surrogates: int = setting(39, "surrogates", "of which mean and spread are taken", "time")
    surrogate_s: float = setting(
        2.0, "s", "at least that a surrogate is turned: a stroke of the hand is over", "physics"
    )
    alike: float = setting(
        0.7,
        "1",
        "correlation under which sensors are told apart: of 295 pairs on one hinge the least had 0.76, in 10 "
        "s of a loose one; of 343 pairs from different recordings of 20 s one had more",
        "trials",
    )
    below_hz: float = setting(
        2.0, "Hz", "slower than soft mounts ring, quick enough for some strokes in every block", "physics"
    )
    grid_hz: float = setting(25.0, "Hz", "enough for what is below 2 Hz", "numerics")
    turning_rad_s: float = setting(0.3, "rad/s RMS", "that a sensor must turn for what it shares to show", "physics")

    @property
    def lag_step_s(self) -> float:
        """In s, between the lags that are tried: what is slow enough for the grid changes little from row to row."""
        return 1 / self.grid_hz


SHARED_MOTION = SharedMotionConfig()


@dataclass(frozen=True)
class StuckConfig:
    """A channel that reads one number."""

    long_s: float = setting(1.0, "s", "of one reading, longer than samples are held by chance", "judgement")
    most: float = setting(
        0.5,
        "of the samples",
        "from there a channel is stuck, and below it has stretches that are; one that changes in so many is not",
        "convention",
    )
    turned_rad: float = setting(
        0.1,
        "rad",
        "between directions of the specific force: more than a still sensor's noise or a bench that shakes",
        "physics",
    )
    same_limit: float = setting(1e-6, "relative", "readings at one limit", "numerics")

    @property
    def turning_rad_s(self) -> float:
        """In rad/s RMS: while a channel reads one number for so long, gravity turns by that angle."""
        return self.turned_rad / self.long_s


STUCK = StuckConfig()
