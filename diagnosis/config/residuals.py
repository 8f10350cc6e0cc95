"""Thresholds of what residuals are asked."""

from dataclasses import dataclass

from imubench.setting import setting


@dataclass(frozen=True)
class ExcessNoiseConfig:
    """Noise that is louder than declared."""

    flat_power: float = setting(
        1.15, "of the whole's power", "by how much a band may differ, beyond what chance lets it", "judgement"
    )
    visible: float = setting(
        0.3, "of the white power", "that the fit must leave, in a band or in all, to tell", "judgement"
    )
    window_s: float = setting(1.0, "s", "of calm and quick moments", "judgement")
    tail: float = setting(0.5, "1", "by which a fourth moment is over 3: heavier tails are no noise", "judgement")
    own_level: float = setting(
        0.1,
        "relative",
        "by which a level is far from its own: two IMUs share what one was blamed for, until it is clear",
        "judgement",
    )
    strained: float = setting(5.0, "std of a prior", "beyond which a number is none that a sensor has", "judgement")
    strained_alone: float = setting(8.0, "std of a prior", "the same where nothing else makes up for it", "trials")


EXCESS_NOISE = ExcessNoiseConfig()


@dataclass(frozen=True)
class LocalizeConfig:
    """Where residuals exceed the noise, and what they go with."""

    most: float = setting(0.8, "of the excess", "that bands and windows hold", "convention")
    small: float = setting(0.05, "of the excess", "smaller parts are not named", "convention")
    weak: float = setting(
        0.25, "of the mean of the bins that hold most", "weaker ones do not belong to them", "judgement"
    )
    bin_s: float = setting(0.5, "s", "windows are made of these", "judgement")
    local_s: float = setting(0.2, "s", "over which local power is compared with the motion", "judgement")
    whole: float = setting(0.7, "of the recording, or of the spectrum", "from there on it is all of it", "convention")
    windows: int = setting(6, "windows", "that are named, at most", "convention")
    bands: int = setting(4, "bands", "that are named, at most", "convention")
    correlation: float = setting(0.5, "1", "of what is named", "judgement")
    lead: float = setting(0.05, "1", "of its correlation over the next", "judgement")
    grid_hz: float = setting(200.0, "Hz", "of the grid that regressors are given on", "numerics")
    reversal_s: float = setting(0.05, "s", "half width of the bump about a reversal", "judgement")
    moving: float = setting(
        0.1, "of the RMS rate", "a reversal has to go from this to this, the other way", "judgement"
    )


LOCALIZE = LocalizeConfig()
