"""Each raw check's result as a finding of the contract's table, in words and numbers."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.samples import SCREENING
from imubench.diagnosis.config.shared import CONFIDENCE, DECLARED_NOISE, EVIDENCE, STATISTICS
from imubench.diagnosis.samples.impacts import Knocks
from imubench.diagnosis.samples.noise_floor import Level, Rest
from imubench.diagnosis.samples.sample_faults import UNIT_OF_PART, Lost, Mask, more_than_odd
from imubench.diagnosis.samples.tones import Line
from imubench.diagnosis.windows import Windows
from imubench.effects import EFFECTS
from imubench.effects.traits import Fault
from imubench.recording import Imu

Value = tuple[Array, Array, str]


@dataclass(frozen=True)
class RawFinding:
    """An effect that the raw samples show."""

    effect: str
    at: str
    parameters: Mapping[str, Value]  # name -> value, one standard deviation, unit
    confidence: float
    evidence: str
    settings: Mapping[str, str | tuple[str, ...]] = field(default_factory=dict)  # mode, channels
    windows: Windows = ()  # s, where it shows; empty: everywhere


def called(fault: Fault, part: str = "") -> str:
    """Return the name of the effect that does something to single samples, to those of "gyro" or "accel" alone."""
    return EFFECTS.name_of(lambda e: e.fault is fault and part in ("", e.channel))


def value(number: float | Array, std: float | Array, unit: str) -> Value:
    """Return a parameter as arrays of one shape."""
    x = np.asarray(number, dtype=float)
    return x, np.broadcast_to(np.asarray(std, dtype=float), x.shape).copy(), unit


def declared(imu: Imu, part: str) -> float | None:
    """Return the declared noise of "gyro" or "accel" per sample."""
    return imu.gyro_noise_std if part == "gyro" else imu.accel_noise_std


def saturation_finding(imu: Imu, part: str, at: Mask, limits: Array) -> RawFinding:
    """Return where the readings `at` (n,) end at `limits` (k,) of axes and sides."""
    limit, spread = float(np.median(limits)), float(np.ptp(limits))
    times = imu.time[at]
    said = f"{at.sum()} samples of {imu.name}'s {part} read {limit:.4g} {UNIT_OF_PART[part]} in size and none more"
    if spread > 1e-3 * limit:
        said += f"; the limits of its axes differ by up to {spread:.2g}"
    evidence = f"{said}, first at {times[0]:.2f} s."
    parameters = {"limit": value(limit, max(spread / 2, 1e-6 * limit), UNIT_OF_PART[part])}
    return RawFinding(called(Fault.CLIPPED), imu.name, parameters, 0.99, evidence, {"channels": (part,)}, joined(times))


def quantisation_finding(imu: Imu, part: str, steps: Array, noise: float | None) -> RawFinding | None:
    """Return that readings lie on steps (3,), if those are coarse against the noise std without them."""
    step = float(np.median(steps[steps > 0])) if steps.any() else 0.0
    known = declared(imu, part)
    share = (
        DECLARED_NOISE.colour if known else DECLARED_NOISE.colour / (1 + DECLARED_NOISE.colour)
    )  # what is measured holds the rounding's power
    other = known or noise
    if step == 0 or other is None or step**2 / 12 <= share * other**2:
        return None
    unit = UNIT_OF_PART[part]
    evidence = (
        f"Every reading of {imu.name}'s {part} is a multiple of {step:.4g} {unit}; "
        f"rounding to it adds {step / np.sqrt(12):.2g} {unit} to a noise of {other:.2g}."
    )
    error = max(float(np.ptp(steps[steps > 0])), 1e-6 * step)
    parameters = {"step": value(step, error, unit)}
    return RawFinding(called(Fault.ROUNDED), imu.name, parameters, 0.99, evidence, {"channels": (part,)})


def dropouts_finding(imu: Imu, lost: Lost) -> list[RawFinding]:
    """Return lost samples, held and missing, where they are more than the odd one."""
    out = []
    n = imu.time.size
    cases = (
        ("held", lost.fraction_held, lost.events_held, lost.pairs, imu.time[lost.held], "say the one before again"),
        ("missing", lost.fraction_missing, lost.events_missing, n, lost.after, "are missing between the stamps"),
    )
    for mode, fraction, events, count, times, said in cases:
        if count and more_than_odd(events, count):
            error = float(np.sqrt(max(fraction * (1 - fraction), 1 / n) / count))
            evidence = f"{100 * fraction:.1f} % of {imu.name}'s samples {said}, {events} times."
            parameters = {"fraction": value(fraction, error, "1")}
            out.append(
                RawFinding(called(Fault.LOST), imu.name, parameters, 0.99, evidence, {"mode": mode}, joined(times))
            )
    return out


def confidence_of_knocks(times: Array) -> float:
    """Return how sure knocks at some times (k,) are: a single one may be something else that happens once."""
    return CONFIDENCE.repeated if times.size >= EVIDENCE.events else CONFIDENCE.doubtful


def impacts_finding(imu: Imu, knocked: Knocks) -> RawFinding:
    """Return the knocks."""
    times, period = knocked.times, float(np.median(np.diff(imu.time)))
    few = ", ".join(f"{t:.2f}" for t in times[: SCREENING.listed_times]) + (
        " ..." if times.size > SCREENING.listed_times else ""
    )
    evidence = (
        f"Above 15 Hz {imu.name}'s accelerometer is {knocked.ratio.min():.0f} to {knocked.ratio.max():.0f} times its "
        f"level just before and after, for tens of milliseconds, at {few} s."
    )
    confidence = confidence_of_knocks(times)
    parameters = {"times": value(times, period, "s")}
    windows = joined(imu.time[knocked.samples])
    return RawFinding(called(Fault.STRUCK), imu.name, parameters, confidence, evidence, windows=windows)


def noise_finding(imu: Imu, part: str, level: Level | None, rest: float | None, step: float) -> RawFinding | None:
    """Return that white noise exceeds the declared, with that of a rounding `step` (0: none) taken into account.

    Where the sensor rests it must be as noisy there: `rest`, its std then.
    """
    known = declared(imu, part)
    if not known or level is None or not level.white:
        return None
    expected = float(np.hypot(known, step / np.sqrt(12)))
    if min(level.std - STATISTICS.clear_sigmas * level.error, rest or level.std) <= DECLARED_NOISE.most_std * expected:
        return None
    std = float(np.sqrt(level.std**2 - step**2 / 12))
    unit = UNIT_OF_PART[part]
    evidence = (
        f"White noise of {std:.3g} {unit} per sample from 12 Hz up in {imu.name}'s {part}, "
        f"{std / known:.1f} times the declared {known:.3g}."
    )
    return RawFinding(called(Fault.NOISY, part), imu.name, {"std": value(std, level.error, unit)}, 0.95, evidence)


def hum_finding(imu: Imu, found: Line, rate: float) -> RawFinding:
    """Return a hum; its true frequency may be any image of the one seen."""
    evidence = (
        f"A line at {found.frequency:.2f} Hz (or its images {rate - found.frequency:.1f}, {rate + found.frequency:.1f} "
        f"Hz, ...) in {imu.name}'s accelerometer has {found.ratio:.0f} times its neighbourhood's power."
    )
    parameters = {
        "frequency": value(found.frequency, found.error, "Hz"),
        "amplitude": value(found.amplitude, found.amplitude_error, "m/s^2"),
    }
    return RawFinding(EFFECTS.name_of(lambda e: e.tone), imu.name, parameters, 0.9, evidence, windows=found.windows)


def joined(times: Array, within: float = 0.5, fewest: int = 1) -> Windows:
    """Return the spans that times (k,) cover, those nearer than `within` s as one, without spans of few times."""
    if not times.size:
        return ()
    groups = np.split(times, np.flatnonzero(np.diff(times) > within) + 1)
    return tuple((float(g[0]), float(g[-1])) for g in groups if g.size >= fewest)


def noise_now(rest: Rest, level: Level | None, part: str) -> float | None:
    """Return a triple's noise std per sample: at rest, else of white noise above 12 Hz."""
    return rest.std.get(part, level.std if level else None)
