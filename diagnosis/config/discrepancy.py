"""Thresholds of terms without a name."""

from dataclasses import dataclass

from imubench.setting import setting


@dataclass(frozen=True)
class BasisConfig:
    """Functions that terms are made of."""

    pieces: int = setting(
        6, "pieces", "of a cubic spline over the range of what it is a function of: 9 weights", "judgement"
    )
    drift_piece: float = setting(
        1.3, "blocks", "of held-out data that a drift's pieces last, or it could not be predicted", "statistics"
    )
    kinks: tuple[float, ...] = setting(
        (0.01, 0.03, 0.1, 0.3), "of the scatter", "of what is signed, where a law may break", "judgement"
    )
    zones: tuple[float, ...] = setting(
        (0.07, 0.14, 0.28, 0.56, 1.12), "of the scatter", "where a law may break besides", "judgement"
    )
    play_widths: tuple[float, ...] = setting(
        (0.03, 0.06, 0.12, 0.25, 0.5), "of a reading's scatter", "half widths of play that it may have", "judgement"
    )
    settling: tuple[float, ...] = setting(
        (0.05, 0.15, 0.45), "of a recording", "times after which a share 1/e is left of what settles", "judgement"
    )
    shaking_s: tuple[float, ...] = setting((0.1, 0.3, 1.0), "s", "over which shaking is felt", "judgement")
    shaking_hz: float = setting(2.0, "Hz", "from which on it is shaking", "physics")
    lags_s: tuple[float, ...] = setting(
        (0.02, 0.04, 0.08), "s", "by which a reading enters another axis later", "judgement"
    )
    harmonics: int = setting(12, "harmonics", "of the joint's angle", "judgement")
    turn_rad: float = setting(0.01, "rad", "size of a mount's turn", "judgement")
    sizes: tuple[float, ...] = setting(
        (0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0), "of the noise's std", "of weights that are tried", "numerics"
    )
    followed: float = setting(
        0.4, "of a signal's power", "that motion cannot follow: a first guess to rank by", "judgement"
    )


BASIS = BasisConfig()


@dataclass(frozen=True)
class TermConfig:
    """When a term without a name is believed."""

    rival: float = setting(
        0.5,
        "of the best promise",
        "from which the best of another place is fitted too, and which stays below where a curve over a "
        "sensor's own reading stands out",
        "judgement",
    )
    shape_nat: float = setting(
        4.0, "nat", "of a slow error's shape; in 67 recordings with nothing wrong 1.8 at most", "trials"
    )
    most_terms: int = setting(2, "terms", "in one diagnosis", "judgement")
    bends_nat: float = setting(
        1000.0,
        "nat",
        "from which on a term's signals are taken again: it has bent the motion that they were taken from",
        "judgement",
    )
    retakes: int = setting(3, "times", "that they are taken again, at most", "time")
    block_s: float = setting(1.0, "s", "left out at a time under a term that is a function of time", "judgement")
    own_law_takes: float = setting(
        0.75, "of the excess misfit", "at least, by the first fit of such a law", "judgement"
    )
    likely: int = setting(
        2,
        "terms",
        "the best, which are fitted at least until one is good; their triples, and those of drifts, are searched for a "
        "jump",
        "time",
    )
    jumps: int = setting(20, "times", "of a jump that are tried, twice", "time")
    exact: int = setting(
        8, "terms", "whose information is taken exactly, besides those that the motion follows", "time"
    )


TERM = TermConfig()


@dataclass(frozen=True)
class DriftConfig:
    """The shape of a slow error."""

    most_hz: float = setting(1.5, "Hz", "of the quickest cosine", "judgement")
    most_cosines: int = setting(60, "cosines", "at most", "time")
    least_information: float = setting(
        1e-6, "of the best known combination of cosines", "of one less known the recording says nothing", "numerics"
    )
    free_constant: float = setting(100.0, "std of white noise", "of a constant, which is free", "numerics")


DRIFT = DriftConfig()
