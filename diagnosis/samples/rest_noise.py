"""The noise of an IMU where nobody declares it: at rest, and never more than an IMU can have.

At rest a sensor reads its noise, a constant rate that is its bias, and gravity. The quietest moment of a moving hand,
or of foam in one, looks much the same to a threshold, so a rest is taken for one only if

- it lasts: a second or more at a time, and `QUIET_MOMENTS.rest_samples` samples; - it does not turn: a mean rate above
`QUIET_MOMENTS.most_bias_rad_s` is more than a bias; - both triples are as quiet as an IMU at rest may be,
`MOST_REST_STD`; - both are white: what moves a sensor (a hand sways at 1 to 4 Hz, trembles at 6 to 12, foam rings at 10
to 20) repeats itself within `QUIET_MOMENTS.correlation_lag_s` s, the noise of an IMU does not. A correlation of
0.37 is that of a motion with 37 % of the power, which makes the std 26 % too large: as much as a declared one, with
coloured noise on top, may be off anyhow.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.samples import QUIET_MOMENTS
from imubench.diagnosis.config.shared import DECLARED_NOISE
from imubench.diagnosis.samples.quiet_moments import quiet_level
from imubench.diagnosis.samples.sample_faults import UNIT_OF_PART
from imubench.diagnosis.windows import Windows
from imubench.recording import Imu, Recording

MOST_REST_STD = {"gyro": 0.03, "accel": 0.3}
"""rad/s and m/s^2 per sample that the noise of a body-worn MEMS IMU has at most.

Over a bandwidth of 250 Hz, wider than inertial motion capture has: 0.1 deg/s/sqrt(Hz), of the Xsens MTx (MT0100P rev N,
p. 17), the loudest gyroscope of the project's profiles, gives 0.028 rad/s; an accelerometer of 2 mg/sqrt(Hz) gives 0.31
m/s^2, seven times the 300 ug/sqrt(Hz) of the MPU-9250 (PS-MPU-9250A-01, table 2), four times its total of 8 mg RMS.
"""
LEAST_REST_STD = {"gyro": 2e-4, "accel": 1e-3}
"""The same units, that it has at least: at 40 Hz, a rate as low as motion capture has, without rounding.

Among the quietest MEMS parts are the gyroscope of the ICM-42688-P, 0.0028 deg/s/sqrt(Hz), 2.2e-4 rad/s over 20 Hz, and
the accelerometer ADXL355, 25 ug/sqrt(Hz), 1.1e-3 m/s^2 (both by their data sheets).
"""


def quiet_noise(imu: Imu, part: str) -> float:
    """Return the noise std that counts where none is declared: of the quietest moments, no more than an IMU can have.

    Coarse rounding may be louder than any noise, and stays.
    """
    return quiet_level(imu.time, getattr(imu, part), MOST_REST_STD[part])


def quietest(imus: Sequence[Imu]) -> dict[str, float]:
    """Return that of every triple of some IMUs, by group: imu1.gyro and so on."""
    return {f"{i.name}.{part}": quiet_noise(i, part) for i in imus for part in UNIT_OF_PART}


def least_noise(recording: Recording) -> dict[str, float]:
    """Return the noise std that every triple has at least, by group: an IMU's, or a tenth of its quietest moments'.

    The second is for recordings from a simulation, whose noise may be none.
    """
    return {
        name: min(LEAST_REST_STD[name.split(".")[1]], QUIET_MOMENTS.quieter_than_quietest * std)
        for name, std in quietest(recording.imus).items()
    }


def rest_noise(imu: Imu, windows: Windows, steps: Mapping[str, Array]) -> dict[str, float]:
    """Return the noise std of gyro and accel at rest; empty where the sensor is not known to have rested.

    Args:
        imu: the sensor.
        windows: s, in which it may have been at rest.
        steps: the steps (3,) that each triple's readings are multiples of, 0 for none.
    """
    spans = [(imu.time >= start) & (imu.time <= end) for start, end in windows]
    if sum(int(s.sum()) for s in spans) < QUIET_MOMENTS.rest_samples:
        return {}
    if np.linalg.norm(np.median(np.concatenate([imu.gyro[s] for s in spans]), axis=0)) > QUIET_MOMENTS.most_bias_rad_s:
        return {}
    out = {}
    for part in UNIT_OF_PART:
        left = [x - x.mean(axis=0) for x in (getattr(imu, part)[s] for s in spans)]
        power = float(np.concatenate(left).var())
        rounding = float(np.sqrt(np.mean(np.square(steps[part])) / 12))
        std = max(power**0.5, rounding)
        moving = power > rounding**2 and repeats(left, power, max(1, round(QUIET_MOMENTS.correlation_lag_s * imu.rate)))
        if not 0 < std <= max(MOST_REST_STD[part], rounding) or moving:
            return {}
        out[part] = std
    return out


def repeats(pieces: list[Array], power: float, lags: int) -> bool:
    """Return whether pieces (n, 3), each without its mean, correlate with themselves up to so many samples later."""
    most = 1 - 1 / DECLARED_NOISE.most_std**2  # of the power: so much makes a std no worse than a declared one
    for lag in range(1, lags + 1):
        products = [p[lag:] * p[:-lag] for p in pieces if len(p) > lag]
        if products and abs(float(np.concatenate(products).mean())) > most * power:
            return True
    return False


__all__ = ["MOST_REST_STD", "least_noise", "quiet_noise", "quietest", "rest_noise"]
