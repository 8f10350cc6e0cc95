"""Unit and meaning of every column of both tables: in the Parquet files, README.md and croissant.json alike."""

import re
from dataclasses import dataclass

import pyarrow as pa

M, RAD, RATE, FORCE, TURN = "m", "rad", "rad/s", "m/s^2", "rad/s^2"


@dataclass(frozen=True)
class Told:
    """What is told of a column."""

    unit: str  # SI and radians; empty: a number without one, or text
    meaning: str


def _channel(kind: str, unit: str, what: str) -> dict[str, Told]:
    """Return the columns of an IMU's gyroscope or accelerometer in the table of recordings."""
    return {
        f"imuN_{kind}_rms": Told(unit, f"RMS of the {what} as read"),
        f"imuN_{kind}_noise_std": Told(unit, f"noise of the {what} per sample, as declared"),
        f"imuN_{kind}_range": Told(unit, f"largest {what} it can read, as declared"),
        f"imuN_{kind}_bias": Told(unit, f"bias of the {what}, sensor axes; effects included"),
        f"imuN_{kind}_scale": Told("1", f"scale error s of the {what}: it reads (1 + s) times; effects included"),
        f"imuN_{kind}_misalignment": Told("1", f"misalignment of the {what}: xy, xz, yx, yz, zx, zy; effects included"),
    }


TOLD: dict[str, Told] = {
    "recording": Told("", "number of the recording"),
    "split": Told("", "split of the recording; all recordings of a rig are in one"),
    "time": Told("s", "time of the row, k / rate from 0"),
    "imuN_time": Told("s", "the IMU's own stamp; empty where it has no sample"),
    "imuN_gyr": Told(RATE, "angular rate as read, sensor axes"),
    "imuN_acc": Told(FORCE, "specific force as read, sensor axes"),
    "encoder_angle": Told(RAD, "hinge angle as the encoder reads it"),
    "segmentN_measured_position": Told(M, "measured position of the segment frame, world"),
    "segmentN_measured_quaternion": Told("", "measured orientation, segment -> world; w, x, y, z"),
    "hinge_angle": Told(RAD, "true hinge angle: of segment 2 relative to segment 1 about +y"),
    "hinge_rate": Told(RATE, "true rate of the hinge angle"),
    "segmentN_position": Told(M, "true position of the segment frame, world; segment 2 shares it"),
    "segmentN_quaternion": Told("", "true orientation, segment -> world; w, x, y, z"),
    "segmentN_velocity": Told("m/s", "true velocity of the segment frame's origin, world"),
    "segmentN_rate": Told(RATE, "true angular rate, segment axes"),
    "segmentN_acceleration": Told(FORCE, "true acceleration of the segment frame's origin, world"),
    "segmentN_angular_acceleration": Told(TURN, "true angular acceleration, segment axes"),
    "imuN_true_position": Told(M, "true position of the sensor, world"),
    "imuN_true_quaternion": Told("", "true orientation, sensor -> world; w, x, y, z"),
    "imuN_true_acceleration": Told(FORCE, "true acceleration of the sensor, world"),
    "imuN_true_gyro": Told(RATE, "what a perfect gyroscope there reads, sensor axes"),
    "imuN_true_specific_force": Told(FORCE, "what a perfect accelerometer there reads, sensor axes"),
    "imuN_true_angular_acceleration": Told(TURN, "true angular acceleration, sensor axes"),
    "imuN_true_joint_vector": Told(M, "from the sensor to the joint centre, sensor axes"),
    "imuN_true_joint_axis": Told("1", "hinge axis, a unit vector in sensor axes"),
    "imuN_true_displacement": Told(M, "displacement of a sprung mount, segment axes"),
    "imuN_true_rotation": Told(RAD, "rotation vector of a sprung mount: q = q_mount exp(rotation)"),
    "name": Told("", "name of the recording"),
    "seed": Told("", "seed of the dataset"),
    "rig": Told("", "number of the rig; recordings of one rig have its number"),
    "family": Told("", "family of the rig: hinge, pendulum or free"),
    "base": Told("", "free, or fixed: segment 1 does not move"),
    "base_quaternion": Told("", "orientation of a fixed base, segment 1 -> world; w, x, y, z"),
    "motion": Told("", "kind of motion"),
    "free_swing": Told("s", "start and end of the free swing; empty of a motion by hand"),
    "body_mass": Told("kg", "declared mass of the swinging segment; empty of a motion by hand"),
    "body_com": Told(M, "declared centre of mass of the swinging segment"),
    "body_inertia": Told("kg m^2", "declared inertia of the swinging segment about its centre of mass"),
    "encoder_noise_std": Told(RAD, "noise of the encoder per sample, as declared; empty without one"),
    "encoder_zero": Told(RAD, "what is added to the encoder's reading"),
    "seconds": Told("s", "length of the recording"),
    "rate": Told("Hz", "rate of the IMUs and of the truth"),
    "samples": Told("", "rows in the table of samples"),
    "gravity": Told(FORCE, "gravity as declared"),
    "true_gravity": Told(FORCE, "gravity as simulated"),
    "effects": Told("", "what the declared model leaves out: effect, at, and parameters as JSON, SI units"),
    "segmentN_mass": Told("kg", "mass of the segment"),
    "segmentN_com": Told(M, "centre of mass, segment frame"),
    "segmentN_inertia": Told("kg m^2", "inertia about the centre of mass, segment axes"),
    "segmentN_length": Told(M, "how far the segment reaches from its origin"),
    "segmentN_measured_position_std": Told(M, "noise of the measured position; empty where it is not measured"),
    "segmentN_measured_rotation_std": Told(RAD, "noise of the measured orientation; empty where it is not measured"),
    "imuN_profile": Told("", "profile of the IMU"),
    "imuN_samples": Told("", "samples that the IMU has"),
    "imuN_position": Told(M, "true position of the sensor on its segment, springs unloaded"),
    "imuN_quaternion": Told("", "true orientation of the mount, sensor -> segment; w, x, y, z"),
    "imuN_declared_position": Told(M, "declared position of the sensor on its segment"),
    "imuN_declared_quaternion": Told("", "declared orientation of the mount, sensor -> segment; w, x, y, z"),
    "imuN_declared_position_std": Told(M, "how well the position is known"),
    "imuN_declared_rotation_std": Told(RAD, "how well the orientation is known"),
    **_channel("gyro", RATE, "angular rate"),
    **_channel("accel", FORCE, "specific force"),
}
"""By the column's name with N for the number of an IMU or segment, and without the component of a vector."""


def told(column: str) -> Told:
    """Return unit and meaning of a column of either table."""
    general = re.sub(r"^(imu|segment)\d+", r"\1N", column)
    return TOLD.get(general) or TOLD[re.sub(r"_[wxyz]$", "", general)]


def with_units(schema: pa.Schema) -> pa.Schema:
    """Return a schema whose fields carry `unit` and `description` as metadata, which Parquet keeps."""
    fields = []
    for field in schema:
        said = told(field.name)
        fields.append(field.with_metadata({"unit": said.unit, "description": said.meaning}))
    return pa.schema(fields)
