"""What a diagnosis says, as it stands in diagnosis.json: checked when it is made, and frozen from then on."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal, get_args

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.shared import CONFIDENCE
from imubench.diagnosis.directions import Directions
from imubench.diagnosis.result_checks import PLACES as PLACES
from imubench.diagnosis.result_checks import Pair as Pair
from imubench.diagnosis.result_checks import finite as finite
from imubench.diagnosis.result_checks import place, span, within
from imubench.diagnosis.result_simulation import SimulatedChannel as SimulatedChannel
from imubench.diagnosis.result_simulation import Simulation as Simulation
from imubench.displays import Displayed
from imubench.errors import InputError, unknown

Verdict = Literal["no mismatch", "explained", "partly explained", "unexplained", "unobservable"]
VERDICTS: tuple[str, ...] = get_args(Verdict)
UNKNOWN = "unknown"  # the effect that stands for what the library does not explain
CHANNEL_UNIT = "RMS error over noise std"
CORRELATION_ROUNDING = 1e-6  # of a correlation, that rounding may change
SOURCES = ("declared", "profile", "rest", "unknown")
NOT_KNOWN = "unknown"  # the source of a noise that nobody declares and no rest shows

TOLERANCE: Pair = (0.5, 5.0)
"""deg and mm, from which on what a finding moves is material: about what a reference can tell.

Markers that are known to 0.5 mm turn a cluster of 60 mm by 0.5 deg; a sensor is placed by hand to some 5 mm.
"""


@dataclass(frozen=True)
class Where:
    """Where residuals exceed the noise: one sensor, and its share of the recording's excess power."""

    at: str  # imu1, imu2, encoder, pose1
    channels: Mapping[str, float]  # acc_x -> share of the recording's excess, largest first
    bands_hz: tuple[Pair, ...]  # that hold most of it
    windows_s: tuple[Pair, ...]  # that hold most of it, on the sensor's clock
    depends_on: str  # what its local power goes with, in words
    share: float  # of the recording's excess

    def __post_init__(self) -> None:
        place(self.at, "where.at")
        for name, share in (*self.channels.items(), ("share", self.share)):
            within(share, 0.0, 1.0 + 1e-9, f"where.{name}")
        for key in ("bands_hz", "windows_s"):
            object.__setattr__(self, key, tuple(span(p, f"where.{key}") for p in getattr(self, key)))


@dataclass(frozen=True)
class Interval:
    """A number with its 95 % interval."""

    value: float
    ci: Pair
    unit: str = "nat"

    def __post_init__(self) -> None:
        finite(self.value, "interval.value")
        object.__setattr__(self, "ci", span(self.ci, "interval.ci"))


@dataclass(frozen=True)
class Parameter:
    """An effect's parameter: its value and one standard deviation, of the shape that the effect gives it."""

    value: Array
    std: Array
    unit: str
    fixed: Directions | None = field(default=None, compare=False)  # which directions of it the recording fixes

    def __post_init__(self) -> None:
        for key in ("value", "std"):
            array = np.array(getattr(self, key), dtype=float)
            if not np.isfinite(array).all():
                raise InputError(f"parameter.{key}: expected finite numbers, got {array.tolist()}")
            array.flags.writeable = False
            object.__setattr__(self, key, array)
        if self.value.shape != self.std.shape:
            raise InputError(f"parameter.std: expected shape {self.value.shape}, got {self.std.shape}")
        if (self.std < 0).any():
            raise InputError(f"parameter.std: expected numbers >= 0, got {self.std.tolist()}")


@dataclass(frozen=True)
class Rejected:
    """An effect at a place, and what it gains on held-out data in nat: one not taken, or one that fits as well."""

    effect: str
    at: str
    heldout_gain: float

    def __post_init__(self) -> None:
        place(self.at, "rejected.at")
        finite(self.heldout_gain, "rejected.heldout_gain")


@dataclass(frozen=True)
class Move:
    """By how much a finding moves one thing that a user asks for: a number, or one for each IMU or segment."""

    value: Array  # () or (k,), >= 0
    unit: str  # "deg", "deg RMS", "mm"

    def __post_init__(self) -> None:
        array = np.array(self.value, dtype=float)
        if array.ndim > 1 or not array.size or not np.isfinite(array).all() or (array < 0).any():
            raise InputError(f"moves: expected a finite number >= 0, or a list of such, got {array.tolist()}")
        if self.unit.split(" ")[0] not in ("deg", "mm"):
            raise InputError(f"moves: expected a unit of deg or mm, got '{self.unit}'")
        array.flags.writeable = False
        object.__setattr__(self, "value", array)

    def beyond(self, tolerance: Pair) -> bool:
        """Return whether any of its numbers reaches the tolerance (deg, mm)."""
        return float(np.max(self.value)) >= tolerance[self.unit.startswith("mm")]


Moves = Mapping[str, Move]


def is_material(moves: Moves, tolerance: Pair) -> bool:
    """Return whether anything moves beyond the tolerance (deg, mm); nothing known counts as material."""
    return not moves or any(move.beyond(tolerance) for move in moves.values())


