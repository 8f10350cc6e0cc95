"""What figures 6 and 7 are measured by: errors over time with selected samples, and which samples those are."""

import numpy as np

from imubench.reproduce.claims import Measured
from imubench.reproduce.olsson2020 import data
from imubench.reproduce.olsson2020.results import Results
from imubench.reproduce.olsson2020.settings import N_MAX, SEQUENCES, SIZES

UNINFORMATIVE, RESTING = (1, 2, 8, 9), (1, 8)


def _end_of(r: Results, name: str, motion: int) -> float:
    return next(s.end for s in r.sections(name) if s.motion == motion)


def apart_from_all(r: Results, size: int) -> Measured:
    """Return how far figure 6a's errors with selection are from those with all samples, in deg, after motion 3."""
    first = int(np.searchsorted(r.times("sequence1"), _end_of(r, "sequence1", 3)))
    curves = r.over_time["sequence1"]
    apart = np.rad2deg(np.abs(curves[size] - curves[0])[first:])
    ends = [np.rad2deg(curves[n][-1]).max() for n in (size, 0)]
    return Measured(float(apart.max()), f"at the end {ends[0]:.2g} deg, with all samples {ends[1]:.2g} deg")


def settled(r: Results, name: str, size: int, limit: float, axes: tuple[int, ...]) -> float:
    """Return the time in s from which figure 6's errors of these axes stay below `limit` deg; inf for never."""
    errors = np.rad2deg(r.over_time[name][size][:, axes]).max(axis=1)
    above = np.flatnonzero(errors >= limit)
    last = above[-1] if above.size else -1
    return float(r.times(name)[last + 1]) if last + 1 < errors.size else float("inf")


def settled_2(r: Results, size: int) -> Measured:
    """Return when the error of j2 settles below 2 deg in sequence 2."""
    times = {n: settled(r, "sequence2", n, 2.0, (1,)) for n in SIZES}
    listed = ", ".join(f"{'all' if n == 0 else n}: {t:.0f} s" for n, t in times.items())
    errors = np.rad2deg(r.over_time["sequence2"][size][:, 1])
    when = r.times("sequence2")
    turns = _end_of(r, "sequence2", 1)
    early = when[(when > turns) & (errors < 2.0)]
    late = int(((when > early[0]) & (errors >= 2.0)).sum()) if early.size else 0
    again = f"; {late} single estimates are above again later, from starts that led elsewhere" if late else ""
    return Measured(
        times[size],
        f"by N_max: {listed}. Here segment 1, which turns from {turns:.0f} s on, is enough: the first estimate below "
        f"2 deg after that comes at {early[0] if early.size else np.inf:.0f} s{again}. The true axes leave only "
        f"{_floor(r):.2g} m/s^2 in the acceleration constraint at rest, which is what j2 is found from",
    )


def _floor(r: Results) -> float:
    """Return the mean residual of the acceleration constraint at rest, m/s^2: what the sensors' biases leave."""
    samples, true = data.motion(1, r.settings.seed), data.session(r.settings.seed).axes
    return float(abs(np.mean(samples.accel1 @ true[0] - samples.accel2 @ true[1])))


def final_difference_of_sequences(r: Results) -> Measured:
    """Return the largest difference in deg of the final errors of sequences 1 and 2, over axes and N_max."""
    ends = np.rad2deg([[r.over_time[n][size][-1] for size in SIZES] for n in SEQUENCES[:2]])
    return Measured(float(np.abs(ends[0] - ends[1]).max()), f"all final errors are at most {ends.max():.2g} deg")


def gain_of_selection_3(r: Results) -> Measured:
    """Return the final error of sequence 3 with all samples over that with N_max = 1000, the worse axis each."""
    ends = {n: float(np.rad2deg(r.over_time["sequence3"][n][-1]).max()) for n in SIZES}
    listed = ", ".join(f"{'all' if n == 0 else n}: {e:.2g} deg" for n, e in ends.items())
    return Measured(ends[0] / ends[N_MAX], f"final errors by N_max: {listed}")


