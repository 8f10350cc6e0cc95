"""Thresholds of what is said in the end."""

from dataclasses import dataclass

from imubench.setting import setting


@dataclass(frozen=True)
class FindingsConfig:
    """Findings and their numbers."""

    read_off_std: float = setting(
        0.05,
        "of a value",
        "that is read off the states: their range over the recording, no variance is carried yet",
        "judgement",
    )
    much: float = setting(
        0.1,
        "of what a name is worth",
        "so much of it is no little of something else: a curve holds a scale too; one worth less than so much of what "
        "all leave is doubted beside a stronger one; those worth more are nearly always true (lab 029)",
        "judgement",
    )


FINDINGS = FindingsConfig()


@dataclass(frozen=True)
class ShiftConfig:
    """What a finding moves."""

    most_times: int = setting(2000, "times", "at most: an RMS over a minute does not change by more", "time")


SHIFT = ShiftConfig()


@dataclass(frozen=True)
class TrustConfig:
    """Whether the numbers of a found model may be believed."""

    serves: float = setting(
        0.3,
        "of an effect's number, or vector",
        "one that is so far off still takes away 0.9 of the effect's power",
        "statistics",
    )


TRUST = TrustConfig()


@dataclass(frozen=True)
class KnockConfig:
    """Knocks, and whether they are a joint's play."""

    moments: int = setting(9, "moments", "of a stretch that are looked at", "time")
    called_play: int = setting(3, "knocks", "that are called so", "judgement")
    from_s: float = setting(-0.01, "s", "from the beginning of a knock, within which it is", "physics")
    to_s: float = setting(0.06, "s", "from the beginning of a knock, within which it is", "physics")
    one_line: float = setting(
        0.9,
        "of the mean u u'",
        "0.97 of the play of an unseen trial; 0.49 to 0.66 of three limbs that were struck",
        "trials",
    )
    across_cosine: float = setting(0.25, "1", "of the line and the lever arm, at most", "physics")


KNOCK = KnockConfig()


@dataclass(frozen=True)
class BudgetConfig:
    """The time of a diagnosis."""

    limit_s: float = setting(
        600.0, "s of processor time", "ten times what 60 s at 100 Hz take, three times what 700 s at 50 Hz do", "time"
    )
    fit: float = setting(
        0.9,
        "of the limit",
        "the motion without any effect: nothing can be said without it, and something once it is there",
        "judgement",
    )
    search: float = setting(0.75, "of the limit", "the search for effects", "judgement")
    baseline: float = setting(0.5, "of the limit", "that a baseline's recording may take", "judgement")

    @property
    def terms(self) -> float:
        """Of the limit, terms without a name, and names for these: the rest is for the numbers of what is found."""
        return self.fit


BUDGET = BudgetConfig()


@dataclass(frozen=True)
class SameSensorsConfig:
    """A diagnosis of the same sensors, undisturbed."""

    same_rate: float = setting(
        0.02,
        "relative",
        "a processor's own clock is right within 1 % (effects/timing.py), and two are compared",
        "data sheet",
    )


SAME_SENSORS = SameSensorsConfig()
