"""Recordings that the diagnosis once got wrong, and what must be said of each: one row a recording.

To add one, append a row: a name for what went wrong, how the recording is made, what must be said. A row whose `open`
has text is expected to fail, for that reason.
"""

from tests.regressions.recordings import Blind, Made, Making
from tests.regressions.said import (
    Doubted,
    EqualToFirst,
    Exactly,
    First,
    NothingBut,
    Number,
    Said,
    SomethingUnnamed,
    Sure,
)


class Regression:
    """A recording and what must be said of it."""

    def __init__(self, name: str, making: Making, *said: Said, open: str = "") -> None:
        self.name, self.making, self.said, self.open = name, making, said, open


DRAWN = {
    "rate": 128.0, "band": 7.90309048988685, "vigour": 0.6493038878030858, "rest": 0.217010593964019,
    "gyro_noise": 0.0029279329873173636, "accel_noise": 0.014444382276273319, "misdeclared": 1.0,
    "position_std": 0.005299230021230847, "rotation_std": 0.023475489210241843, "gaps": 1,
}  # fmt: skip
DRAWN_OF_A_PENDULUM = {
    "rate": 200.0, "rate2": 200.0, "band": 6.5950337113701885, "vigour": 0.936049610367441, "rest": 0.255712719856621,
    "gyro_noise": 0.0036734311364231055, "accel_noise": 0.015800005634662, "misdeclared": 0.04542990770630462,
    "position_std": 0.0038742923422232256, "rotation_std": 0.016881518748580404, "declare_geometry": False,
    "repeats": 1,
}  # fmt: skip