def error_4_during_9(r: Results) -> Measured:
    """Return the median in deg of sequence 4's errors during the first half of motion 9, N_max below 1000."""
    part = next(s for s in r.sections("sequence4") if s.motion == 9)
    times = r.times("sequence4")
    within = (times > part.start) & (times <= part.end)
    sizes = [n for n in SIZES if 0 < n < N_MAX]
    errors = np.rad2deg(np.concatenate([r.over_time["sequence4"][n][within].ravel() for n in sizes]))
    low, high = np.percentile(errors, [10, 90])
    why = f"nine in ten of them lie above {low:.2g} deg, one in ten above {high:.2g} deg. {_before_9(r)}"
    return Measured(float(np.median(errors)), why)


def settled_4(r: Results) -> Measured:
    """Return the time in s from which both errors of sequence 4 stay below 3 deg with N_max = 1000."""
    part = next(s for s in r.sections("sequence4") if s.motion == 6)
    time = settled(r, "sequence4", N_MAX, 3.0, (0, 1))
    why = f"both errors stay below 3 deg from then on; motion 6 lasts from {part.start:.0f} to {part.end:.0f} s"
    return Measured(time, f"{why}. {_before_9(r)}")


def _before_9(r: Results) -> str:
    """Say what the motions before motion 9 tell in sequence 4."""
    start = next(s.start for s in r.sections("sequence4") if s.motion == 9)
    before = (r.times("sequence4") > start - 15.0) & (r.times("sequence4") <= start)
    error = float(np.rad2deg(np.median(r.over_time["sequence4"][N_MAX][before].max(axis=1))))
    whole = data.session(r.settings.seed)
    assert whole.truth.joint_angle is not None
    if error >= 3.0:
        return f"Before motion 9 the median error is {error:.2g} deg"
    angles = [np.interp(np.mean(whole.span(m)), whole.truth.time, whole.truth.joint_angle) for m in (1, 8, 2)]
    listed = ", ".join(f"{np.rad2deg(a):.0f}" for a in angles)
    return (
        f"Before motion 9 the median error is {error:.2g} deg already: here motions 1, 8 and 2 tell the axis, for the "
        f"screw holds the joint at {listed} deg, and one axis fits what the accelerometers see at all three"
    )


def held_by_motion(r: Results, name: str, kind: str) -> dict[int, int]:
    """Return how many samples of each motion are held at the end of a sequence."""
    held = r.selected[name][kind][-1]
    motions = data.motions_of(name, r.settings.seed)[held[held >= 0]]
    return {int(m): int(n) for m, n in zip(*np.unique(motions, return_counts=True), strict=True)}


def uninformative_gyro_samples(r: Results) -> Measured:
    """Return how many gyroscope samples of motions 1, 2, 8, 9 are held at the end of sequences 1 and 2 together."""
    counts = {name: held_by_motion(r, name, "gyro") for name in SEQUENCES[:2]}
    total = sum(n for held in counts.values() for m, n in held.items() if m in UNINFORMATIVE)
    listed = "; ".join(
        f"{name}: " + ", ".join(f"{n} of motion {m}" for m, n in held.items()) for name, held in counts.items()
    )
    return Measured(total, f"held in {listed}")


def preference_for_rest(r: Results) -> Measured:
    """Return the share of motions 1 and 8 in the held accelerometer samples over their share of the time."""
    ratios, texts = [], []
    for name in SEQUENCES[:2]:
        held = held_by_motion(r, name, "accel")
        share = sum(held.get(m, 0) for m in RESTING) / sum(held.values())
        time = float(np.mean(np.isin(data.motions_of(name, r.settings.seed), RESTING)))
        ratios.append(share / time)
        texts.append(f"{name}: {share:.0%} of the samples, {time:.0%} of the time")
    return Measured(min(ratios), "; ".join(texts))
