"""IMUs with too few samples to be held against anything."""

from collections.abc import Iterator

from imubench.diagnosis.config.nonsense import STRETCH
from imubench.diagnosis.config.samples import SCREENING
from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.result import Nonsense
from imubench.recording import Recording


def too_few_samples(recording: Recording) -> Iterator[Nonsense]:
    """Yield every IMU whose samples are too few, too far apart, or of a moment only."""
    clocks = [i.time for i in recording.imus] + [e.time for e in recording.encoders] + [p.time for p in recording.poses]
    seconds = float(max(t[-1] for t in clocks) - min(t[0] for t in clocks))
    for imu in recording.imus:
        count, own = int(imu.time.size), float(imu.time[-1] - imu.time[0])
        promised = imu.rate * own
        evidence = {"samples": float(count), "seconds": own}
        advice = f"record {imu.name} at {imu.rate:g} Hz for as long as the rest, or leave it out"
        if count < SCREENING.least_samples:
            what = f"{imu.name} has too few samples: {count}, where {SCREENING.least_samples} are needed"
        elif count < STRETCH.least_share * promised:
            what = f"{imu.name} has too few samples: {count} in {own:.1f} s, where {imu.rate:g} Hz are declared"
        elif own < min(STRETCH.least_share * seconds, EVIDENCE.least_s):
            what = f"{imu.name} has samples of {own:.1f} s only, in a recording of {seconds:.1f} s"
        else:
            continue
        yield Nonsense(imu.name, what, evidence, advice=advice, missing=True)


__all__ = ["too_few_samples"]
