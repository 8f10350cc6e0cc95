"""Thresholds by which one model is preferred to another."""

from dataclasses import dataclass

from imubench.diagnosis.config.shared import DECLARED_NOISE, EVIDENCE, STATISTICS
from imubench.setting import setting


@dataclass(frozen=True)
class HeldOutConfig:
    """Cross-validation."""

    least_blocks: int = setting(8, "blocks", "when the recording is short", "statistics")
    bootstrap_draws: int = setting(2000, "draws", "of blocks", "time")
    little: float = setting(0.01, "of what is gained", "that blocks without a say may lose", "judgement")
    against: float = setting(0.2, "of what some blocks gain", "that others may lose", "judgement")

    @property
    def block_s(self) -> float:
        """In s, left out at a time: as short a piece as can tell."""
        return EVIDENCE.least_s


HELD_OUT = HeldOutConfig()


@dataclass(frozen=True)
class AdmissionConfig:
    """When an effect is tried, and what else is asked."""

    refits: int = setting(
        3, "effects", "of the best scores, refitted exactly in each round, and of the closest rivals of one", "time"
    )
    screened_s: float = setting(15.0, "s", "of a recording on which effects with states are tried first", "time")
    most_effects: int = setting(5, "effects", "in one diagnosis", "judgement")
    few_readings: int = setting(300, "readings", "that tell a level: fewer may all be an effect's", "statistics")
    numbers_at_once: int = setting(8_000_000, "numbers", "of columns that are held together: memory", "time")

    @property
    def unexplained_misfit(self) -> float:
        """Misfit above which a sensor's own motion is tried too: more than a std that was declared too small leaves."""
        return DECLARED_NOISE.misdeclared_power


ADMISSION = AdmissionConfig()


@dataclass(frozen=True)
class EquivalenceConfig:
    """Effects that a recording cannot tell apart."""

    doubt: float = setting(
        0.2,
        "of what an effect explains",
        "a rival that would lose less is refitted, for laws are not linear",
        "judgement",
    )
    dull_level: float = setting(
        1.5, "of white noise", "from where on more is in doubt: a rival has its own part of the noise", "judgement"
    )
    dull_doubt: float = setting(0.6, "of what an effect explains", "the share that is refitted there", "judgement")


EQUIVALENCE = EquivalenceConfig()


@dataclass(frozen=True)
class ImpactTestConfig:
    """Whether a motion explains a peak."""

    beside_s: float = setting(0.25, "s", "on either side of a peak, in which the fit bends for it", "numerics")
    others: int = setting(20, "stretches", "of other samples that a peak is compared with", "statistics")
    least_others: int = setting(5, "stretches", "fewer tell nothing", "statistics")

    @property
    def others_alarm(self) -> float:
        """False alarm of each of the others: beyond, the fit leaves more than noise, and a peak may be that."""
        return STATISTICS.false_alarms_per_recording / self.others


IMPACT_TEST = ImpactTestConfig()


@dataclass(frozen=True)
class DelayConfig:
    """A filter that only delays, beside a clock."""

    cutoff_ratio: float = setting(
        1.12, "1", "how far a cutoff may be from that of the delay it stands for", "judgement"
    )
    step: float = setting(0.3, "of a delay", "at which a filter that stands for it is computed", "numerics")
    settled: float = setting(12.0, "delays", "after which a filter has forgotten how it began", "numerics")
    difference: float = setting(0.05, "of a delay", "by which it is changed to see the slope", "numerics")
    short: float = setting(
        0.03, "of a sampling interval", "a delay with which the series is right within 1 % at half the rate", "numerics"
    )
    quick: float = setting(
        0.3,
        "of what a delay does to a reading",
        "a filter that does less beside it is far quicker than the motion",
        "judgement",
    )


DELAY = DelayConfig()


@dataclass(frozen=True)
class LawConfig:
    """Effects with states and the laws that these obey."""

    doubted_share: float = setting(0.05, "of what drives a law", "that may be left", "judgement")
    tighter: float = setting(0.1, "of a law's level", "at its floor: tried as well", "judgement")
    decided: float = setting(
        10.0, "of the freedoms", "worth so much, a refit is not chosen or refused for them", "judgement"
    )
    tighter_cost_nat: float = setting(1.0, "nat", "which a tighter law may cost", "judgement")
    free_roughness: tuple[float, ...] = setting(
        (1e2, 1e3, 1e4, 1e5), "unit/s^4/sqrt(Hz)", "of a free state, a grid", "numerics"
    )
    amount_std: float = setting(
        0.3,
        "1",
        "about 1, of the share of a driven motion that a recording shows: the fit has taken in some",
        "judgement",
    )
    least_amount: float = setting(0.01, "of a driven motion", "at which a fit begins that may scale it", "numerics")
    fewer_states: float = setting(0.1, "of the best promise", "what one with fewer states may lack", "judgement")
    fair: float = setting(
        0.3, "of the best point's promise", "of such points that comes first whose amount is nearest to 1", "judgement"
    )
    loose_state: float = setting(
        1e-6, "of a plausible size", "how weakly a driven state is held where nothing says where it is", "numerics"
    )
    told_state: float = setting(
        1e-3, "of a plausible size", "the same of a filter's, and of one that the effect itself tells", "numerics"
    )

    @property
    def middle_roughness(self) -> float:
        """At which the points of its grid are compared."""
        return self.free_roughness[1]


LAW = LawConfig()


@dataclass(frozen=True)
class ObservabilityConfig:
    """Which directions of a number a recording shows."""

    hidden: float = setting(
        0.5,
        "of a prior's std",
        "the data alone would say less than 1 / sqrt(3) of the prior: see `directions`",
        "statistics",
    )
    along_cosine: float = setting(
        0.94, "1", "of 20 deg: a direction so near to an axis is called by its name", "convention"
    )


OBSERVABILITY = ObservabilityConfig()
