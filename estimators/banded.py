"""Olsson 2020's hinge axis below a frequency that the data choose, where a soft mount is nearly as good as a rigid one.

What a mount on foam or skin adds to a gyroscope lies mostly above what a hand does. Below some frequency the two IMUs
obey the hinge; which one, and how far off the axes may still be, is asked of the recording. docs/band.md.
"""

import math

import numpy as np

from imubench.arrays import Array
from imubench.estimate import Estimate, Status
from imubench.estimators.band_fits import CHI_SQUARE, BandFit, band_fit, gyro_noise, ladder
from imubench.estimators.extent import too_short
from imubench.estimators.olsson2020 import UNKNOWNS, W_ACCEL, W_GYRO
from imubench.estimators.pairing import paired_axes
from imubench.estimators.uncertainty import two_sigma
from imubench.paired import paired
from imubench.recording import Recording

NAME = "olsson2020-banded"
OFFERED = "offered_instead"  # in `details` of an estimate that stands where a guard refuses
BLOCKS = "blocks"  # in `details` of an estimate whose covariance holds for correlated samples
COHERENT = 0.95  # of the motion across the axis, shared by both IMUs: the hinge is obeyed but for a twentieth
KEPT = 0.85  # of that motion's power: a narrower band cuts into the motion itself
OCTAVE = 2.0  # bands this far apart at most are neighbours
NO_DIRECTION = "there is a direction in which the axes can move with no more change of the residuals than they scatter"


def estimate(recording: Recording) -> Estimate:
    """Estimate the hinge axes (2, 3) from what both IMUs read below a band that it chooses.

    The signs go together as `pairing` says; the common one is that which points along +y of the segments as the
    declared mounts have them. `details` holds the band in Hz (0: all samples) and what chose it; `explained` says it in
    words. The covariance is that of blocks of the recording, and of what is left beyond declared noise, were a third of
    it coherent.

    Raises:
        InputError: fewer than two IMUs.
    """
    return answer(recording, *chosen_fit(recording))


def chosen_fit(recording: Recording) -> tuple[BandFit, list[BandFit]]:
    """Return the fit that is taken, and those of all bands, the widest first."""
    samples = paired(recording)
    noise = gyro_noise(recording)
    fits = [band_fit(samples, hz, noise) for hz in ladder(samples)]
    return choose(fits), fits


def answer(recording: Recording, chosen: BandFit, fits: list[BandFit]) -> Estimate:
    """Return the estimate of a fit, one of `fits`."""
    details, samples = details_of(chosen, fits), paired(recording)
    axes, pairing = paired_axes(recording, chosen.axes, samples.accel1, samples.accel2, chosen.signs_shown)
    p = chosen.covariance
    why = too_short(samples.time, UNKNOWNS)
    if why or not chosen.known or p is None:
        why = why or NO_DIRECTION
        return Estimate("joint_axis", NAME, axes, None, why, "not identifiable", details=details, pairing="unknown")
    status: Status = "converged" if chosen.settled else "not converged"
    spread = of_axes(p, chosen, axes)
    return Estimate("joint_axis", NAME, axes, spread, status=status, details=details, pairing=pairing)


def of_axes(p: Array, fit: BandFit, axes: Array) -> Array:
    """Return the covariance (6, 6) of axes (2, 3), those of a fit up to their signs, from that of steps (4, 4)."""
    turned = np.zeros((6, 4))
    for i in range(2):
        sign = 1.0 if axes[i] @ fit.axes[i] > 0 else -1.0
        turned[3 * i : 3 * i + 3, 2 * i : 2 * i + 2] = sign * fit.frames[i, (2, 1)].T
    return turned @ p @ turned.T


def choose(fits: list[BandFit]) -> BandFit:
    """Return the surest of the fits that keep the motion and obey the hinge; the widest band if none shows the axes.

    The motion is what both IMUs share across the axis in the widest band in which they obey the hinge, and a band
    keeps it with KEPT of its power; in planar motion there is none, and every band may do. A band whose axes differ
    from a neighbour's by more than both are unsure of comes after those that agree.
    """
    known = [f for f in fits if f.known and f.covariance is not None]
    if not known:
        return fits[0]
    keeping = known
    if all(f.turning for f in known):
        coherent = [f for f in known if f.shared.coherence >= COHERENT] or known
        keeping = [f for f in coherent if _part(f) >= KEPT * _part(coherent[0])]
    return min(keeping, key=lambda f: (disagreement(f, known) > CHI_SQUARE, f.unsure))


def _part(fit: BandFit) -> float:
    """Return the part of the shared motion of all samples that a band keeps."""
    return fit.shared.both / max(fit.all_shared.both, 1e-300)