REGRESSIONS = (
    Regression("a quick motion, not settled", Blind(7, 20, 3), Exactly()),
    Regression("strokes held too smooth", Blind(7, 20, 10), Exactly()),
    Regression("a mount that only its declaration contradicts", Blind(7, 20, 0), Exactly("mount_pose imu2")),
    Regression("noise in the motion that residuals went with", Blind(4021, 40, 7, seconds=40.0), Exactly()),
    Regression("a free spline for a drift", Blind(4021, 40, 31, seconds=40.0), Exactly("gyro_drift imu1")),
    Regression("a coupling that a refused filter hid", Blind(1014141228, 300, 3), Exactly("axis_coupling joint")),
    Regression(
        "a pivot that moves less than the fit is loose", Blind(1014141228, 300, 29), Exactly("moving_pivot joint")
    ),
    Regression("a motion held too smooth, late where it turns", Blind(31025185, 300, 92), Exactly()),
    Regression(
        "a pivot that took more noise than slow noise can give",
        Blind(897729449, 80, 43),
        Exactly("moving_pivot joint", "vibration imu1"),
    ),
    Regression("springs with which the fit resounds", Blind(31025185, 300, 179), Exactly("rocking_mount imu1")),
    Regression("an exponential creep, no drift", Blind(1014141228, 300, 21), Exactly("unknown imu2")),
    Regression(
        "a creep of which a slip had a step, and the joint the rest", Blind(20261125, 300, 67), Exactly("unknown imu2")
    ),
    Regression("a bias that jumps, at its own IMU", Blind(1014141228, 300, 22), Exactly("unknown imu1")),
    Regression(
        "a quick filter held beside a motion that had known a delay alone",
        Blind(930467002, 300, 15),
        Exactly("low_pass imu2"),
    ),
    Regression(
        "a filter, a bias and a coupling that need each other",
        Blind(1014141228, 300, 14),
        Exactly("axis_coupling joint", "gyro_bias imu1", "low_pass imu1"),
        open="an IMU that slides with its skin for the coupling, again",
    ),
    Regression("springs that bend, whatever a linear step foretells", Blind(3064914, 300, 38), Exactly("unknown imu1")),
    Regression("hysteresis, which a filter that breaks its law held", Blind(4896999, 300, 8), Exactly("unknown imu2")),
    Regression("a bias that jumps, which a moving pivot held", Blind(4896999, 300, 18), Exactly("unknown imu1")),
    Regression("a slip dated beside its own peak", Blind(4896999, 300, 84), Exactly("mount_shift imu1")),
    Regression("a gyroscope's walk, which a moving pivot held", Blind(4896999, 300, 34), Exactly("unknown imu1")),
    Regression(
        "a misalignment that a term of what a filter leaves could have been",
        Blind(4896999, 300, 52),
        Exactly("low_pass imu2", "gyro_misalignment imu2", "dropouts imu2"),
    ),
    Regression(
        "a g-sensitivity that no half of the recording tells from a bias",
        Blind(4896999, 300, 12),
        Exactly("g_sensitivity imu1"),
    ),
    Regression(
        "a g-sensitivity that adds up, and shows in no short block",
        Blind(20261125, 300, 55),
        Exactly("mount_shift imu1", "g_sensitivity imu1", "accel_bias imu1"),
    ),
    Regression("a clock's skew, most of it seen at the end", Blind(4896999, 300, 83), Exactly("clock_skew imu1")),
    Regression(
        "an IMU displaced, and not the other one too",
        Blind(4896999, 300, 279),
        Exactly("impacts imu1", "g_sensitivity imu2", "mount_pose imu1"),
    ),
    Regression(
        "cross-talk on a pendulum, whose motion follows its gyroscope",
        Blind(25387302, 300, 48),
        Exactly("unknown imu1"),
    ),
    Regression(
        "a pivot and springs that were an accelerometer's steps", Blind(25387302, 300, 55), Exactly("quantisation imu1")
    ),
    Regression(
        "an accelerometer that clips throughout",
        Blind(48324412, 300, 3),
        Exactly("axis_coupling joint", "saturation imu2"),
    ),
    Regression("an accelerometer's walk that was a pivot's", Blind(48324412, 300, 15), Exactly("unknown imu1")),
    Regression("rectification that was a pivot's", Blind(48324412, 300, 71), Exactly("unknown imu1")),
    Regression("hysteresis that was a filter, a delay and a scale", Blind(48324412, 300, 110), Exactly("unknown imu1")),
    Regression(
        "an accelerometer's walk, of which the other IMU was blamed", Blind(48324412, 300, 122), Exactly("unknown imu1")
    ),
    Regression("steps of which a short recording skips most", Blind(48324412, 300, 288), Exactly("quantisation imu2")),
    Regression("knocks that a free motion follows", Blind(48324412, 300, 22), Exactly("impacts imu1")),
    Regression(
        "the same beside other effects",
        Blind(48324412, 300, 219),
        Exactly("accel_drift imu1", "accel_noise imu1", "impacts imu1"),
    ),
    Regression(
        "knocks too faint for the raw samples",
        Blind(25387302, 300, 187),
        Exactly("mount_shift imu2", "gyro_scale imu1", "impacts imu1"),
    ),
    Regression(
        "a spring that looked like a lighter body",
        Blind(4021, 40, 2, seconds=40.0),
        Exactly("joint_spring joint", "viscous_friction joint", "gyro_scale imu2"),
    ),
    Regression("a creep that a slip held", Blind(495495588, 300, 159), Exactly("unknown imu1")),
    Regression("a creep as faint as its noise is coloured", Blind(495495588, 300, 295), Exactly("unknown imu1")),
    Regression(
        "cross-talk that names held with numbers that no sensor has", Blind(495495588, 300, 87), Exactly("unknown imu2")
    ),
    Regression(
        "springs that bend as much on every axis",
        Blind(495495588, 300, 151),
        Exactly("soft_mount imu1", "unknown imu1"),
    ),
    Regression(
        "a bias and a drift whose part nine numbers took",
        Blind(495495588, 300, 25),
        Exactly("gravity world", "gyro_bias imu1", "gyro_drift imu1"),
    ),
    Regression(
        "a mount, a bias and a g-sensitivity that a filter held which broke its law",
        Blind(495495588, 300, 45),
        Exactly("accel_bias imu1", "rocking_mount imu1", "g_sensitivity imu1"),
    ),
    Regression(
        "a misalignment that cost more than it explained",
        Blind(495495588, 300, 130),
        Exactly("gyro_misalignment imu2"),
        open="nothing is said, again",
    ),
    Regression(
        "a stop whose first knock is smeared",
        Blind(495495588, 300, 255),
        Exactly("end_stop joint"),
        open="something without a name at the joint beside the stop",
    ),
    Regression(
        "axes far off, by a sensor that tells little",
        Blind(315475440, 300, 104),
        Exactly("quantisation imu1", "accel_misalignment imu1"),
    ),
    Regression("a knock just before a gap", Blind(315475440, 300, 213), Exactly("impacts imu1")),
    Regression(
        "a knock just before a limb is let go", Blind(315475440, 300, 273), Exactly("impacts imu2", "gravity world")
    ),
    Regression("knocks on a pendulum that hardly swings", Blind(315475440, 300, 206), Exactly("impacts imu1")),
    Regression("a joint's springs that were a mount's", Blind(315475440, 300, 33), Exactly("joint_play joint")),
    Regression("a joint's springs that were two mounts'", Blind(315475440, 300, 283), Exactly("joint_play joint")),
    Regression("play that falls over, and left a mount to rock", Blind(9001, 300, 73), Exactly("joint_play joint")),
    Regression(
        "a soft mount that a filter hid which was none in the end",
        Blind(118750459, 300, 249),
        Exactly("soft_mount imu1", "gyro_scale imu1", "gyro_drift imu1"),
    ),
    Regression(
        "a scale that was doubted for a rocking mount made of rounding",
        Blind(118750459, 300, 222),
        Exactly("quantisation imu1", "joint_spring joint", "accel_scale imu1"),
    ),
    Regression(
        "a scale at the other IMU, let in while a filter was at the wrong one",
        Blind(118750459, 300, 100),
        Exactly("low_pass imu2", "accel_scale imu1"),
    ),
    Regression(
        "a filter far quicker than the motion, half of it an offset",
        Blind(27112306, 300, 3),
        Exactly("low_pass imu2", "accel_scale imu1"),
    ),
    Regression(
        "springs that likely bend, and cannot be shown to",
        Blind(118750459, 300, 208),
        Exactly("soft_mount imu1", "unknown imu1"),
    ),
    Regression(
        "play that took nine minutes, and two names beside it", Blind(9004, 300, 10), Exactly("joint_play joint")
    ),
    Regression(
        "a filter of one triple, and a scale that one of both held",
        Blind(690200168, 300, 101),
        Exactly("low_pass imu1", "accel_scale imu1", "gyro_misalignment imu1"),
    ),
    Regression(
        "a filter that was worth something in its third round",
        Blind(690200168, 300, 57),
        Exactly("joint_play joint", "low_pass imu2", "accel_scale imu1"),
        open="another set, after many minutes",
    ),
    Regression(
        "a mount that its law's floor cost more than it explained",
        Blind(690200168, 300, 2),
        Exactly("accel_bias imu1", "rocking_mount imu1", "accel_noise imu1"),
    ),
    Regression(
        "a bias that knots for springs hid",
        Blind(690200168, 300, 69),
        Exactly("soft_mount imu1", "accel_bias imu1"),
        open="something without a name at imu1 for both",
    ),
    Regression("a wind that no term held", Blind(690200168, 300, 226), Exactly("unknown joint")),
    Regression("a pendulum's stop that is met once", Blind(690200168, 300, 225), Exactly("end_stop joint")),
    Regression("a pendulum's stop that is met twice", Blind(690200168, 300, 261), Exactly("end_stop joint")),
    Regression(
        "a pendulum's stop beside a noise and a bias",
        Blind(880003, 300, 77),
        Exactly("end_stop joint", "accel_noise imu1", "gyro_bias imu1"),
    ),
    Regression("a hum that was as good at the IMU that hums not", Blind(443282294, 300, 72), Exactly("vibration imu1")),
    Regression(
        "knocks that agree about an axis on which a pendulum hardly swings",
        Blind(443282294, 300, 186),
        Exactly("viscous_friction joint", "gyro_misalignment imu1", "impacts imu1"),
    ),
    Regression(
        "a skew that spoiled what a misalignment foretold",
        Blind(443282294, 300, 150),
        Exactly("gyro_misalignment imu1", "clock_skew imu2", "skin_sliding imu1"),
    ),
    Regression("play that was nearly all a curve of time", Blind(443282294, 300, 111), Exactly("unknown imu1")),
    Regression(
        "springs that were not at the noise that they leave",
        Blind(443282294, 300, 235),
        Exactly("rocking_mount imu1", "accel_misalignment imu1", "low_pass imu1"),
        open="something without a name at imu1, beside which the mount and a delay are doubted",
    ),  # a delay is its equal
    Regression(
        "springs that leaned on noise, and seemed to bend", Blind(443282294, 300, 290), Exactly("soft_mount imu2")
    ),
    Regression("springs that bend, which leaned on noise", Blind(73668495, 300, 191), Exactly("unknown imu1")),
    Regression("a creep whose gyroscope reads how fast it turns", Blind(73668495, 300, 142), Exactly("unknown imu1")),
    Regression("a creep of ten deviations", Blind(73668495, 300, 132), Exactly("unknown imu1")),
    Regression("a creep that left-out seconds hardly foretell", Blind(990402, 300, 56), Exactly("unknown imu1")),
    Regression("a walk of twelve deviations, told by its shape", Blind(990401, 300, 278), Exactly("unknown imu1")),
    Regression(
        "springs that ring now and then, and are no noise",
        Blind(990401, 300, 93),
        Exactly("unknown imu2", "impacts imu1"),
    ),
    # The truth is among what equals the first finding
    Regression(
        "a scale of 57 nat for 40, in noise three times louder there",
        Blind(690200168, 300, 59),
        EqualToFirst("accel_bias imu1"),
        open="an accelerometer's scale, and not the bias among its equals",
    ),
    Regression(
        "axes beside what the other IMU's axes read a little later",
        Blind(690200168, 300, 1),
        EqualToFirst("gyro_misalignment imu1"),
    ),
    Regression(
        "a scale that is one for all axes, but for little", Blind(443282294, 300, 96), EqualToFirst("gyro_scale imu1")
    ),
    # What stands first, and what is in doubt
    Regression("lost samples that were play and a coupling", Blind(73668495, 300, 190), First("dropouts imu2")),
    Regression("springs that may bend, the first", Blind(4896999, 300, 71), Doubted("soft_mount")),
    Regression("springs that may bend, the second", Blind(4896999, 300, 133), Doubted("soft_mount")),
    Regression("springs that may bend, the third", Blind(4896999, 300, 179), Doubted("soft_mount")),
    Regression("a slip beside what wanders", Blind(25387302, 300, 280), Doubted()),
    Regression("names worth less than what is left", Blind(20261125, 300, 34), SomethingUnnamed(), Doubted()),
    Regression("springs of rounding", Blind(4896999, 300, 288), Sure("quantisation"), Doubted("soft_mount")),
    # Recordings without a blind case
    # The rates say 1.8 ms for none: in the model from the start, it must not stay for the determinant alone.
    Regression(
        "clocks that seemed late before the fit",
        Made("free", (), 20261140, options=DRAWN),
        NothingBut("gyro_noise", "accel_noise"),
    ),
    # A spline rounds the jump, and rang about it by 0.13 of the friction: a torque that goes with the rate.
    Regression(
        "dry friction that jumps where a swing turns round",
        Made("hinge", ("dry_friction joint",), 17, options={"base": "fixed", "swing": True}),
        Number("dry_friction joint", "t", true=0.09126, closest=0.002),
    ),
    Regression(
        "a clean pendulum in which a filter once had no delay",
        Made("pendulum", (), 55802505, options=DRAWN_OF_A_PENDULUM),
        NothingBut(),
    ),
    # A pivot that moves as it likes explains of a lone IMU all that both do.
    Regression(
        "a filter and a scale that a moving pivot explains as well",
        Made(
            "pendulum",
            (
                ("low_pass", "imu1", {"cutoff": 16.0, "channels": ["gyro"]}),
                ("accel_scale", "imu1", {"scale": [-0.01, 0.0, 0.015]}),
            ),
            5,
            seconds=8.0,
            options={"band": 3.0},
        ),
        Exactly("low_pass imu1", "accel_scale imu1"),
    ),
)
"""All of them; names are unique."""
