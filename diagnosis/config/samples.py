"""Thresholds of the checks of raw samples."""

from dataclasses import dataclass

import numpy as np

from imubench.setting import setting


@dataclass(frozen=True)
class ScreeningConfig:
    """What the samples are asked before any fit."""

    least_samples: int = setting(
        32, "samples", "fewer have no spectrum, and the checks say nothing of them", "statistics"
    )
    beside_clip_samples: int = setting(1, "samples", "left out on either side of a clipped one", "judgement")
    release_s: float = setting(0.4, "s", "before a declared swing, in which it begins", "physics")
    clip_ring_samples: int = setting(3, "samples", "about a clip that begin no knock: a filter rings there", "numerics")
    knock_s: float = setting(0.035, "s", "a knock is over after this", "physics")
    straight_s: float = setting(0.045, "s", "over which straight lines are laid where a knock is cut out", "numerics")
    jolt_rad_s: float = setting(1.0, "rad/s", "that a gyroscope jumps by where a segment is struck", "physics")
    resampling_degree: int = setting(
        6,
        "1",
        "of the polynomial that gaps are filled with, of as many samples at most; a longer gap ends a stretch",
        "numerics",
    )
    listed_times: int = setting(10, "times", "spelled out in a sentence", "convention")
    lasting_share: float = setting(
        0.25, "of a peak's power", "as long as the power is above, a knock lasts", "judgement"
    )


SCREENING = ScreeningConfig()


@dataclass(frozen=True)
class HighBandConfig:
    """The band above the motion, in which knocks are heard."""

    pass_hz: float = setting(15.0, "Hz", "a hand or a limb moves below, a knock reaches far above", "physics")
    kaiser_beta: float = setting(7.86, "1", "of the Kaiser window for 80 dB (Oppenheim and Schafer)", "numerics")
    window_s: float = setting(0.627, "s", "that window's length at 8 Hz from stop to pass", "numerics")
    level_from_s: float = setting(0.15, "s", "from a peak, where its local level begins", "judgement")
    level_to_s: float = setting(1.0, "s", "from a peak, where its local level ends", "judgement")
    unsure_factor: float = setting(
        10.0,
        "of the amplitude",
        "the bar over the level where that is unsure: near an end or at a doubted sample",
        "trials",
    )
    one_knock_s: float = setting(
        0.2, "s", "peaks nearer than this are one knock, and so are failures of a swing's equation", "physics"
    )
    echo_s: float = setting(0.35, "s", "fainter peaks so soon after a knock are its echo", "physics")
    echo_share: float = setting(0.1, "of the amplitude", "below which a later peak is an echo", "judgement")


HIGH_BAND = HighBandConfig()


@dataclass(frozen=True)
class ImpactConfig:
    """Peaks of the high band that are knocks, or single wild samples."""

    least_rate_hz: float = setting(45.0, "Hz", "a slower sensor has too little left above 19 Hz", "physics")
    left_out_power: float = setting(
        36.0, "of the level's power", "six times in amplitude: from there a peak is left out of a fit", "judgement"
    )
    tail_ratio: float = setting(4.0, "of amplitudes", "from which on peaks are counted as a tail", "judgement")
    tail_peaks: float = setting(
        0.05, "1", "peaks of a tail that are expected beside a knock by chance, at most", "statistics"
    )
    wild_rate_hz: float = setting(
        80.0, "Hz", "from this rate on a knock spans samples and a single wild one is none", "physics"
    )
    change_s: float = setting(0.05, "s", "a change takes no longer on either side of a peak", "physics")
    change_share: float = setting(0.35, "of a change", "how far what follows strays from it", "judgement")
    onset_share: float = setting(0.15, "of the peak", "where a knock begins", "judgement")


IMPACT = ImpactConfig()


@dataclass(frozen=True)
class NoiseFloorConfig:
    """White noise read off the quietest windows of a spectrum."""

    window_s: float = setting(2.0, "s", "the main lobe is then +- 2 Hz, what is beyond is 92 dB down", "numerics")
    least_hz: float = setting(12.0, "Hz", "the motion ends below", "physics")
    most_of_nyquist: float = setting(0.97, "of the Nyquist frequency", "the highest that is looked at", "judgement")
    bands: int = setting(4, "bands", "that a spectrum is compared in", "judgement")
    windows: int = setting(4, "windows", "that a median needs, and a hum to be heard in", "statistics")
    quartile: float = setting(0.25, "1", "of the windows' power: quieter ones tell the floor", "statistics")
    flat_power: float = setting(1.6, "ratio of powers", "up to which two bands say the same", "judgement")
    calm_share: float = setting(0.05, "of the windows", "that are calm enough to judge by", "judgement")
    steady_power: float = setting(
        1.25, "ratio of powers", "by which chance changes noise from calm windows to the others, at most", "trials"
    )
    rest_power: float = setting(
        2.5, "of the white power", "coloured noise and a declared level that is a little low stay below", "judgement"
    )
    rest_rad_s: float = setting(
        0.03, "rad/s", "a piece's mean rate against that of the others at rest: a slow turn is no rest", "physics"
    )
    least_rest_s: float = setting(1.0, "s", "of a rest", "judgement")


NOISE_FLOOR = NoiseFloorConfig()


