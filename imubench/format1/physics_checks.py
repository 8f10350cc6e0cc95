"""Could an instrument in a laboratory have read this, if the units are those of the format?

Each check looks for what physics or every sensor on the market rules out, so that fast, long and restless motion
passes; what is merely unusual is not our business. A message says which unit was probably used.
"""

from collections.abc import Mapping

import numpy as np

from imubench.arrays import Array
from imubench.errors import InputError
from imubench.format1.track_checks import FASTEST_TURN, check_lever
from imubench.inputs.tables import Place
from imubench.recording import STANDARD_GRAVITY, Imu

LARGEST_GYRO_RANGE = 100.0  # rad/s, declared
LARGEST_ACCEL_RANGE = 5000.0  # m/s^2, declared: shock sensors end at 400 g
LARGEST_MEDIAN_ACCEL = 400.0  # m/s^2, sustained: 40 g
SLOWEST_RATE, FASTEST_RATE = 0.2, 5e4  # Hz: the fastest IMUs give 32 kHz, and nothing moves once in 5 s
LATEST = 9e9  # s, 285 years: clocks count from 1970 or later, and 64 bits hold so many nanoseconds
LONGEST = 31 * 86400.0  # s between the first and the last sample; a clock that was set on the way makes years of them
USUAL_RATE = 100.0  # Hz
BEYOND_RANGE = 1.5  # noise and range tolerance stay far below
DEGREE = np.pi / 180


def check_imu(imu: Imu, gravity: float, place: Place, where: str) -> None:
    """Raise `InputError` for stamps, rates or specific forces of another unit; `where` names the declaration."""
    _check_declared(imu, gravity, where)
    _check_rate(imu, place)
    _check_stamps(imu, place)
    _check_sampling(imu, place, where)
    _check_accel(imu, gravity, place)
    _check_gyro(imu, gravity, place)


def _check_declared(imu: Imu, gravity: float, where: str) -> None:
    if imu.gyro_range is not None and imu.gyro_range > LARGEST_GYRO_RANGE:
        raise InputError(
            f"{where}, key 'gyro_range': expected rad/s, under {LARGEST_GYRO_RANGE:g}, got {imu.gyro_range:g}: "
            f"probably deg/s"
        )
    if imu.accel_range is not None and not gravity <= imu.accel_range <= LARGEST_ACCEL_RANGE:
        raise InputError(
            f"{where}, key 'accel_range': expected m/s^2, from gravity ({gravity:g}) to {LARGEST_ACCEL_RANGE:g}, "
            f"got {imu.accel_range:g}: probably {'g' if imu.accel_range < gravity else 'mg or counts'}"
        )
    check_lever(imu.mount_position, f"{where}, key 'mount_position'")


def usual_factor(step: float, factors: Mapping[str, float]) -> str:
    """Return the unit in which a median step would be an IMU's, the one nearest to 100 Hz; empty if none.

    `factors` holds the seconds that each unit has.
    """
    rates = {name: 1.0 / (step * factor) for name, factor in factors.items()}
    likely = [name for name, rate in rates.items() if SLOWEST_RATE <= rate <= FASTEST_RATE]
    return min(likely, key=lambda name: abs(np.log(rates[name] / USUAL_RATE)), default="")


def _check_stamps(imu: Imu, place: Place) -> None:
    """Look for stamps that no clock in seconds gives, and for a clock that was set while it recorded."""
    late = np.abs(imu.time) > LATEST
    if late.any():
        row = int(late.argmax())
        size = abs(float(imu.time[row]))
        units = {"milliseconds": 1e3, "microseconds": 1e6, "nanoseconds": 1e9}
        likely = next((f": probably {name} since 1970" for name, f in units.items() if 1e9 <= size / f <= 5e9), "")
        raise InputError(f"{place(row)}, column 'time': expected s, up to {LATEST:g}, got {imu.time[row]:.12g}{likely}")
    if imu.time[-1] - imu.time[0] > LONGEST:
        row = int(np.diff(imu.time).argmax()) + 1
        days = np.array([LONGEST, imu.time[-1] - imu.time[0], imu.time[row] - imu.time[row - 1]]) / 86400
        raise InputError(
            f"{place(row)}, column 'time': expected at most {days[0]:g} days from the first sample to the last, got "
            f"{days[1]:.4g}, of them {days[2]:.4g} before this row: was the clock set?"
        )


