"""Plain sentences about a diagnosis."""

from imubench.diagnosis.config.shared import CONFIDENCE
from imubench.diagnosis.result import UNKNOWN, Baseline, Diagnosis, Finding, Move, Moves, Pair, Rejected, Where
from imubench.effects import EFFECTS, traits_of

UNNAMED = "something at {imu} that no effect of the library explains"
MEASURED_WORDS = {
    "hinge_angle": "hinge angle",
    "hinge_angle_but_constant": "hinge angle, but for a constant",
    "orientation1": "orientation of segment 1, with the heading's drift",
    "tilt1": "tilt of segment 1",
}

MOVED_WORDS = {  # what a finding moves -> in words
    "joint_axis": "joint axis",
    "joint_centre": "joint centre",
    "hinge_angle": "hinge angle",
    "hinge_angle_constant": "zero of the hinge angle",
    "orientation": "orientation",
    "mount_rotation": "sensor on its segment",
    "lever": "place of the sensor",
}

KINDS = {"gyr": "gyroscope", "acc": "accelerometer"}  # part of a channel's name -> in words

VERDICT_LOOKS = {  # verdict -> how it looks
    "no mismatch": "good",
    "explained": "good",
    "partly explained": "part",
    "unexplained": "bad",
    "unobservable": "part",
}


def called(effect: str, at: str) -> str:
    """Return what an effect at a place is, in words."""
    text = UNNAMED if effect == UNKNOWN else traits_of(effect).phrase or effect.replace("_", " ") + " at {imu}"
    return text.format(imu=at if at.startswith(("imu", "pose")) else f"the {at}")


def sentence(text: str) -> str:
    """Return plain text with a capital letter in front, unless it begins with the name of a sensor."""
    return text if text.startswith(("imu", "pose")) else text[:1].upper() + text[1:]


def title(finding: Finding) -> str:
    """Return a finding as a headline."""
    return sentence(called(finding.effect, finding.at))


def tolerance(d: Diagnosis) -> str:
    """Return the tolerance in words."""
    return f"{d.tolerance[0]:g} deg and {d.tolerance[1]:g} mm"


def alarm(d: Diagnosis) -> str:
    """Return in a sentence why there is an alarm, or none."""
    if not d.alarm:
        return f"nothing that is sure moves a joint or a segment by {tolerance(d)}."
    loud = [f for f in d.findings if f.material and (f.confidence >= CONFIDENCE.counts or not f.named)]
    names = listed([called(f.effect, f.at) for f in loud])
    return f"{names} may matter: {moved(loud[0].moves)}." if loud[0].moves else f"{names} may matter."


def baseline(taken: Baseline) -> str:
    """Return what was taken over from which recording, and what speaks against that."""
    effects = list(dict.fromkeys(own.effect.replace("_", " ") for own in taken.taken_over))
    known = f"Known from the baseline {taken.recording}, and not looked for: {listed(effects)}."
    return f"{known} What that says of the sensors may be wrong: {taken.doubt}." if taken.doubt else known


def moved(moves: Moves) -> str:
    """Return what is moved, in words."""
    if not moves:
        return "what is not known"
    told: list[str] = []
    for name, move in moves.items():
        whose = _whose(name, move.value.size)
        again = bool(whose) and any(whose in text for text in told)
        told.append(f"{MOVED_WORDS.get(name, name)} {_size(move)}{'' if again else whose}")
    return ", ".join(told)


def motion(finding: Finding) -> str:
    """Return the motion that would tell a finding from its equivalents, without what it is worth."""
    return finding.separate_by.partition(": expected log Bayes factor")[0]


def whose_axes(finding: Finding) -> str:
    """Return in a sentence whose axes the components of a finding's numbers are along or about; empty without any."""
    effect = EFFECTS.get(finding.effect)
    numbers = [] if effect is None else [p for p in effect.parameters if p.width > 1 and p.name in finding.parameters]
    at_imu = finding.at.startswith("imu")
    whose = {"sensor": finding.at if at_imu else "the sensor", "segment": "its segment" if at_imu else "the segment"}
    of = {whose[p.axes]: [q.name.replace("_", " ") for q in numbers if q.axes == p.axes] for p in numbers}
    if len(of) < 2:
        return "".join(f"x, y and z are axes of {frame}." for frame in of)
    return f"x, y and z are axes {' and '.join(f'of {frame} for the {listed(names)}' for frame, names in of.items())}."


