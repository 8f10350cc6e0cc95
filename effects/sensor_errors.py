"""Errors that act on a true signal sample by sample: y = x + M x + s.x + A f + b, in sensor axes.

All but the drifts are the sensor's own: its next recording has them too, but for what temperature and switching it on
change. Limits of data sheets are taken as three standard deviations, temperatures as 10 K apart:

    gyro_bias         +-0.5 deg/s from one turn-on to the next within a year (Xsens, base.xsens.com, "Bias repeatability
                      of gyroscopes")
    accel_bias        +-1.5 mg per K (MPU-9250, PS-MPU-9250A-01 rev 1.0, table 2)
    gyro_scale        +-4 % over -40 to 85 degC, 65 K from the 25 of its calibration (the same, table 1)
    accel_scale       +-0.026 % per K (the same, table 2)
    misalignments     no data sheet states a change; taken as a tenth of the tolerance, +-2 % (the same, tables 1 and 2)
    g_sensitivity     likewise; a tenth of the 0.1 deg/s per g of the MPU-6050 (PS-MPU-6000A-00 rev 3.4, section 6.1)
"""

import numpy as np

from imubench.effects.effect import Change, Effect, Error, Parameter, Reading, Values
from imubench.effects.traits import Alike
from imubench.jets import Jet, stack

NEXT_GYRO_BIAS, NEXT_ACCEL_BIAS = Change(2.9e-3), Change(0.049)  # rad/s, m/s^2
NEXT_GYRO_SCALE, NEXT_ACCEL_SCALE, NEXT_MISALIGNMENT = Change(2.1e-3), Change(8.7e-4), Change(6.7e-4)  # 1
NEXT_G_SENSITIVITY = Change(1.8e-5)  # rad/s per m/s^2


class GyroBias(Effect):
    """A constant offset of the gyroscope."""

    name, place, law = "gyro_bias", "imu", "y = x + bias"
    phrase = "a constant offset of {imu}'s gyroscope"
    channel = "gyro"
    time_power, additive, in_every_sensor = 0, True, True
    parameters = (Parameter("bias", (3,), "rad/s", 0.05),)
    of_the_sensor = NEXT_GYRO_BIAS

    def error(self, reading: Reading, p: Values) -> Error:
        return Error(gyro=p["bias"])


class AccelBias(Effect):
    """A constant offset of the accelerometer."""

    name, place, law = "accel_bias", "imu", "y = x + bias"
    phrase = "a constant offset of {imu}'s accelerometer"
    channel = "accel"
    time_power, additive = 0, True
    parameters = (Parameter("bias", (3,), "m/s^2", 0.5),)
    of_the_sensor = NEXT_ACCEL_BIAS

    def error(self, reading: Reading, p: Values) -> Error:
        return Error(accel=p["bias"])


class GyroDrift(Effect):
    """An offset of the gyroscope that grows from zero at the start."""

    name, place, law = "gyro_drift", "imu", "y = x + rate t"
    phrase = "an offset of {imu}'s gyroscope that grows with time"
    channel = "gyro"
    time_power, additive = 1, True
    parameters = (Parameter("rate", (3,), "rad/s^2", 0.002),)

    def error(self, reading: Reading, p: Values) -> Error:
        return Error(gyro=p["rate"] * reading.time)


class AccelDrift(Effect):
    """An offset of the accelerometer that grows from zero at the start."""

    name, place, law = "accel_drift", "imu", "y = x + rate t"
    phrase = "an offset of {imu}'s accelerometer that grows with time"
    channel = "accel"
    time_power, additive = 1, True
    parameters = (Parameter("rate", (3,), "m/s^3", 0.02),)

    def error(self, reading: Reading, p: Values) -> Error:
        return Error(accel=p["rate"] * reading.time)


class GyroScale(Effect):
    """Each axis of the gyroscope reads too much or too little."""

    name, place, law = "gyro_scale", "imu", "y_i = (1 + scale_i) x_i"
    phrase = "a scale error of {imu}'s gyroscope"
    channel = "gyro"
    additive = True
    parameters = (Parameter("scale", (3,), "1", 0.05),)
    of_the_sensor = NEXT_GYRO_SCALE

    def error(self, reading: Reading, p: Values) -> Error:
        return Error(gyro=p["scale"] * reading.gyro)


class AccelScale(Effect):
    """Each axis of the accelerometer reads too much or too little."""

    name, place, law = "accel_scale", "imu", "y_i = (1 + scale_i) x_i"
    phrase = "a scale error of {imu}'s accelerometer"
    channel = "accel"
    additive = True
    alike = (
        Alike(
            "gravity",
            "a scale that all accelerometers share is another unit of force",
            "gravity, where all accelerometers share it, but in free swings",
            other_at="world",
            in_swings=False,
            shared=True,
        ),
    )
    parameters = (Parameter("scale", (3,), "1", 0.05),)
    of_the_sensor = NEXT_ACCEL_SCALE

    def error(self, reading: Reading, p: Values) -> Error:
        return Error(accel=p["scale"] * reading.accel)


def off_diagonal(matrix: Jet, x: Jet) -> Jet:
    """Return M x for the entries xy, xz, yx, yz, zx, zy (n, 6) of a matrix without a diagonal."""
    a, b = x[[1, 0, 0]], x[[2, 2, 1]]
    return matrix[[0, 2, 4]] * a + matrix[[1, 3, 5]] * b


class GyroMisalignment(Effect):
    """The gyroscope's axes are not square to each other, or not where they should be."""

    name, place, law = "gyro_misalignment", "imu", "y = (I + M) x, M without diagonal"
    phrase = "gyroscope axes of {imu} that are not square"
    channel = "gyro"
    additive = crosses_axes = True
    parameters = (Parameter("matrix", (6,), "1", 0.05),)
    of_the_sensor = NEXT_MISALIGNMENT

    def error(self, reading: Reading, p: Values) -> Error:
        return Error(gyro=off_diagonal(p["matrix"], reading.gyro))


class AccelMisalignment(Effect):
    """The accelerometer's axes are not square to each other, or not where they should be."""

    name, place, law = "accel_misalignment", "imu", "y = (I + M) x, M without diagonal"
    phrase = "accelerometer axes of {imu} that are not square"
    channel = "accel"
    additive = crosses_axes = True
    parameters = (Parameter("matrix", (6,), "1", 0.05),)
    of_the_sensor = NEXT_MISALIGNMENT

    def error(self, reading: Reading, p: Values) -> Error:
        return Error(accel=off_diagonal(p["matrix"], reading.accel))


class GSensitivity(Effect):
    """The gyroscope feels acceleration."""

    name, place, law = "g_sensitivity", "imu", "gyro reads x + A f"
    phrase = "a gyroscope in {imu} that feels acceleration"
    additive = True
    parameters = (Parameter("matrix", (3, 3), "rad/s per m/s^2", 0.003),)
    of_the_sensor = NEXT_G_SENSITIVITY

    def error(self, reading: Reading, p: Values) -> Error:
        rows = [p["matrix"][[3 * i, 3 * i + 1, 3 * i + 2]] for i in range(3)]
        return Error(gyro=stack(*((row * reading.accel).at(np.ones((1, 3))) for row in rows)))


EFFECTS: tuple[Effect, ...] = (
    GyroBias(), AccelBias(), GyroDrift(), AccelDrift(), GyroScale(), AccelScale(),
    GyroMisalignment(), AccelMisalignment(), GSensitivity(),
)  # fmt: skip