def _check_sampling(imu: Imu, place: Place, where: str) -> None:
    """Look for a rate that no IMU has; by now stamps, where there are three, agree with what is declared."""
    if SLOWEST_RATE <= imu.rate <= FASTEST_RATE:
        return
    expected = f"an IMU's {SLOWEST_RATE:g} to {FASTEST_RATE:g} Hz"
    if imu.time.size < 3:
        raise InputError(f"{where}, key 'rate': expected {expected}, got {imu.rate:g} Hz")
    step = float(np.median(np.diff(imu.time)))
    unit = usual_factor(step, {"milliseconds": 1e-3, "microseconds": 1e-6, "nanoseconds": 1e-9, "minutes": 60.0})
    likely = f": the stamps are probably {unit}" if unit else ""
    raise InputError(
        f"{place(1)}, column 'time': expected steps of {expected}, got {step:g} s (median) and, in {where}, "
        f"rate = {imu.rate:g}{likely}"
    )


def _check_rate(imu: Imu, place: Place) -> None:
    """Compare the median step with the declared rate; gaps, jitter and lost samples stay within a factor of 5."""
    if imu.time.size < 3:
        return
    step = float(np.median(np.diff(imu.time)))
    ratio = step * imu.rate
    if 1 / 5 < ratio < 5:
        return
    units = {"milliseconds": 1e3, "microseconds": 1e6, "nanoseconds": 1e9, "minutes": 1 / 60}
    likely = next((f": probably {name}" for name, factor in units.items() if 0.3 < ratio / factor < 3), "")
    raise InputError(
        f"{place(1)}, column 'time': expected steps of about {1 / imu.rate:g} s by the declared rate of "
        f"{imu.rate:g} Hz, got {step:g} s (median){likely}"
    )


def _check_accel(imu: Imu, gravity: float, place: Place) -> None:
    force = np.linalg.norm(imu.accel, axis=1)
    usual = float(np.median(force))
    if imu.accel_range is not None:
        _check_range(imu.accel, imu.accel_range, place, "acc", "m/s^2", _accel_unit(usual, gravity))
    rest, starts = _rest(imu)
    at_rest = float(np.median(rest)) if rest.size else np.nan
    if gravity > 1 and rest.size and not gravity / 2 < at_rest < 2 * gravity:
        raise InputError(
            f"{place(starts[0])}: expected |acc| of about {gravity:g} m/s^2 at rest, got {at_rest:.4g}: "
            f"probably {_accel_unit(at_rest, gravity)}"
        )
    if usual > LARGEST_MEDIAN_ACCEL:
        raise InputError(
            f"{place(0)}: expected |acc| in m/s^2, got a median of {usual:.4g}: probably {_accel_unit(usual, gravity)}"
        )
    lasts, mean = float(imu.time[-1] - imu.time[0]), float(np.mean(force))
    if lasts > 5 and mean < gravity / 2:  # else it fell for 5 s at over g / 2
        raise InputError(
            f"{place(0)}: expected |acc| in m/s^2, got a mean of {mean:.4g} over {lasts:.3g} s, which gravity "
            f"rules out: probably {_accel_unit(mean, gravity)}"
        )


def _accel_unit(at_rest: float, gravity: float) -> str:
    """Return the unit in which gravity reads `at_rest`."""
    units = {"g": 1.0, "ft/s^2": STANDARD_GRAVITY / 0.3048, "mg or cm/s^2": 1000.0}
    for unit, reading in units.items():
        if 0.8 < at_rest / reading < 1.25:
            return unit
    return "gravity was taken out" if at_rest < 0.5 else "g" if at_rest < gravity else "raw counts"


def _rest(imu: Imu) -> tuple[Array, list[int]]:
    """Return the mean |acc| (k,) of every second in which nothing moves, and the rows (k,) where these start.

    Rest: the accelerometer varies by under 5 % of what it reads (in any unit), the gyroscope by under 0.1 rad/s
    about a mean (its bias) under 0.5 rad/s.
    """
    if imu.time.size < 10 or imu.time[-1] - imu.time[0] < 0.5:
        return np.zeros(0), []
    size = int(np.clip(round(1 / float(np.median(np.diff(imu.time)))), 5, imu.time.size))
    accel, gyro = _blocks(imu.accel, size), _blocks(imu.gyro, size)
    mean = np.linalg.norm(accel.mean(axis=1), axis=-1)
    still = (
        (np.linalg.norm(accel.std(axis=1), axis=-1) <= 0.05 * mean)
        & (np.linalg.norm(gyro.std(axis=1), axis=-1) < 0.1)
        & (np.linalg.norm(gyro.mean(axis=1), axis=-1) < 0.5)
    )
    return mean[still], [size * int(block) for block in np.flatnonzero(still)]


