"""Plain sentences about a diagnosis."""

from imubench.diagnosis.result import SURE, UNKNOWN, Baseline, Diagnosis, Finding, Move, Pair, Rejected, Where

EFFECTS = {
    "gyro_bias": "a constant offset of {imu}'s gyroscope",
    "accel_bias": "a constant offset of {imu}'s accelerometer",
    "gyro_drift": "an offset of {imu}'s gyroscope that grows with time",
    "accel_drift": "an offset of {imu}'s accelerometer that grows with time",
    "gyro_scale": "a scale error of {imu}'s gyroscope",
    "accel_scale": "a scale error of {imu}'s accelerometer",
    "gyro_misalignment": "gyroscope axes of {imu} that are not square",
    "accel_misalignment": "accelerometer axes of {imu} that are not square",
    "g_sensitivity": "a gyroscope in {imu} that feels acceleration",
    "gyro_noise": "more noise of {imu}'s gyroscope than declared",
    "accel_noise": "more noise of {imu}'s accelerometer than declared",
    "low_pass": "a low-pass filter in {imu}",
    "time_offset": "a clock of {imu} that is set wrong",
    "clock_skew": "a clock of {imu} that runs too fast or too slow",
    "saturation": "readings of {imu} that are clipped",
    "quantisation": "readings of {imu} that are rounded to steps",
    "dropouts": "samples of {imu} that are lost",
    "vibration": "a hum at {imu}",
    "impacts": "knocks on {imu}",
    "mount_pose": "{imu} sitting elsewhere than the model has it",
    "mount_shift": "{imu} moving to another place during the recording",
    "soft_mount": "a soft mount that {imu} moves on as on springs",
    "rocking_mount": "a mount that {imu} rocks on",
    "skin_sliding": "{imu} sliding along as the joint moves",
    "joint_play": "play across the hinge axis",
    "axis_coupling": "a rotation off the hinge axis that follows the hinge angle",
    "moving_centre": "a joint centre that moves with the hinge angle",
    "moving_pivot": "a pivot that does not stay in its place",
    "viscous_friction": "viscous friction in the joint",
    "dry_friction": "dry friction in the joint",
    "air_drag": "air drag",
    "joint_spring": "a spring, such as a cable, across the joint",
    "end_stop": "a stop at the end of the joint's range",
    "backlash": "backlash between joint and encoder",
    "inertia": "an inertia that is not the declared one",
    "gravity": "a gravity that is not the declared one",
    UNKNOWN: "something at {imu} that no effect of the library explains",
}

MEASURED = {
    "hinge_angle": "hinge angle",
    "hinge_angle_but_constant": "hinge angle, but for a constant",
    "orientation1": "orientation of segment 1",
}

MOVED = {  # what a finding moves -> in words
    "joint_axis": "joint axis",
    "joint_centre": "joint centre",
    "hinge_angle": "hinge angle",
    "hinge_angle_constant": "zero of the hinge angle",
    "orientation": "orientation",
    "mount_rotation": "sensor on its segment",
    "lever": "place of the sensor",
}

VERDICTS = {  # verdict -> how it looks
    "no mismatch": "good",
    "explained": "good",
    "partly explained": "part",
    "unexplained": "bad",
    "unobservable": "part",
}


def called(effect: str, at: str) -> str:
    """Return what an effect at a place is, in words."""
    text = EFFECTS.get(effect, effect.replace("_", " ") + " at {imu}")
    return text.format(imu=at if at.startswith(("imu", "pose")) else f"the {at}")


def title(finding: Finding) -> str:
    """Return a finding as a headline."""
    text = called(finding.effect, finding.at)
    return text[0].upper() + text[1:]


def headline(d: Diagnosis) -> str:
    """Return the verdict in one sentence for somebody who has seen nothing else; what makes no sense comes first."""
    odd = "; ".join(n.what for n in d.nonsense)
    odd = odd if odd.startswith(("imu", "pose", "gyr", "acc")) else odd[:1].upper() + odd[1:]  # names stay names
    if not d.fitted:
        return f"{odd}. No simulation can be held against that."
    return f"{_headline(d)} {odd}." if odd else _headline(d)


def tolerance(d: Diagnosis) -> str:
    """Return the tolerance in words."""
    return f"{d.tolerance[0]:g} deg and {d.tolerance[1]:g} mm"


def alarm(d: Diagnosis) -> str:
    """Return in a sentence why there is an alarm, or none."""
    if not d.alarm:
        return f"nothing that is sure moves a joint or a segment by {tolerance(d)}."
    loud = [f for f in d.findings if f.material and (f.confidence >= SURE or not f.named)]
    return f"{listed([called(f.effect, f.at) for f in loud])} may matter: {moved(loud[0])}."


