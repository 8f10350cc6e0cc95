"""Thresholds of the noise levels, their colour, and what noise does to numbers."""

from dataclasses import dataclass

from imubench.setting import setting


@dataclass(frozen=True)
class CoherenceConfig:
    """Residuals that go with the motion."""

    lags: tuple[int, ...] = setting(
        (-6, -3, -1, 0, 1, 3, 6), "samples", "by which a residual may lag the motion", "judgement"
    )
    least_hz: float = setting(1.0, "Hz", "the least that a motion is asked up to", "physics")
    most_of_rate: float = setting(
        0.4,
        "of the sampling rate",
        "what is loud beyond alone is a spline between its knots, and no motion",
        "numerics",
    )
    below_hum: float = setting(0.5, "of a hum's frequency", "the fitted motion hums as well", "judgement")
    follows: float = setting(
        3.0,
        "of `follows_motion`",
        "from which a sensor may have a motion of its own; clean recordings stay below 2",
        "trials",
    )


COHERENCE = CoherenceConfig()


@dataclass(frozen=True)
class ColourConfig:
    """How coloured noise may be."""

    slowest_hz: float = setting(
        0.5,
        "Hz",
        "corner of the slowest coloured noise that is no mismatch; slower residuals may be what a drift left",
        "judgement",
    )
    white_hz: float = setting(6.0, "Hz", "from which on the noise is as good as white", "judgement")
    draws: int = setting(6, "draws", "of white noise, from which what a fit leaves of it is read", "time")
    least_left: float = setting(
        0.05, "of the white power", "where the fit leaves less, the residuals cannot tell the noise", "judgement"
    )
    least_spectrum: float = setting(
        0.5, "of the white power", "a spectrum falls below 1 only because slow noise raised the level", "statistics"
    )


COLOUR = ColourConfig()


@dataclass(frozen=True)
class DebiasConfig:
    """How noise pulls the numbers of springs."""

    draws: int = setting(16, "draws", "of noise", "time")
    most_pull: float = setting(
        0.5, "of a logarithm, or of another number's prior", "how far one pull may lead", "numerics"
    )
    most_from_noise: float = setting(0.9, "of the information", "that is taken for noise's at most", "numerics")
    most_of_step: float = setting(
        0.85,
        "of the information",
        "that is taken for noise's at most where a step is made: longer ones overshoot",
        "numerics",
    )
    rounds: int = setting(12, "pulls", "at most", "time")
    settled: float = setting(0.1, "of a number's std", "a number that moves less has settled", "numerics")


DEBIAS = DebiasConfig()


@dataclass(frozen=True)
class SpringIntervalConfig:
    """The interval of a spring's numbers."""

    dampings: tuple[float, ...] = setting(
        (0.03, 0.1, 0.3, 0.7), "damping ratio", "tried; 0.7 is where the prior's 95 % end", "statistics"
    )
    stiffer: tuple[float, ...] = setting((1.1, 1.25, 1.5), "of the frequency", "tried", "judgement")


SPRING_INTERVAL = SpringIntervalConfig()


@dataclass(frozen=True)
class KnotSelectionConfig:
    """How many knots a motion needs."""

    fewer: tuple[int, ...] = setting((4, 3, 2), "times", "fewer knots that are tried, the fewest first", "judgement")
    spared: float = setting(
        0.45, "of the knots' highest frequency", "above, nothing may be more than noise", "numerics"
    )
    bands: int = setting(6, "bands", "of a residual's spectrum", "judgement")
    unfollowed: float = setting(
        0.7, "of the knots' highest frequency", "from there on knots do not follow a residual", "numerics"
    )
    knots_per_period: int = setting(
        7, "knots", "in the period of springs that ring, at least: a spline of fewer damps them", "numerics"
    )
    rung: float = setting(0.65, "of a spring's frequency", "a motion clear up to there makes it ring", "physics")
    change: float = setting(1.1, "times", "as far apart as the knots are: less is no change", "time")
    window_samples: int = setting(256, "samples", "of which a spectrum is taken", "numerics")


KNOT_SELECTION = KnotSelectionConfig()


@dataclass(frozen=True)
class LooseFitConfig:
    """Levels and roughness that a fit begins with or is held by for a while."""

    motion: float = setting(
        64.0,
        "times",
        "less tightly held: 16 leave up to 0.7 of a deviation of a twist, 256 change nothing more",
        "trials",
    )
    equation: float = setting(
        1e4, "of its std", "the sensors say what moves before the equation of motion is asked", "numerics"
    )
    start_roughness: float = setting(
        3.0, "times the start's roughness", "where that is more than the first guess", "judgement"
    )
    freer: float = setting(8.0, "times the roughness", "of a motion that may be held too smooth", "judgement")
    still_follows: float = setting(
        0.7, "of what follows the motion", "where a freer motion leaves more, it was not held too smooth", "judgement"
    )


LOOSE_FIT = LooseFitConfig()


@dataclass(frozen=True)
class MaskingConfig:
    """Effects that act in few moments."""

    fits: float = setting(
        1.3, "of what is left elsewhere", "that is left in the moment where an effect's course is its law's", "trials"
    )
    left_out_noise: float = setting(
        10.0,
        "times the noise",
        "of a sample whose effect's course is not known: from here it says a hundredth of what another does",
        "statistics",
    )


MASKING = MaskingConfig()


@dataclass(frozen=True)
class RemlConfig:
    """Levels by restricted maximum likelihood."""

    law_floor: float = setting(
        0.05, "of a law's std", "a law that held without any noise would hold the fit still", "numerics"
    )
    law_rise: float = setting(4.0, "times its level", "of the round before, at most", "numerics")
    smallest: float = setting(1e-7, "of a unit", "no group is taken for exact", "numerics")
    rounds: int = setting(3, "rounds", "of levels and fit", "time")
    last_rounds: int = setting(5, "rounds", "at most once the motion is free: a quick one settles late", "time")
    loosened: float = setting(
        32.0,
        "times its estimate",
        "roughness that a clean recording needs to leave nothing that goes with the motion",
        "trials",
    )
    far: float = setting(0.3, "relative", "change of a level above which it is extrapolated", "numerics")
    faster: float = setting(0.5, "of the change", "that is added then", "numerics")
    settled: float = setting(
        0.05, "relative", "change of every level, and of a law's numbers, that ends the rounds", "numerics"
    )
    faint_damping: float = setting(1e-6, "of the diagonal", "damping that leverages do not show", "numerics")


REML = RemlConfig()


@dataclass(frozen=True)
class DecimationConfig:
    """Samples at a lower rate for the fit."""

    band_hz: float = setting(1.0, "Hz", "of which the power is held against the noise's", "statistics")
    margin: float = setting(
        1.2, "1", "times where a motion ends stays as it is; below the noise the motion goes on", "judgement"
    )
    roll_off: float = setting(1 / 3, "of the rate", "Meyer's own; a steeper filter rings for longer", "numerics")
    reach: int = setting(
        12, "samples", "of the new rate, to which weights go: what a filter passes is off by 1e-6", "numerics"
    )
    points: int = setting(64, "per sample", "between which the weights are interpolated, by 1e-9", "numerics")
    lost: float = setting(0.05, "of the time", "at both ends, where weights have no samples, at most", "judgement")
    jitter: float = setting(
        2e-4, "of a period", "stamps to the microsecond at 100 Hz are off by half of it, at 1 kHz by more", "numerics"
    )


DECIMATION = DecimationConfig()
