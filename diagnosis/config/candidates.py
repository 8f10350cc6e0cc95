"""Thresholds of where a fit begins with effects that are far from linear."""

from dataclasses import dataclass

from imubench.setting import setting


@dataclass(frozen=True)
class GivingWayConfig:
    """Mounts or a joint that give way by more than any gyroscope's noise."""

    explained: float = setting(
        0.25,
        "of the power that a fit left before",
        "at most: else it is more than one thing that gives way, or a second one beside it that may be none",
        "judgement",
    )
    left: float = setting(
        0.8,
        "of the power left before",
        "at most, by the first steps: what promises less than a fifth is not what gives way",
        "trials",
    )


GIVING_WAY = GivingWayConfig()


@dataclass(frozen=True)
class EndStopConfig:
    """A stop that a free swing knocks against."""

    same_rad: float = setting(
        0.02, "rad", "how closely knocks agree, as a median: stops 0.003; so near, a limb is at its stop", "trials"
    )
    same_share: float = setting(0.01, "of the swing", "the same, of how far the joint swings", "trials")
    beyond_rad: float = setting(0.15, "rad", "that a smeared contact may seem to go beyond the stop", "numerics")
    beyond_share: float = setting(0.2, "of the swing", "the same, of how far the joint swings", "numerics")
    soon_rad: float = setting(
        0.3, "rad", "the same right after a knock: the spline turns round later than the segment", "numerics"
    )
    soon_s: float = setting(0.1, "s", "after a knock that was heard, for which that holds", "numerics")
    pad_s: float = setting(0.02, "s", "around it that are left out with it", "numerics")
    grid_s: float = setting(0.005, "s", "between the times that are looked at", "numerics")
    unsettled_rad: float = setting(
        0.1, "rad", "an angle so little known without the knocks was chosen to suit them, and is none", "judgement"
    )
    least_std_rad: float = setting(0.002, "rad", "of the angle", "trials")
    least_std_about_rad: float = setting(
        0.03, "rad", "about an axis that is sought: four were off by 0.007 to 0.041", "trials"
    )


END_STOP = EndStopConfig()


@dataclass(frozen=True)
class ContactConfig:
    """Contacts that nobody heard, where the equation of a swing fails."""

    fails: float = setting(
        20.0, "of the median", "by which the equation fails where a limb is pushed back", "judgement"
    )
    half_s: float = setting(
        0.06, "s", "on either side of where it fails most, which its equation is not asked about", "physics"
    )
    rounds: int = setting(5, "rounds", "in which contacts are looked for", "time")
    smeared_s: float = setting(
        0.5,
        "s",
        "on either side of which the spline makes up for what it cannot follow: the next round tells",
        "numerics",
    )
    along: float = setting(0.2, "of a push", "along the limb or upright: a stop's has none of one of them", "physics")
    astray_rad: float = setting(0.35, "rad", "by which the axis that a push tells of may be off", "judgement")
    one_angle_rad: float = setting(0.05, "rad", "within which contacts begin at one angle, the farthest", "judgement")
    least_std_rad: float = setting(
        0.015, "rad", "of a pendulum's stop: 16 were off by 0.009 in RMS, 0.020 at most", "trials"
    )


CONTACT = ContactConfig()


@dataclass(frozen=True)
class MountStartConfig:
    """A mount that is turned or moved by far, and lines of a spectrum."""

    reach_m: float = setting(3.0, "m", "what seems farther away has not been seen", "physics")
    agree: float = setting(
        0.25,
        "of a gyroscope's reading",
        "where the two agree so well across the axis no mount is turned far",
        "judgement",
    )
    faint: float = setting(
        0.03,
        "of the strongest",
        "a turn that is seen less is noise, as all are but one on a base that stands still",
        "judgement",
    )
    far_rad: float = setting(0.35, "rad", "what is turned by less is found from where it is declared", "numerics")
    better: float = setting(0.5, "of the cost of the start as declared", "that one begun anew must have", "judgement")


MOUNT_START = MountStartConfig()


@dataclass(frozen=True)
class HumStartConfig:
    """Where a hum begins."""

    line_bins: int = setting(41, "bins", "of a spectrum that a line must stand out of", "numerics")


HUM_START = HumStartConfig()


@dataclass(frozen=True)
class SlipScanConfig:
    """When a mount slips."""

    apart_s: tuple[float, ...] = setting(
        (2.0, 0.3, 0.1, 0.05), "s", "between the moments of a slip that are compared, closer and closer", "numerics"
    )
    around: int = setting(
        2, "moments", "to either side are looked at anew: a peak is as narrow as a slip is short", "numerics"
    )
    coarse_moments: int = setting(60, "moments", "of a long recording, first", "time")
    peak_moments: int = setting(3, "moments", "to either side of the loudest", "numerics")
    parts: int = setting(4, "parts", "of a slip, at which the loudest stretch may begin", "numerics")
    clear: float = setting(1.25, "of a slip's length", "from one to the next", "judgement")

    @property
    def peak_s(self) -> float:
        """In s, between moments about the loudest, as near as any."""
        return self.apart_s[-1]


SLIP_SCAN = SlipScanConfig()