def neighbours(fit: BandFit, fits: list[BandFit]) -> list[BandFit]:
    """Return the next band on either side among `fits` that show the axes, if it is within an octave."""
    order = [f for f in fits if f.known and f.covariance is not None]
    at = next((i for i, f in enumerate(order) if f is fit), None)
    if at is None:
        return []
    beside = [*order[max(at - 1, 0) : at], *order[at + 1 : at + 2]]
    return [f for f in beside if f.hz is None or fit.hz is None or abs(math.log(f.hz / fit.hz)) <= math.log(OCTAVE)]


def disagreement(fit: BandFit, fits: list[BandFit]) -> float:
    """Return by how much the axes differ from those of the neighbouring bands: the largest d^T (P + P')^-1 d."""
    worst = 0.0
    for other in neighbours(fit, fits):
        step = fit.step_to(other.axes)
        p, q = fit.covariance, other.covariance
        assert p is not None and q is not None
        worst = max(worst, float(step @ np.linalg.solve(p + q, step)))
    return worst


def details_of(chosen: BandFit, fits: list[BandFit]) -> dict[str, float]:
    """Return what chose the band, as numbers: rad, rad/s, m/s^2, Hz."""
    known = [f for f in fits if f.known and f.covariance is not None]
    s, widest = chosen.solution, fits[0]
    beside = [float(np.abs(chosen.step_to(f.axes)).max()) for f in neighbours(chosen, fits)]
    details = {
        "band": 0.0 if chosen.hz is None else chosen.hz,
        "bands": float(len(fits)),
        "bands_showing_the_axes": float(len(known)),
        "narrowest_band": 0.0 if fits[-1].hz is None else fits[-1].hz,
        "motion_kept": _part(chosen),
        "coherence": chosen.shared.coherence,
        "coherence_of_all": widest.shared.coherence,
        "excess": chosen.excess,  # of the residuals' power that is no noise
        "moved_to_neighbours": max(beside, default=0.0),  # rad
        "disagreement": disagreement(chosen, known),
        BLOCKS: float(chosen.blocks),
        "cost": s.cost,
        "samples": float(chosen.constraints.gyro_count),
        "gyro_residual_std": s.gyro_std / W_GYRO,  # rad/s
        "gyro_residual_std_of_all": widest.solution.gyro_std / W_GYRO,
        "accel_residual_std": s.accel_std / W_ACCEL,  # m/s^2
    }
    p = chosen.covariance
    if p is not None and chosen.random is not None:
        bounds = two_sigma(p)
        details |= {f"uncertainty_{i + 1}": float(bounds[i]) for i in range(2)}  # rad, mu + 2 sigma
        details["by_blocks"] = float(two_sigma(chosen.random).max())
    return details


def explained(estimate: Estimate) -> str:
    """Return in words which band an estimate is from and why; empty for one that is from none."""
    d = estimate.details
    if "filtered_below" in d and BLOCKS not in d:
        return (
            f"both IMUs filtered below {d['filtered_below']:g} Hz, forward and backward; its covariance counts "
            f"{100 * d['independent_samples']:.0f} % of the samples, which white noise leaves independent"
        )
    if BLOCKS not in d:
        return ""
    if not d["bands_showing_the_axes"]:
        return f"none of {d['bands']:.0f} bands shows the axes"
    band = f"below {d['band']:.3g} Hz" if d["band"] else "all frequencies"
    left, of_all = (math.degrees(d[f"gyro_residual_std{which}"]) for which in ("", "_of_all"))
    hinge = (
        f"the IMUs share {100 * d['coherence']:.1f} % of the motion across the axis there "
        f"({100 * d['coherence_of_all']:.0f} % in all samples), and the hinge leaves {left:.2g} deg/s ({of_all:.2g})"
    )
    beside = "agree with it" if d["disagreement"] <= CHI_SQUARE else "do not agree with it"
    sure = ""
    if "uncertainty_1" in d:
        one, two = (math.degrees(d[f"uncertainty_{i}"]) for i in (1, 2))
        alone = math.degrees(d["by_blocks"])
        sure = (
            f"; sure to {one:.2g} and {two:.2g} deg (mu + 2 sigma), to {alone:.2g} by how blocks of the recording "
            f"scatter, the rest because {100 * d['excess']:.0f} % of what is left is not known to be noise"
        )
    instead = ""
    if OFFERED in d:
        what = "the guard has no objection" if estimate.status == "converged" else "the guard still objects"
        instead = f"Algorithm 4 and its guard accept nothing of the stream; offered instead ({what}): "
    showing, moved = d["bands_showing_the_axes"], math.degrees(d["moved_to_neighbours"])
    return (
        f"{instead}{band}, the surest of those that keep the motion, of {showing:.0f} bands that show the axes: "
        f"{hinge}; neighbouring bands {beside}, within {moved:.2g} deg{sure}"
    )
