"""What all cases add up to, beside what is required of real recordings."""

from collections.abc import Callable, Sequence
from fnmatch import fnmatchcase

import numpy as np

from benchmarks.real.scoring import HELDOUT, CaseScore
from benchmarks.real.steps import NOT_RUN
from benchmarks.real.table import Halves, Line
from benchmarks.real_axes import ROUNDED, ROWS
from benchmarks.table import Row

FIRST = "trial1"  # for which ANGLES and ROWS were measured
ANGLES = {"3-4": 0.7, "4-5": 1.0}  # deg RMS, hinge angle of the whole trial on foam
THIRDS = ("whole", "third1", "third2", "third3")
SILENT = 0.95  # of the windows of screwed-on IMUs
REPEATED = 0.9  # of the findings of confidence 0.9
FOAM_SECONDS, LOOSE_SECONDS, MEMORY = 120.0, 90.0, 1.0  # s of processor time and GB, of whole trials of 68 s
BASELINE = "-after-"

Asked = Callable[[CaseScore], bool | None]


def rows(lines: Sequence[Line], halves: Sequence[Halves]) -> list[Row]:
    """Return a row for everything that is required of recordings that are among the cases.

    A case without a diagnosis is no success: it counts against a share, and a number that it lacks is not met. One that
    has not been run yet counts for nothing; how many these are is said.
    """
    alone = [line for line in lines if BASELINE not in line.name]
    given = [line for line in lines if BASELINE in line.name]
    found = [
        _none("wrong but explained", lines, _explained(lambda s: bool(s.wrong))),
        _none(f"explained, and over {HELDOUT:g} held out", lines, _explained(_unfit)),
        _none("hinge angle worse than as declared", lines, lambda s: s.angle_worse),
        _share("foam named or located at both IMUs", lines, "diodem/*-foam/*", lambda s: s.located),
        _share("windows of screwed-on IMUs silent but for play", lines, "diodem/*-rigid/*-*", _quiet, SILENT),
        _share("play of joint 2-3 named, IMUs screwed on", lines, "diodem/*/2-3-rigid/*", lambda s: s.named),
        _share("undisturbed trials silent", alone, "broad/*_undisturbed_*", _quiet),
        _share("undisturbed trials silent, given another", given, "broad/*_undisturbed_*", _quiet),
        _share("taps and phone named", alone, "broad/*_disturbed_*", lambda s: s.named),
        _share("taps and phone named, nothing else, given another", given, "broad/*_disturbed_*", _alone),
        _share("the pendulum's friction named", lines, "multiarm/*", lambda s: s.named),
        *(_angle(lines, joint) for joint in ANGLES),
        *(_axes(lines, joint, name, 1) for joint in ROWS for name in ("olsson2020", "seel2012")),
        *(_axes(lines, joint, "olsson2020-banded", 0) for joint in ROWS),
        _repeated(halves),
        *(_steadier(h, name) for h in halves if h.name.startswith("dot-knee/") for name in h.raw),
        _most("processor time of a whole trial on foam", lines, "diodem/*/[34]-?-foam/whole", FOAM_SECONDS, "s"),
        _most("processor time of a whole trial with play", lines, "diodem/*/2-3-rigid/whole", LOOSE_SECONDS, "s"),
        _most("largest memory of a whole trial", lines, "diodem/*/whole", MEMORY, "GB"),
    ]
    return [row for row in found if row is not None]


def _row(what: str, ours: str, required: str, met: bool) -> Row:
    return Row(what, ours, "-", "-", required, met)


def _none(what: str, lines: Sequence[Line], asked: Asked) -> Row:
    """Return the row of something that must not be, of the cases that are asked."""
    answers = [a for line in lines if line.score is not None and (a := asked(line.score)) is not None]
    met = not any(answers) and any(line.score is not None for line in lines)
    return _row(what, f"{sum(answers)} of {len(answers)}", "0", met)


