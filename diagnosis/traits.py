"""Names of effects that several rooms treat apart."""

FILTER = "low_pass"  # the effect that others are held against: a delay, a series, a reading that follows too slowly
CLOCK = "time_offset"  # the delay
CLOCKS = ("time_offset", "clock_skew")
SLIP = "mount_shift"
POSE = "mount_pose"
MOVED = (SLIP, "mount_pose")
HUM = "vibration"
STOP = "end_stop"
KNOCKING = ("end_stop", "joint_play")  # what knocks by itself
FRICTION = ("viscous_friction", "dry_friction", "air_drag")
DRIFTS = ("gyro_drift", "accel_drift")
SLOW = (*DRIFTS, "gyro_bias", "accel_bias")

__all__ = [
    "CLOCK",
    "CLOCKS",
    "DRIFTS",
    "FILTER",
    "FRICTION",
    "HUM",
    "KNOCKING",
    "MOVED",
    "POSE",
    "SLIP",
    "SLOW",
    "STOP",
]