def _size(move: Move) -> str:
    digits = 1 if move.unit.startswith("mm") else 2
    return f"{listed([f'{value:.{digits}f}' for value in move.value.ravel()])} {move.unit}"


def _whose(name: str, count: int) -> str:
    """Return of which sensors or segments the numbers of a move are; empty where there is one."""
    of = "segment " if name == "orientation" else "imu"
    return f" ({listed([f'{of}{i + 1}' for i in range(count)])})" if count > 1 else ""


def location(w: Where, span: Pair, zero: float | None = None) -> str:
    """Return where an excess is, in a sentence or two.

    Args:
        w: the place.
        span: the recording's first and last time in s.
        zero: the time in s from which seconds are counted; None: the recording's first.
    """
    zero = span[0] if zero is None else zero
    parts = [f"{percent(w.share)} of what noise does not explain is at {w.at}: {shares(w)}"]
    if w.bands_hz:
        parts.append(f"at {listed([f'{a:.3g} to {b:.3g} Hz' for a, b in w.bands_hz])}")
    if any(covers(window, span) for window in w.windows_s):
        parts.append("all the time")
    elif w.windows_s:
        parts.append(f"from {listed([f'{a - zero:.1f} to {b - zero:.1f} s' for a, b in w.windows_s])}")
    goes = "" if w.depends_on.startswith("nothing") else f" It comes and goes with {w.depends_on}."
    return ", ".join(parts) + "." + goes


def stopped(d: Diagnosis) -> str:
    """Return in a sentence what stopped a diagnosis and what was not tried; empty where nothing did."""
    return f"Stopped at the {d.stopped}; not tried: {listed(list(d.not_tried))}." if d.stopped else ""


def covers(window: Pair, span: Pair) -> bool:
    """Return whether a window is nearly all of a span."""
    return window[1] - window[0] > 0.9 * (span[1] - span[0])


def spelled(channel: str) -> str:
    """Return a channel such as imu2.acc_x in words."""
    at, _, name = channel.partition(".")
    part, _, axis = name.partition("_")
    if at == "encoder":
        return f"{name} encoder" if name != "angle" else "encoder"
    return f"{at} {KINDS[part]} {axis}" if part in KINDS else f"{at} {name}"


def channels(w: Where) -> str:
    """Return the channels that hold most of the excess at a sensor."""
    most = max(w.channels.values())
    return listed([channel(name) for name, share in w.channels.items() if share >= 0.3 * most])


def shares(w: Where) -> str:
    """Return the channels with their shares."""
    return listed([f"{channel(name)} ({percent(share)})" for name, share in w.channels.items()])


def channel(name: str) -> str:
    """Return a sensor's channel such as acc_x in words."""
    part, _, axis = name.partition("_")
    return f"{KINDS[part]} {axis}" if part in KINDS else name


def rejection(r: Rejected) -> str:
    """Return why an effect was not taken."""
    if r.heldout_gain < 0:
        return "it explains less than what was taken, or predicts samples worse that the fit has not seen"
    return "it is not sure to predict unseen samples better, or not needed beside what was found"


def certainty(confidence: float) -> str:
    """Return a probability in words."""
    steps = ((0.99, "certain"), (0.95, "very likely"), (0.8, "likely"), (0.5, "more likely than not"))
    return next((word for least, word in steps if confidence >= least), "doubtful")


def listed(parts: list[str]) -> str:
    """Return `a, b and c`."""
    return parts[0] if len(parts) == 1 else ", ".join(parts[:-1]) + " and " + parts[-1] if parts else "nothing"


def part(share: float) -> str:
    """Return a share of what differs as a whole percentage; one that rounds to none is not none."""
    return percent(share) if share >= 0.005 else "under 1 %"


def percent(share: float) -> str:
    """Return a share as a whole percentage."""
    return f"{100 * share:.0f} %"
