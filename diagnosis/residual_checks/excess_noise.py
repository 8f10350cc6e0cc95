"""Noise louder than declared that no effect and no term explains: white, so a noise; or of unknown origin."""

from collections.abc import Sequence

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.noise import COLOUR
from imubench.diagnosis.config.residuals import EXCESS_NOISE
from imubench.diagnosis.config.samples import NOISE_FLOOR
from imubench.diagnosis.config.shared import CONFIDENCE, DECLARED_NOISE, STATISTICS
from imubench.diagnosis.config.solve import SWING
from imubench.diagnosis.discrepancy.terms import channels_of
from imubench.diagnosis.noise.coloured import Spectra, noise_spectra
from imubench.diagnosis.noise.declared_noise import declared
from imubench.diagnosis.noise.noise_levels import levels
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.residuals import SWING_EQUATION, Rows, equation_of
from imubench.diagnosis.residual_checks.localize import shares
from imubench.diagnosis.result import UNKNOWN, Finding, Interval, Parameter, Where
from imubench.diagnosis.samples.check_findings import called
from imubench.diagnosis.samples.sample_faults import UNIT_OF_PART
from imubench.effects.traits import Fault


def excess_noise(fit: Fit, where: Sequence[Where], known: set[str]) -> list[Finding]:
    """Return white noise by its name, or the loudest place of what is not white; IMUs in `known` are explained."""
    told = declared(fit.model)
    imus, seen = {i.name for i in fit.model.recording.imus}, {r.name for r in fit.measured} & fit.noise.keys()
    told = {n: std for n, std in told.items() if n in seen and n.split(".")[0] not in known}
    if not told:
        return []
    found, leverage = levels(fit)
    if max(abs(np.log(found[n] / fit.noise[n])) for n in told) > EXCESS_NOISE.own_level:
        fit = with_noise(fit, 2)
        found, leverage = levels(fit)
    over = {
        n
        for n, std in told.items()
        if fit.model.averaging.power(n, (found[n] / std) ** 2) > DECLARED_NOISE.most_power
        and tells_its_level(leverage[n])
    }
    if not over:
        return []
    spectra = noise_spectra(fit)
    out = []
    for rows in fit.measured:
        name, at = rows.name, rows.name.split(".")[0]
        if (
            name not in over
            or at not in imus
            or not steady(fit, rows, leverage[name])
            or has_heavy_tails(rows, leverage[name])
        ):
            continue
        if flat(spectra[name], (found[name] / fit.noise[name]) ** 2):
            out.append(louder_noise(name, found[name], leverage[name]))
            over.remove(name)
    sensors = {n.split(".")[0] for n in over}
    chosen = next((w for w in where if w.at in sensors), None)
    if chosen is not None:
        out.append(unexplained(chosen))
    return out


def unexplained(where: Where) -> Finding:
    """Return what no term holds at a place as a finding without a name."""
    return Finding(UNKNOWN, where.at, CONFIDENCE.sure, {}, Interval(0.0, (0.0, 0.0)), where=where)


def off_its_equation(fit: Fit) -> list[Finding]:
    """Return what a free swing's equation leaves as a finding without a name at the joint, where that is a torque.

    A swing without any other torque keeps to its equation within a fraction of 1 % of the torque of the segment's
    weight; an unnamed torque, such as wind, exceeds that.
    """
    rows = equation_of(fit.rows)
    if rows is None or fit.noise.get(SWING_EQUATION, 0.0) < SWING.unheld:
        return []
    power = np.sum(rows.residual.value**2, axis=0)
    told = dict(zip(channels_of("torque", len(power)), power.tolist(), strict=True))
    where = Where("joint", shares(told), (), (), "a free swing", 1.0)
    return [unexplained(where)]


def tells_its_level(leverage: Array) -> bool:
    """Return whether the fit leaves enough of a sensor's noise for its level to say anything; leverage (n, 3)."""
    return float(np.mean(1 - leverage)) > EXCESS_NOISE.visible


def left_over(fit: Fit, allowed: float = DECLARED_NOISE.most_power) -> float:
    """Return the nat that noise costs at its declared levels beyond so many times their power."""
    told, numbers = declared(fit.model), {r.name: r.residual.value.size for r in fit.measured}
    most = {n: fit.model.averaging.power_in_fit(n, allowed) for n in told}
    power = {n: (fit.noise[n] / std) ** 2 / most[n] for n, std in told.items() if n in fit.noise and n in numbers}
    return sum(0.5 * numbers[n] * max(p - 1.0, 0.0) for n, p in power.items())


def flat(spectra: Spectra, whole: float = 1.0) -> bool:
    """Return whether noise of so much power is white as far as its bands tell; at least two have to."""
    told = spectra.seen > EXCESS_NOISE.visible
    off = np.abs(np.log(spectra.power[told] / whole))
    chance = STATISTICS.band_sigmas / np.sqrt(3 * np.diff(spectra.edges)[told])
    return len(off) > 1 and bool(np.all(off < np.log(EXCESS_NOISE.flat_power) + chance))


def steady(fit: Fit, rows: Rows, leverage: Array) -> bool:
    """Return whether an IMU's residuals are as large while it turns fast as while it does not."""
    imu = next(i for i in fit.model.recording.imus if i.name == rows.name.split(".")[0])
    speed = np.interp(rows.time + fit.model.start, imu.time, np.linalg.norm(imu.gyro, axis=1))
    bins = ((rows.time - rows.time[0]) / EXCESS_NOISE.window_s).astype(int)
    count = np.maximum(np.bincount(bins), 1)
    pace = np.sqrt(np.bincount(bins, speed**2) / count)[bins]
    quick = pace > np.median(pace)
    if not 0 < quick.sum() < quick.size:
        return False
    power = np.sum(rows.whitened**2, axis=1) / np.maximum(np.sum(1 - leverage, axis=1), 1e-3)
    ratio = float(np.mean(power[quick]) / np.mean(power[~quick]))
    return 1 / NOISE_FLOOR.steady_power < ratio < NOISE_FLOOR.steady_power


def has_heavy_tails(rows: Rows, leverage: Array) -> bool:
    """Return whether an IMU's residuals have a heavier tail than noise has, which is normal; leverage (n, 3).

    By their fourth moment: of six louder noises that is within 0.2 of the normal one's 3, once each residual is over
    what the fit leaves of its noise. Of an accelerometer at whose hinge the other one's springs ring now and then, 5.5.
    """
    z = rows.whitened / np.sqrt(np.maximum(1 - leverage, COLOUR.least_left))
    over = float(np.mean(z**4) / np.mean(z**2) ** 2) - 3
    return over > max(EXCESS_NOISE.tail, STATISTICS.rare_sigmas * np.sqrt(24 / z.size))


def louder_noise(name: str, std: float, leverage: Array) -> Finding:
    """Return a louder white noise of an IMU's triple as a finding; std and `leverage` (n, 3) as `levels` has them."""
    at, part = name.split(".")
    error = std / np.sqrt(2 * max(float(np.sum(1 - leverage)), 1.0))
    size = Parameter(np.array(std), np.array(error), UNIT_OF_PART[part])
    return Finding(called(Fault.NOISY, part), at, CONFIDENCE.sure, {"std": size}, Interval(0.0, (0.0, 0.0)))


__all__ = [
    "excess_noise",
    "flat",
    "left_over",
    "louder_noise",
    "off_its_equation",
    "steady",
    "unexplained",
]  # fmt: skip