@dataclass(frozen=True)
class NotchConfig:
    """A hum that is taken out of the samples."""

    half_width_hz: float = setting(
        2.0, "Hz", "on either side of a hum; one that wanders moves by 0.75 Hz from one window to the next", "physics"
    )
    least_stretch_s: float = setting(1.0, "s", "the shortest stretch that such a filter can be run over", "numerics")
    sideband_hz: tuple[float, ...] = setting(
        (0.25, 0.5, 1.0),
        "Hz",
        "on either side of a line, that its sidebands may reach, besides the half width",
        "judgement",
    )
    grid_factor: int = setting(8, "points", "of that grid for each frequency that a recording tells apart", "numerics")
    newton_steps: int = setting(3, "steps", "from the best of a grid to a line's frequency", "numerics")

    @property
    def reach_hz(self) -> tuple[float, ...]:
        """How far in Hz sidebands may reach, the half width the farthest."""
        return (*self.sideband_hz, self.half_width_hz)


NOTCH = NotchConfig()


@dataclass(frozen=True)
class ToneConfig:
    """A hum that is heard in the accelerometer."""

    window_s: float = setting(4.0, "s", "a resolution of a quarter of a hertz", "numerics")
    least_hz: float = setting(6.0, "Hz", "a slow motion is below", "physics")
    neighbours_to_hz: float = setting(2.5, "Hz", "from a line, where its neighbourhood ends", "numerics")
    broken_windows: int = setting(
        3, "windows", "of a recording that is too short, or broken too often, for a span", "statistics"
    )
    window_contrast: float = setting(6.0, "of the neighbourhood's power", "in the median window of a span", "judgement")
    wander_hz: float = setting(0.75, "Hz", "from one window to the next", "physics")
    noise_beside_hz: float = setting(
        4.0, "Hz", "from a line, where its amplitude's noise is taken; a one-second window reaches 2", "numerics"
    )
    harmonics: tuple[int, ...] = setting(
        (2, 3, 4), "multiples", "of a line in the motion that are none of their own", "physics"
    )
    main_share: float = setting(
        0.3, "of the strongest line's power", "that a line with harmonics has at least", "judgement"
    )
    moved_power: float = setting(4.0, "of the noise power", "from which a frequency belongs to the motion", "judgement")

    @property
    def neighbours_from_hz(self) -> float:
        """In Hz from a line, where its neighbourhood begins: the main lobe of a window of four terms ends there."""
        return 4 / self.window_s

    @property
    def usual_least_hz(self) -> float:
        """In Hz: where motion ends, and a line's width above."""
        return NOISE_FLOOR.least_hz + self.neighbours_from_hz

    @property
    def log_contrast(self) -> float:
        """The natural logarithm of that contrast."""
        return float(np.log(self.window_contrast))


TONE = ToneConfig()


@dataclass(frozen=True)
class QuietMomentsConfig:
    """The quietest moments, which bound the noise from above."""

    window_s: float = setting(0.5, "s", "of a window", "judgement")
    samples: int = setting(8, "samples", "in a window", "statistics")
    share: float = setting(0.1, "of the windows", "that count as quiet", "judgement")
    finest: float = setting(
        1e-6, "rad/s or m/s^2", "below what any IMU resolves: a dead channel reads one number", "data sheet"
    )
    quieter_than_quietest: float = setting(
        0.1, "of the quietest moments", "motion is no ten times louder than noise there", "judgement"
    )
    most_bias_rad_s: float = setting(
        0.1, "rad/s", "+-5 deg/s is the zero-rate tolerance of the MPU-9250 (PS-MPU-9250A-01, table 1)", "data sheet"
    )
    rest_samples: int = setting(
        40, "samples", "of three axes: the std is then known within 7 %, and chance correlates by 0.1", "statistics"
    )
    correlation_lag_s: float = setting(0.15, "s", "a period of 7 Hz, and the rise of anything slower", "physics")


QUIET_MOMENTS = QuietMomentsConfig()


@dataclass(frozen=True)
class LatticeConfig:
    """Rounded and clipped readings."""

    off_lattice: float = setting(
        0.02, "of a step", "a gap of continuous values falls so near a multiple in 4 of 100", "statistics"
    )
    gaps: int = setting(8, "gaps", "that many lie on a lattice by chance once in 0.04^8", "statistics")
    repeats: int = setting(20, "values", "fewer gaps will do if values come back so often", "statistics")
    skipped_steps: int = setting(4, "steps", "up to which the median gap may be as wide", "judgement")
    fine_step: float = setting(
        0.01, "of the noise", "a step so small that three equal largest values are no chance (1e-3)", "statistics"
    )
    plateau_samples: int = setting(3, "samples", "equal largest values that make a limit", "statistics")
    drop_steps: float = setting(20.0, "steps", "how far a reading falls beside a clip", "judgement")
    drop_s: float = setting(0.1, "s", "within which it falls so far", "physics")


LATTICE = LatticeConfig()


@dataclass(frozen=True)
class DropoutConfig:
    """Lost and repeated samples."""

    jitter: float = setting(
        0.15, "of the sampling interval", "under which a gap is counted in whole samples", "judgement"
    )
    moving_steps: float = setting(3.0, "steps", "between the neighbours of a repeated sample", "statistics")
    run_samples: int = setting(10, "samples", "a longer run of repeats is no scattered loss", "judgement")
    run_s: float = setting(0.25, "s", "the same in time", "judgement")
    share: float = setting(0.005, "of the samples", "fewer repeats or gaps are everyday", "judgement")
    events: int = setting(5, "events", "fewer repeats or gaps are everyday", "judgement")


DROPOUT = DropoutConfig()