def baseline(taken: Baseline) -> str:
    """Return in a sentence what was taken over from which recording."""
    effects = list(dict.fromkeys(own.effect.replace("_", " ") for own in taken.taken_over))
    return f"Known from the baseline {taken.recording}, and not looked for: {listed(effects)}."


def moved(finding: Finding) -> str:
    """Return what a finding moves, in words."""
    if not finding.moves:
        return "what is not known"
    return ", ".join(f"{MOVED.get(name, name)} {_size(move)}" for name, move in finding.moves.items())


def _size(move: Move) -> str:
    digits = 1 if move.unit.startswith("mm") else 2
    return f"{listed([f'{value:.{digits}f}' for value in move.value.ravel()])} {move.unit}"


def _headline(d: Diagnosis) -> str:
    named = listed([called(f.effect, f.at) for f in d.findings if f.named and f.confidence >= 0.5])
    if d.verdict == "no mismatch":
        return "The simulation and this recording agree: what differs is sensor noise."
    if d.verdict == "explained":
        return f"The simulation leaves out {named}. With that in it, only sensor noise is left."
    if d.verdict == "partly explained" and d.doubts:
        return f"The simulation leaves out {named}, or something like it; no model was found that can be trusted."
    if d.verdict == "partly explained" and all(f.named for f in d.findings if f.confidence >= SURE):
        sensors = listed(list(d.noise_unknown))
        return (
            f"The simulation leaves out {named}. Whether only sensor noise is left cannot be said: that of {sensors} "
            "is not known."
        )
    if d.verdict == "partly explained":
        return f"The simulation leaves out {named}. With that in it, part of the difference is still unexplained."
    if d.verdict == "unobservable":
        return f"This recording cannot show {listed([u.what for u in d.unseen])}."
    where = d.where[0] if d.where else None
    place = "" if where is None else f", most of all at {where.at} ({channels(where)})"
    why = "what explains it was not found in the time given" if d.stopped else "no effect of the library explains it"
    return f"The simulation and this recording differ{place}, and {why}."


def places(d: Diagnosis, span: Pair) -> list[str]:
    """Return sentences about where the recording differs from the declared model."""
    if not d.fitted:
        return list(dict.fromkeys(f"To do: {n.advice}." for n in d.nonsense))
    if not d.where:
        return ["Nowhere by more than the sensors' noise."]
    found = [location(w, span) for w in d.where]
    if d.verdict == "no mismatch":
        total = (
            f"Residuals have {d.misfit[0]:.2f} times the power of noise: too little above 1 to be called a mismatch."
        )
        return [f"{total} What there is:", *found]
    return found


def location(w: Where, span: Pair) -> str:
    """Return where an excess is, in a sentence or two; `span` is the recording's first and last time in s."""
    parts = [f"{percent(w.share)} of what noise does not explain is at {w.at}: {shares(w)}"]
    if w.bands_hz:
        parts.append(f"at {listed([f'{a:.3g} to {b:.3g} Hz' for a, b in w.bands_hz])}")
    if any(covers(window, span) for window in w.windows_s):
        parts.append("all the time")
    elif w.windows_s:
        parts.append(f"from {listed([f'{a:.1f} to {b:.1f} s' for a, b in w.windows_s])}")
    goes = "" if w.depends_on.startswith("nothing") else f" It comes and goes with {w.depends_on}."
    return ", ".join(parts) + "." + goes


def stopped(d: Diagnosis) -> str:
    """Return in a sentence what stopped a diagnosis and what was not tried; empty where nothing did."""
    return f"Stopped at the {d.stopped}; not tried: {listed(list(d.not_tried))}." if d.stopped else ""


def covers(window: Pair, span: Pair) -> bool:
    """Return whether a window is nearly all of a span."""
    return window[1] - window[0] > 0.9 * (span[1] - span[0])


def channels(w: Where) -> str:
    """Return the channels that hold most of the excess at a sensor."""
    return listed([name for name, share in w.channels.items() if share >= 0.3 * max(w.channels.values())])


def shares(w: Where) -> str:
    """Return the channels with their shares."""
    return listed([f"{name} ({percent(share)})" for name, share in w.channels.items()])


def rejection(r: Rejected) -> str:
    """Return why an effect was not taken."""
    if r.heldout_gain < 0:
        return "with it, data that the fit has not seen are predicted worse"
    return "it predicts unseen data hardly better, and explains too little for its freedom"


def certainty(confidence: float) -> str:
    """Return a probability in words."""
    steps = ((0.99, "certain"), (0.95, "very likely"), (0.8, "likely"), (0.5, "more likely than not"))
    return next((word for least, word in steps if confidence >= least), "doubtful")


def listed(parts: list[str]) -> str:
    """Return `a, b and c`."""
    return parts[0] if len(parts) == 1 else ", ".join(parts[:-1]) + " and " + parts[-1] if parts else "nothing"


def percent(share: float) -> str:
    """Return a share as a whole percentage."""
    return f"{100 * share:.0f} %"