def _share(what: str, lines: Sequence[Line], pattern: str, asked: Asked, least: float = 1.0) -> Row | None:
    """Return the row of how often a question is answered by yes; None where no case is asked it."""
    fitting = [line for line in lines if fnmatchcase(line.name, pattern)]
    ran = [line for line in fitting if line.failed != NOT_RUN]
    answers = [False if line.score is None else asked(line.score) for line in ran]
    count, of = sum(a is True for a in answers), sum(a is not None for a in answers)
    if not of:
        return None
    rest = f"; {len(fitting) - len(ran)} not run yet" if len(ran) < len(fitting) else ""
    return _row(what, f"{count} of {of}{rest}", "all" if least == 1 else f"{least:.0%}", count >= least * of)


def _most(what: str, lines: Sequence[Line], pattern: str, most: float, unit: str) -> Row | None:
    """Return the row of the largest processor time in s, or memory in GB; None without such a case."""
    ran = [line for line in lines if line.seconds and fnmatchcase(line.name, pattern)]
    if not ran:
        return None
    largest = max(line.seconds if unit == "s" else line.memory for line in ran)
    return _row(f"{what}, the most of {len(ran)}", f"{largest:.3g} {unit}", f"<= {most:g} {unit}", largest <= most)


def _angle(lines: Sequence[Line], joint: str) -> Row | None:
    name, most = f"diodem/{FIRST}/{joint}-foam/whole", ANGLES[joint]
    one = next((line for line in lines if line.name == name), None)
    if one is None:
        return None
    angle = None if one.score is None or one.score.angle is None else float(np.degrees(one.score.angle[1]))
    ours = "none" if angle is None else f"{angle:.2f} deg"
    return _row(f"hinge angle of {name}", ours, f"<= {most:g} deg", angle is not None and angle <= most)


def _axes(lines: Sequence[Line], joint: str, name: str, which: int) -> Row | None:
    """Return the row of the largest deviations at each IMU, of the whole of trial 1 and its thirds.

    `which`: 0 for raw data, where the estimator has to have converged, too; 1 with the findings taken out.
    """
    wanted = [f"diodem/{FIRST}/{joint}-foam/{part}" for part in THIRDS]
    scores = [line.score for line in lines if line.name in wanted]
    if not scores:
        return None
    answers = [s.axes[name][which] for s in scores if s is not None and name in s.axes]
    off = [a.off for a in answers if a.off is not None and (which or a.converged)]
    most = np.degrees(np.max(off, axis=0)) if off else None
    limit = np.array(ROWS[joint]) + ROUNDED / 2
    ours = "none" if most is None else f"{most[0]:.1f} / {most[1]:.1f} deg in {len(off)} of {len(scores)}"
    met = most is not None and len(off) == len(scores) and bool(np.all(most <= limit))
    how = "findings taken out" if which else "raw and converged"
    what = f"axes of joint {joint} on foam by {name}, {how}, whole and thirds"
    return _row(what, ours, f"{ROWS[joint][0]} / {ROWS[joint][1]} deg", met)


def _repeated(halves: Sequence[Halves]) -> Row | None:
    findings = [f for h in halves for f in h.findings]
    if not findings:
        return None
    kept = sum(not f.why for f in findings)
    ours = f"{kept} of {len(findings)}"
    return _row(
        "confident findings of a half confirmed by the other", ours, f"{REPEATED:.0%}", kept >= REPEATED * len(findings)
    )


def _steadier(h: Halves, name: str) -> Row:
    """Return the row of how far an estimator's axes differ between the halves, the larger of the two IMUs."""
    before, after = h.raw[name].max(), h.corrected[name].max() if name in h.corrected else None
    ours = f"{np.degrees(before):.1f} to {'none' if after is None else f'{np.degrees(after):.1f}'} deg"
    what = f"{h.name}: axes by {name} between halves, raw and with findings taken out"
    return _row(what, ours, "less", after is not None and bool(after < before))


def _explained(asked: Asked) -> Asked:
    """Return a question that only a verdict `explained` is asked."""
    return lambda s: asked(s) if s.verdict == "explained" else None


def _unfit(s: CaseScore) -> bool:
    return s.heldout is not None and s.heldout[1] > HELDOUT


def _quiet(s: CaseScore) -> bool:
    return not s.besides


def _alone(s: CaseScore) -> bool | None:
    return None if s.named is None else s.named and not s.besides