@dataclass(frozen=True)
class Noise:
    """The noise of one sensor's triple that counts as only noise, and how it is known."""

    std: float  # per sample
    unit: str
    source: str  # of SOURCES

    def __post_init__(self) -> None:
        within(self.std, 0.0, np.inf, "noise.std")
        if self.source not in SOURCES:
            raise unknown("noise.source", self.source, SOURCES)


@dataclass(frozen=True)
class Finding:
    """An effect that the fit needs, or `unknown` with where it sits."""

    effect: str
    at: str
    confidence: float  # probability that it, or one of `equivalent`, is really there
    parameters: Mapping[str, Parameter]
    heldout_gain: Interval
    equivalent: tuple[Rejected, ...] = ()  # what the recording cannot tell from it
    separate_by: str = ""  # the motion that could
    where: Where | None = None  # of an unknown
    moves: Moves = field(default_factory=dict)  # "joint_axis", "hinge_angle", ...; empty: not known
    material: bool = True  # False: all that it moves is below the tolerance
    share: float | None = None  # of what differs, that comes back without it in the final model; None: not known
    unseen: tuple[str, ...] = ()  # directions of its parameters that the recording does not fix, in words

    def __post_init__(self) -> None:
        place(self.at, "finding.at")
        within(self.confidence, 0.0, 1.0, "finding.confidence")
        if self.share is not None:
            within(self.share, 0.0, 1.0, "finding.share")

    @property
    def named(self) -> bool:
        """Whether it is an effect of the library."""
        return self.effect != UNKNOWN

    def equalled_by(self, more: Iterable[Rejected]) -> "Finding":
        """Return the finding with further equivalents behind those that it has, without what is among these."""
        told = {(r.effect, r.at) for r in self.equivalent}
        return replace(self, equivalent=(*self.equivalent, *(r for r in more if (r.effect, r.at) not in told)))


@dataclass(frozen=True)
class Own:
    """What a recording says of an effect that is the sensor's own, and that its next recording will have too."""

    effect: str
    at: str
    parameters: Mapping[str, Parameter]

    def __post_init__(self) -> None:
        place(self.at, "own.at")


@dataclass(frozen=True)
class SensorErrors:
    """What a recording says of the errors that one IMU adds sample by sample, found or not."""

    at: str
    rate: float  # Hz, nominal
    ranges: Mapping[str, float]  # of "gyro" rad/s and "accel" m/s^2, where they are declared
    errors: tuple[Own, ...]  # all at `at`
    correlation: Array  # (k, k) of their numbers, one after the other

    def __post_init__(self) -> None:
        place(self.at, "sensors.at")
        for name, value in (("rate", self.rate), *self.ranges.items()):
            if not finite(value, f"sensors.{name}") > 0:
                raise InputError(f"sensors.{name}: expected a number above 0, got {value:g}")
        matrix = np.array(self.correlation, dtype=float)
        k = self.value.size
        if matrix.shape != (k, k) or not np.isfinite(matrix).all():
            raise InputError(f"sensors.correlation: expected {k} rows of {k} finite numbers, got shape {matrix.shape}")
        if not (
            np.allclose(matrix, matrix.T, atol=CORRELATION_ROUNDING)
            and np.allclose(np.diag(matrix), 1.0, atol=CORRELATION_ROUNDING)
        ):
            raise InputError("sensors.correlation: expected a symmetric matrix with 1 on its diagonal, got another one")
        if float(np.min(np.linalg.eigvalsh(matrix), initial=0.0)) < -CORRELATION_ROUNDING * max(k, 1):
            raise InputError("sensors.correlation: expected a matrix without negative eigenvalues, got one with some")
        matrix.flags.writeable = False
        object.__setattr__(self, "correlation", matrix)

    @property
    def value(self) -> Array:
        """The numbers (k,) of all its errors."""
        return np.concatenate([np.zeros(0), *(p.value.ravel() for e in self.errors for p in e.parameters.values())])

    @property
    def covariance(self) -> Array:
        """The covariance (k, k) of these."""
        std = np.concatenate([np.zeros(0), *(p.std.ravel() for e in self.errors for p in e.parameters.values())])
        return np.asarray(self.correlation * np.outer(std, std))


@dataclass(frozen=True)
class Baseline:
    """What a diagnosis took over from an earlier one of the same sensors."""

    recording: str  # the earlier one's name
    taken_over: tuple[Own, ...]  # `std` as wide as the time in between makes it
    doubt: str = ""  # what speaks against what it says of the sensors, in words; "": nothing


@dataclass(frozen=True)
class Change:
    """Figures by name before and after the findings are in the model; both hold the same names."""

    before: Mapping[str, float] = field(default_factory=dict)
    after: Mapping[str, float] = field(default_factory=dict)
    unit: str = ""

    def __post_init__(self) -> None:
        for key in ("before", "after"):
            for name, value in getattr(self, key).items():
                finite(value, f"fit.{key}.{name}")
        if self.before.keys() != self.after.keys():
            raise InputError(f"fit.after: expected the keys {sorted(self.before)}, got {sorted(self.after)}")


