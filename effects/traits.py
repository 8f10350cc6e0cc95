"""What is asked of an effect beside its law: of what kind it is, what it resembles, what it is called.

A simulation, a diagnosis and a correction ask these questions instead of an effect's name. Each has an answer that
suits an effect of which nothing is declared, so that one from outside the library has to declare only what is special.
"""

from dataclasses import dataclass
from enum import Enum
from typing import ClassVar, Literal

Channel = Literal["", "gyro", "accel"]


class Fault(Enum):
    """What happens to single samples, by which the raw samples show it; in the order of a sensor's chain."""

    STRUCK = "struck"  # a short pulse on top of what is there
    NOISY = "noisy"  # louder white noise
    CLIPPED = "clipped"
    ROUNDED = "rounded"
    LOST = "lost"  # its row is missing, or says the one before again

    @property
    def measures_nothing(self) -> bool:
        """Whether a sample that has it says nothing of the motion, and a fit leaves it out."""
        return self in (Fault.STRUCK, Fault.CLIPPED, Fault.LOST)

    @property
    def by_chance(self) -> bool:
        """Whether it is drawn: simulated again, other samples have it."""
        return self in (Fault.STRUCK, Fault.LOST)


class Correction(Enum):
    """What is done about an effect in a recording that is corrected by its diagnosis, in words."""

    TAKEN_OUT = "taken out of the readings"
    MOUNT = "the declared mount is moved to where the sensor is"
    GRAVITY = "the declared one is changed"
    CLOCK = "the stamps are moved to the common clock"
    SHAPED = "nothing to correct: it shaped the motion, which the readings show as it was"
    FREE = (
        "left in: a motion without a law takes in what the mounts may explain, and would hand the fit's to an estimator"
    )
    NOISE = "left in: what it took cannot be given back; the declared noise is raised by it"
    CLIPPED = "clipped samples are left out"
    LOST = "repeated samples are left out"
    STRUCK = "knocked samples are left out"

    @property
    def stays(self) -> bool:
        """Whether the corrected readings are those of a model that has the effect still."""
        kinds = Correction
        return self in (kinds.MOUNT, kinds.GRAVITY, kinds.CLOCK, kinds.SHAPED, kinds.FREE)


OF_FAULT = {
    Fault.STRUCK: Correction.STRUCK,
    Fault.NOISY: Correction.NOISE,
    Fault.CLIPPED: Correction.CLIPPED,
    Fault.ROUNDED: Correction.NOISE,
    Fault.LOST: Correction.LOST,
}


NUMBERS_OF_FAULT = {
    Fault.STRUCK: {"times"},
    Fault.NOISY: {"std"},
    Fault.CLIPPED: {"limit"},
    Fault.ROUNDED: {"step"},
    Fault.LOST: {"fraction"},
}
"""What a fault is told by, in what the raw samples show: s, the unit of the channel, and a share."""


@dataclass(frozen=True)
class Alike:
    """Another effect that the same readings follow from, whatever the motion."""

    effect: str  # its name
    why: str
    words: str = ""  # for people, after "no motion tells it from:"; empty: the other effect says it
    at: str = ""  # where the one is that declares it: imu1; empty: anywhere
    other_at: str = ""  # where the other one is; empty: anywhere, but not at the same place
    base: str = ""  # of a recording that has to be free or fixed for that; empty: either
    in_swings: bool = True  # whether it holds in free swings too
    only_imus: bool = False  # whether an encoder or a measured pose would tell
    shared: bool = False  # whether every sensor has to have it, by one number


class Traits:
    """What is asked of an effect; each answer here is that of an effect of which nothing is declared."""

    phrase: ClassVar[str] = ""  # for people, "{imu}" its sensor: "a hum at {imu}"; empty: made of its name
    alike: ClassVar[tuple[Alike, ...]] = ()
    channel: Channel = ""  # the triple that it acts on alone

    # of errors of a sensor
    time_power: ClassVar[int | None] = None  # of what it adds, if that goes with time alone: 0 an offset, 1 a drift
    additive: ClassVar[bool] = False  # whether two of it, one on top of the other, are their sum
    crosses_axes: ClassVar[bool] = False  # whether an axis reads what another one meets
    tone: ClassVar[str] = ""  # the parameter in Hz of the steady line that it adds to the readings, of some amplitude
    in_every_sensor: ClassVar[bool] = False  # so that nobody doubts it beside poses whose errors wander
    fault: ClassVar[Fault | None] = None  # what it does to single samples
    on_sensor: ClassVar[bool] = True  # at an IMU: whether it goes along with the sensor to another place

    # of clocks and filters
    between_sensors: ClassVar[bool] = False  # whether the opposite one at the other sensor has the same readings
    late_by: ClassVar[str] = ""  # the parameter in s by which all that a sensor reads is late
    filters: ClassVar[bool] = False  # whether its readings follow the truth; to first order that is a delay
    leaves_to: ClassVar[tuple[str, ...]] = ()  # effects that take a part of what it does, where it is fitted in vain

    # of mounts
    misplaces: ClassVar[bool] = False  # whether the sensor is all along elsewhere than declared: rotation, translation
    onset: ClassVar[str] = ""  # the parameter in s at which it begins, once
    on_springs: ClassVar[bool] = False  # whether the sensor hangs on springs and dampers
    rocks: ClassVar[bool] = False  # whether it turns on them, and is not displaced
    scales_angle: ClassVar[bool] = False  # whether with other numbers a joint that turns faster looks the same

    # of joints, and of torques in free swings
    loosens: ClassVar[bool] = False  # whether its state turns a limb across its hinge: (1) about its axis, or (2) x, z
    knocks: ClassVar[bool] = False  # whether what a sensor reads as a knock comes from it
    carries_joint: ClassVar[bool] = False  # whether it pushes the joint itself about
    slow_share: ClassVar[float] = 0.0  # of its states' power, that a slow curve leaves where these are only that
    friction: ClassVar[bool] = False  # whether it resists the rate of a joint
    torque_jumps: ClassVar[bool] = False  # whether its torque is another one within an instant
    holds_by: ClassVar[str] = ""  # the parameter in N m of the torque with which it holds a joint that rests
    rests_at: ClassVar[str] = ""  # the parameter in rad of the angle at which its spring is slack
    stops_at: ClassVar[str] = ""  # the parameter in rad of the angle at which it stops a joint


NO_TRAITS = Traits()
"""The answers of what is no effect of the library."""

__all__ = ["NO_TRAITS", "NUMBERS_OF_FAULT", "OF_FAULT", "Alike", "Channel", "Correction", "Fault", "Traits"]
