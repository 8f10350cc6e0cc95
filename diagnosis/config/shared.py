"""Chances, sigmas, evidence and confidences that several rooms decide by."""

from dataclasses import dataclass

import numpy as np

from imubench.setting import setting


@dataclass(frozen=True)
class StatisticsConfig:
    """How rare a coincidence must be before it counts."""

    false_alarms_per_recording: float = setting(
        1e-3, "1", "false alarms of one check on a recording of noise alone: one in a thousand recordings", "judgement"
    )
    false_alarm_of_one: float = setting(
        1e-6, "1", "false alarm of one channel or one peak: of a thousand in a recording 0.1 % in all", "statistics"
    )
    clear_sigmas: float = setting(
        3.0, "std", "what stands out by so much is no chance: 0.3 % of normal deviates, two-sided", "statistics"
    )
    rare_sigmas: float = setting(
        4.0,
        "std",
        "the same where some fifty numbers are looked at: one recording in 300 has one so far off by chance; a number "
        "so far off its prior is none of nature's, and a law so far off its std does not hold",
        "statistics",
    )
    band_sigmas: float = setting(
        2.5, "std", "scatter of a band's power that white noise is allowed: 1.2 % of bands, two-sided", "statistics"
    )
    interval_sigmas: float = setting(1.96, "std", "half width of the 95 % interval of a normal deviate", "statistics")
    seed: int = setting(4401, "1", "of the draws of noise and of blocks: a diagnosis repeats itself", "convention")


STATISTICS = StatisticsConfig()


@dataclass(frozen=True)
class EvidenceConfig:
    """What a recording must have, and an explanation gain in log likelihood, before anything is said."""

    needed_nat: float = setting(
        5.0,
        "nat",
        "odds of 150: of some 60 candidates the best by chance stays below, and a rival within it is as good",
        "statistics",
    )
    clear_nat: float = setting(10.0, "nat", "odds of 22,000: a gain so large needs no further proof", "statistics")
    certain_nat: float = setting(
        30.0,
        "nat",
        "that need no closer look: coloured noise, or what is screened on a part, is worth less",
        "judgement",
    )
    state_nat: float = setting(
        15.0, "nat", "that splines must be worth, which fit more, and a filter's delay alone", "judgement"
    )
    events: int = setting(2, "events", "that can agree; one may be anything that happens once", "statistics")
    least_s: float = setting(5.0, "s", "a shorter recording, or piece of one, is too short to tell", "judgement")


EVIDENCE = EvidenceConfig()


@dataclass(frozen=True)
class ConfidenceConfig:
    """What a confidence means, and its caps."""

    counts: float = setting(0.5, "1", "more likely than not: from here a finding counts in the verdict", "convention")
    sure: float = setting(
        0.9, "1", "of noise power beyond the declared, and from where a finding stands before doubted ones", "judgement"
    )
    doubtful: float = setting(
        0.6,
        "1",
        "at most, where something else is as likely: what has no name, a law that was worth as much, a stronger name, "
        "or for one knock what happens once; as often as such names were true in blind trials (lab 009, 012)",
        "trials",
    )
    repeated: float = setting(0.95, "1", "of several knocks, and of a stop at whose angle all begin", "judgement")
    free_splines: float = setting(
        0.65,
        "1",
        "at most, of splines without a law, which follow anything, and of a law beside which the fit leaves too much; "
        "hardly more than half of such names were true in blind trials (lab 009)",
        "trials",
    )
    strange: float = setting(
        0.2,
        "1",
        "at most, of a name beside something without one that is worth as much, or at a sensor with numbers that no "
        "sensor has; hardly any such name was true in blind trials (lab 009, 010)",
        "trials",
    )


CONFIDENCE = ConfidenceConfig()


@dataclass(frozen=True)
class DeclaredNoiseConfig:
    """How far a declared noise may be from the true one."""

    std_error: float = setting(
        0.15, "of the std", "a noise std read off a data sheet or a short rest is right within so much", "judgement"
    )
    colour: float = setting(
        0.2, "of the white power", "coloured noise, or rounding, up to this is noise and no mismatch", "judgement"
    )
    rough_motion: float = setting(
        1.3, "of the power", "a motion held too smooth for a rough stroke leaves so much", "judgement"
    )

    @property
    def least_std(self) -> float:
        """Of the declared std: no estimate goes below."""
        return 1 - self.std_error

    @property
    def unsure(self) -> float:
        """Times an error, less than which is lost in how well the noise is known."""
        return 1 + self.std_error

    @property
    def most_std(self) -> float:
        """Times the declared std, coloured noise on top of an error of the std."""
        return self.unsure * float(np.sqrt(1 + self.colour))

    @property
    def most_power(self) -> float:
        """Times the declared power, beyond which a sensor is louder than declared."""
        return self.unsure**2 * (1 + self.colour) * self.rough_motion

    @property
    def raised_std(self) -> float:
        """Times the declared std, beyond which something else has raised the level."""
        return float(np.sqrt(self.most_power))

    @property
    def misdeclared_power(self) -> float:
        """Times the declared power, where the std was declared too small by its error."""
        return 1 / (1 - self.std_error) ** 2

    @property
    def held_out_misfit(self) -> float:
        """Misfit of samples each predicted from all others; white noise has 1."""
        return 1 + self.colour


DECLARED_NOISE = DeclaredNoiseConfig()
