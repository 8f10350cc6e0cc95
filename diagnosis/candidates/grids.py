"""Effects that are far from linear in one parameter: where to begin with it.

A hum's frequency is read off the residual's spectrum, the moment of a slip off what one at each moment would explain,
a stop's angle off a grid of whole stops, where a spring rests off one of springs. From there the score and the refit go
on.
"""

from dataclasses import replace

import numpy as np
from scipy.ndimage import median_filter

from imubench.diagnosis.candidates.slips import slip
from imubench.diagnosis.config.candidates import HUM_START
from imubench.diagnosis.config.noise import COHERENCE
from imubench.diagnosis.config.samples import TONE
from imubench.diagnosis.criteria.dynamic_score import lawful_score
from imubench.diagnosis.criteria.score_test import Score, score
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.solve.schur import Base
from imubench.diagnosis.solve.threads import one_thread

REST_ANGLES_RAD = np.arange(-1.5, 1.6, 0.25)  # rad, angles of rest of a joint's spring


@one_thread
def placed_at_best_start(base: Base, hypotheses: list[Hypothesis]) -> tuple[list[Hypothesis], list[Score]]:
    """Return hypotheses at their best starts, ready to be scored, and the scores of those that a score cannot judge."""
    fit = base.fit
    out, judged = [], []
    for h in hypotheses:
        effect = h.effect
        if effect.tone:
            if found := hum_frequency(fit, h.at):
                out.append(replace(h, effect=effect.starting(**{effect.tone: found})))
        elif effect.onset and effect.acts("mount"):
            out.append(replace(h, effect=effect.starting(**{effect.onset: slip(base, h)})))
        elif effect.rests_at:
            judged.append(at_best_rest_angle(base, h))
        elif effect.stops_at:
            found_stop = lawful_score(base, h)
            if found_stop is not None:
                starts = {n.split(".", 1)[1]: v for n, v in found_stop.values.items()}
                at = replace(h, effect=effect.starting(**{effect.stops_at: starts[effect.stops_at]}))
                none = np.zeros(0)
                judged.append(Score(at, found_stop.evidence, found_stop.evidence, none, none))
        else:
            out.append(h)
    return out, judged


def at_best_rest_angle(base: Base, h: Hypothesis) -> Score:
    """Return the score of a joint's spring at the best of some angles of rest, from which its refit begins.

    Where the stiffness is zero the angle of rest has no effect on the cost, so a refit gets no slope for it: begun at a
    wrong angle it ends in another minimum, in which the inertia makes up for the spring.
    """
    angles = ({h.effect.rests_at: angle} for angle in REST_ANGLES_RAD)
    each = [replace(h, effect=h.effect.starting(**angle), tag=f"#{i}") for i, angle in enumerate(angles)]
    best = score(base.fit, each, base)[0]
    return replace(best, hypothesis=replace(best.hypothesis, tag=""))


def hum_frequency(fit: Fit, at: str) -> float:
    """Return where a hum begins, in Hz: in the residual, but where the raw samples hum elsewhere.

    A motion with 128 knots a second follows 53 Hz, and what it leaves of that is their image at 75 Hz.
    """
    left, raw = strongest_line(fit, at), fit.model.humming.get(at)
    return raw if left and raw and abs(left - raw) > TONE.neighbours_from_hz else left


def strongest_line(fit: Fit, at: str) -> float:
    """Return the frequency in Hz of the strongest line in an accelerometer's residual; 0 where there is none to see."""
    rows = next((r for r in fit.measured if r.name == f"{at}.accel"), None)
    if rows is None or len(rows.time) < 4 * HUM_START.line_bins:
        return 0.0
    step = float(np.median(np.diff(rows.time)))
    grid = np.arange(rows.time[0], rows.time[-1], step)
    left = np.stack([np.interp(grid, rows.time, x) for x in rows.whitened.T], axis=1)
    frequency = np.fft.rfftfreq(4 * len(grid), step)
    power = np.sum(np.abs(np.fft.rfft(left * np.hanning(len(grid))[:, None], 4 * len(grid), axis=0)) ** 2, axis=1)
    level = median_filter(power, 4 * HUM_START.line_bins, mode="nearest")
    ratio = np.where(frequency > COHERENCE.least_hz, power / np.maximum(level, 1e-12), 0.0)
    return float(frequency[np.argmax(ratio)])


__all__ = ["at_best_rest_angle", "hum_frequency", "placed_at_best_start", "strongest_line"]