@dataclass(frozen=True)
class FitQuality:
    """How well the model predicts what its fit has not seen, without and with the findings."""

    heldout: Pair  # misfit on held-out data, before and after
    left_out_channel: Change = Change(unit=CHANNEL_UNIT)
    reference: Change = Change(unit="rad RMS")  # empty without one

    def __post_init__(self) -> None:
        for value in self.heldout:
            within(value, 0.0, np.inf, "fit.heldout")


@dataclass(frozen=True)
class Unseen:
    """What the recording could not have shown, and the motion that would show it."""

    what: str
    motion: str


@dataclass(frozen=True)
class Doubt:
    """What speaks against the model that was found: then its numbers are not to be used."""

    of: str  # "imu1.rotation", "rocking_mount@imu1.com", or "prediction" of the model as a whole
    why: str


@dataclass(frozen=True)
class Nonsense:
    """What no simulation can be held against: sensors of two recordings, a mirrored one, one that is stuck."""

    at: str
    what: str  # "imu2 looks mirrored in z"
    evidence: Mapping[str, float] = field(default_factory=dict)  # statistics by name
    channels: tuple[str, ...] = ()  # that it concerns: gyr_z
    advice: str = ""  # what to look at
    missing: bool = False  # there is too little to say that anything is wrong: the recording shows nothing

    def __post_init__(self) -> None:
        place(self.at, "nonsense.at")
        for name, value in self.evidence.items():
            finite(value, f"nonsense.evidence.{name}")


@dataclass(frozen=True)
class Diagnosis(Displayed):
    """The whole answer; `InputError` where the verdict does not go with the findings."""

    recording: str
    rig: str
    verdict: Verdict
    misfit: Pair  # residual power over noise power of the nominal and of the explained model
    where: tuple[Where, ...]
    findings: tuple[Finding, ...]  # strongest first, what is doubted behind what is sure, what has no name last
    rejected: tuple[Rejected, ...]
    fit: FitQuality
    model: str  # path of the MJCF file beside diagnosis.json, "" where none is written
    seconds: float
    unseen: tuple[Unseen, ...] = ()
    nonsense: tuple[Nonsense, ...] = ()
    stopped: str = ""  # what stopped it: "time limit of 600 s of processor time"
    not_tried: tuple[str, ...] = ()  # by then, in words

    noise: Mapping[str, Noise] = field(default_factory=dict)  # "imu1.gyro" and so on
    tolerance: Pair = TOLERANCE  # deg, mm
    sensors: tuple[SensorErrors, ...] = ()  # of every IMU; empty where none was fitted
    baseline: Baseline | None = None
    doubts: tuple[Doubt, ...] = ()
    simulation: Simulation | None = None  # None: MuJoCo has played nothing
    moves: Moves = field(default_factory=dict)  # by everything found together; empty: nothing found, or not known

    @property
    def alarm(self) -> bool:
        """Whether something matters: a sure finding that is material, or what has no name and moves something."""
        return any(f.material and (f.confidence >= CONFIDENCE.counts or not f.named) for f in self.findings)

    @property
    def noise_unknown(self) -> tuple[str, ...]:
        """The triples whose noise nobody knows."""
        return tuple(name for name, noise in self.noise.items() if noise.source == NOT_KNOWN)

    @property
    def fitted(self) -> bool:
        """Whether a motion was fitted: not where the recording makes no sense."""
        return not self.nonsense or self.verdict not in ("unexplained", "unobservable")

    def __post_init__(self) -> None:
        if self.verdict not in VERDICTS:
            raise unknown("verdict", self.verdict, VERDICTS)
        for value in (*self.misfit, self.seconds):
            within(value, 0.0, np.inf, "diagnosis.misfit and seconds")
        sure = [f for f in self.findings if f.confidence >= CONFIDENCE.counts]
        named = [f for f in sure if f.named]
        fits = {
            "no mismatch": not sure,
            "explained": bool(named) and len(named) == len(sure) and not (self.noise_unknown or self.doubts),
            "partly explained": bool(named) and (len(named) < len(sure) or bool(self.noise_unknown or self.doubts)),
            "unexplained": bool(sure) and not named,
            "unobservable": bool(self.unseen),
        }
        for value in self.tolerance:
            within(value, 0.0, np.inf, "diagnosis.tolerance")
        if not fits[self.verdict]:
            strange = f", and no noise known of {', '.join(self.noise_unknown)}" if self.noise_unknown else ""
            strange += f", and doubts about {', '.join(d.of for d in self.doubts)}" if self.doubts else ""
            raise InputError(
                f"verdict '{self.verdict}': expected findings that go with it, got "
                f"{[f'{f.effect} at {f.at}, {f.confidence:.2f}' for f in self.findings]}{strange}"
            )
