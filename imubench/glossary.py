"""The words that results and reports use, in plain words: for tooltips, `imubench explain`, and docs/glossary.md."""

TERMS: dict[str, str] = {
    "alarm": (
        "Raised where a finding that is likely real moves something you ask for (an axis, a centre, an angle, an "
        "orientation) by more than the tolerance, 0.5 deg and 5 mm unless you say otherwise."
    ),
    "confidence": (
        "The probability that a finding, or one of those that it cannot be told from, is really there. Of the findings "
        "that say 90 %, nine in ten should be true."
    ),
    "declared model": "The rig, mounts and noise that recording.toml describes, before anything was found.",
    "doubt": (
        "A reason not to trust a model that was found: the halves of the recording give different numbers, a number is "
        "implausible, or the declared model predicts better."
    ),
    "effect": "One piece of physics that a simulation may leave out, with its law and numbers: a soft mount, friction.",
    "equivalent": (
        "Another effect that would explain this recording as well. Another motion may tell them apart; for some pairs "
        "none can."
    ),
    "excess": "The power of what differs above the power of sensor noise.",
    "finding": "An effect that the simulation needs to agree with the recording, with its numbers and how sure it is.",
    "free swing": "A stretch in which nothing but gravity and what resists the joint moves the segment.",
    "held out": (
        "Samples that the numbers were not learned from. A model that is right predicts them too; one that has only "
        "learned the noise does not."
    ),
    "hinge axis": "The line that a hinge turns about; +y of both segments, and a direction in each sensor's axes.",
    "immaterial": "Makes nothing that you ask for farther off by the tolerance: real, perhaps, of no consequence.",
    "joint centre": "The point that both segments share: the origin of both segment frames.",
    "knot": "A place in time where the pieces of a fitted motion's curve meet. More knots follow quicker motion.",
    "left-out channel": (
        "A channel is hidden from the fit and predicted from all others. The error is in units of its noise: near 1 "
        "means that the sensors agree."
    ),
    "material": "Makes something that you ask for farther off by the tolerance or more, or by how much is not known.",
    "misfit": (
        "The power of what a fitted motion leaves over the power of sensor noise; 1 is only noise. The motion is free, "
        "so it follows the sensors even where the physics is wrong: how far the simulation is off says more."
    ),
    "mount": "Where a sensor sits on its segment, and how it is turned there.",
    "nat": (
        "The unit of a log-likelihood gain: 1 nat makes the samples 2.7 times as likely, 10 nat 22 000 times. It says "
        "how clear a difference is, not how large."
    ),
    "noise": "What a sensor reads by chance, from sample to sample, while nothing changes; its standard deviation.",
    "prescribed": (
        "MuJoCo is given the motion that the hand made, as it was recovered from the recording. What is sprung, loose, "
        "sliding or late then moves by its law."
    ),
    "reference": "A better measurement of the same motion, such as motion capture. It enters no fit; it only judges.",
    "rejected": "An effect that was tried and not taken: another one explains more, or it does not help enough on "
    "samples that the fit has not seen.",
    "residual": "What is measured less what a model says.",
    "RMS": "Root mean square: the typical size of something that changes, its square averaged over the samples.",
    "rolled out": (
        "MuJoCo starts from the state at the beginning of a free swing, and forces alone decide what follows. Nothing "
        "pulls it back to the recording, so wrong physics shows."
    ),
    "share": (
        "How much of what differs comes back when this finding alone is taken out of the final model. Shares need not "
        "add up to 100 %: two findings that do the same bring back little each."
    ),
    "sign pairing": (
        "Which direction of the hinge axis in the axes of imu1 goes with which in those of imu2. It rests on the data, "
        "on the declared mounts, or on nothing: then it is unknown, and figures are those of the better pairing."
    ),
    "status": (
        "What became of an estimate: converged, not converged, or not identifiable where the recording does not show "
        "it. An estimator from outside may also have crashed, timed out, answered something malformed, or refused."
    ),
    "tolerance": "What still counts as nothing: degrees and millimetres, set with --tolerance.",
    "unknown": "Something that differs and that no effect of the library explains; where and when it acts is told.",
    "unseen": (
        "A direction of a finding's numbers that this recording does not fix. What is plausible there was known "
        "before, so no number is printed for it."
    ),
    "95 % interval": "The true number lies in it in 19 of 20 cases, if the model is right.",
}
"""Term -> what it means."""

FIGURES: dict[str, str] = {
    "deviation": "The angle between estimated and true hinge axis in a sensor's axes: deviation_imu1, deviation_imu2.",
    "rmsae": "The root mean square of the angles by which the hinge axis is off in the axes of both sensors.",
    "maxae": "The larger of the angles by which the hinge axis is off in the axes of both sensors.",
    "best_pairing": (
        "In front of a figure: of the better of both sign pairings. Nothing told the estimator which one it is, so it "
        "claims neither."
    ),
    "error": "The distance between estimated and true joint centre, seen from a sensor: error_imu1.",
    "length_error": "By how much the distance from a sensor to the joint centre is off.",
    "angle_error": "By which angle the direction from a sensor to the joint centre is off.",
    "hinge_angle": "How far the hinge angle is off, RMS over the recording, a constant left out.",
    "hinge_angle_constant": "By which constant the hinge angle is off: where it has its zero.",
    "joint_axis": "By which angle a finding moves the hinge axis in a sensor's axes, one number for each IMU.",
    "joint_centre": "By how much a finding moves the joint centre as seen from a sensor, one number for each IMU.",
    "orientation": "By which angle a finding tilts a segment, RMS over the recording; the heading is left out.",
    "mount_rotation": "By which angle a finding turns a sensor on its segment.",
    "lever": "By how much a finding moves a sensor on its segment.",
}
"""Figure of a result -> what it means."""