def _check_gyro(imu: Imu, gravity: float, place: Place) -> None:
    if imu.gyro_range is not None:
        likely = _gyro_unit(imu.gyro, BEYOND_RANGE * imu.gyro_range)
        _check_range(imu.gyro, imu.gyro_range, place, "gyr", "rad/s", likely)
    limit = max(FASTEST_TURN, imu.gyro_range or 0.0)
    fast = (np.abs(imu.gyro) > limit).any(axis=1)
    if fast.sum() >= 5 and fast.mean() >= 0.01:
        raise InputError(
            f"{place(int(fast.argmax()))}: expected |gyr| under {limit:g} rad/s, the limit of such sensors, "
            f"got {fast.mean():.0%} of the samples beyond: probably {_gyro_unit(imu.gyro, limit)}"
        )
    slope, correlation, count = turning_ratio(imu, gravity)
    if count >= 10 and correlation > 0.9 and 0.8 < slope / DEGREE < 1.25:
        raise InputError(
            f"{place(0)}: expected gyr in rad/s, got rates {1 / slope:.3g} times as fast as gravity turns in acc: "
            f"probably deg/s"
        )


def _gyro_unit(gyro: Array, limit: float) -> str:
    """Return the unit that brings the readings below `limit` in rad/s."""
    return "deg/s" if float(np.abs(gyro).max()) * DEGREE <= limit else "raw counts"


def turning_ratio(imu: Imu, gravity: float) -> tuple[float, float, int]:
    """Return how far gravity really turned in sensor axes over how far the gyroscope says, from calm half seconds.

    Calm: |acc| within 10 % of gravity, though the gyroscope claims that gravity turned by over 1 rad. A free swing
    or a turntable cannot pass for calm by this. Returns the slope (1 when the units agree), its correlation and
    the number of half seconds.
    """
    nothing = (np.nan, 0.0, 0)
    if imu.time.size < 20 or gravity < 1:
        return nothing
    size = max(1, round(0.1 / float(np.median(np.diff(imu.time)))))
    per_span = 5
    if imu.time.size < size * (per_span + 1):
        return nothing
    time, accel, gyro = (_blocks(x, size).mean(axis=1) for x in (imu.time[:, None], imu.accel, imu.gyro))
    force = np.linalg.norm(accel, axis=1)
    up = accel / np.maximum(force, 1e-9)[:, None]
    step = np.diff(time, axis=0)
    claimed = np.cross((up[1:] + up[:-1]) / 2, (gyro[1:] + gyro[:-1]) / 2) * step  # d(up)/dt = up x rate
    spans = len(claimed) // per_span
    claimed = _blocks(claimed, per_span).sum(axis=1)
    turned = np.diff(up[: spans * per_span + 1 : per_span], axis=0)
    off = np.abs(force / gravity - 1) > 0.1
    calm = ~(_blocks((off[1:] | off[:-1])[:, None], per_span).any(axis=(1, 2)))
    calm &= _blocks(step, per_span).max(axis=(1, 2)) < 2 * np.median(step)
    calm &= np.linalg.norm(claimed, axis=1) > 1
    if not calm.any():
        return nothing
    p, q = claimed[calm], turned[calm]
    pq, pp, qq = float((p * q).sum()), float((p * p).sum()), float((q * q).sum())
    return pq / pp, pq / np.sqrt(pp * max(qq, 1e-30)), int(calm.sum())


def _blocks(values: Array, size: int) -> Array:
    """Return values (n, k) as whole blocks (n // size, size, k)."""
    count = len(values) // size
    return values[: count * size].reshape(count, size, -1)


def _check_range(values: Array, limit: float, place: Place, prefix: str, unit: str, likely: str) -> None:
    beyond = np.abs(values) > BEYOND_RANGE * limit
    if beyond.any():
        row, axis = (int(k) for k in np.argwhere(beyond)[0])
        raise InputError(
            f"{place(row)}, column '{prefix}_{'xyz'[axis]}': expected at most {BEYOND_RANGE:g} times the declared "
            f"range of {limit:g} {unit}, got {values[row, axis]:.6g}: probably {likely}"
        )
