"""A motion that is held less smooth, to read numbers off that change how large it is.

A sensor that turns by `twist` q with its skin says (axis + twist) q: of the part along the joint's axis only the
product with the angle q is seen, and the two apart only in second order of q. Noise that the splines follow costs, by
how smooth the motion is held, in proportion to q^2. The least cost is therefore at angles that are too small and twists
that are too large, by many standard deviations on hinges whose angle nobody measured. Held `LOOSE_FIT.motion` times
less tightly the splines follow the noise at next to no cost. What is compared or remains is the tighter fit's: an
effect without a name would hide in the looser motion.
"""

from dataclasses import replace

from imubench.diagnosis.config.noise import LOOSE_FIT, REML
from imubench.diagnosis.config.solve import SOLVER
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.motion_prior import START_SMOOTH
from imubench.diagnosis.problem.rig_kinematics import ATTITUDE, HINGE
from imubench.diagnosis.solve.levenberg_marquardt import converged, solve

TURNING_ROUGHNESS = tuple(f"smooth.{name}" for name in (ATTITUDE, HINGE))


def with_looser_motion(fit: Fit) -> Fit:
    """Return the fit, its turning motion loosened and solved again where an effect's numbers scale it."""
    if fit.model.recording.encoders or not any(h.effect.scales_angle for h in fit.model.hypotheses):
        return fit
    noise = {name: std * (LOOSE_FIT.motion if name in TURNING_ROUGHNESS else 1.0) for name, std in fit.noise.items()}
    return converged(replace(fit, noise=noise))


def rougher_noise(fit: Fit) -> dict[str, float]:
    """Return the noise levels of a fit with its motion, no effect's states, `LOOSE_FIT.freer` times as rough."""
    own = {f"smooth.{name}" for name in START_SMOOTH}
    return {name: std * (LOOSE_FIT.freer if name in own else 1.0) for name, std in fit.noise.items()}


def rougher(fit: Fit) -> Fit:
    """Return the fit solved again with its motion held less smooth."""
    return solve(fit.model, fit.state, rougher_noise(fit), fit.anchor, steps=SOLVER.few_steps)


def at_estimated_roughness(fit: Fit) -> Fit:
    """Return the fit, not solved again, with its motion held as smooth as it was estimated to be."""
    own = {f"smooth.{name}" for name in START_SMOOTH}
    return replace(fit, noise={name: std / (REML.loosened if name in own else 1.0) for name, std in fit.noise.items()})


__all__ = ["at_estimated_roughness", "rougher", "with_looser_motion"]
