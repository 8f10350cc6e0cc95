"""Estimators: from a `Recording`, and nothing else, to an `Estimate`. One file a method, one line here."""

from collections.abc import Callable
from dataclasses import dataclass

from imubench.errors import unknown
from imubench.estimate import Estimate, Quantity
from imubench.estimators import (
    accel_svd,
    arve,
    arve_d,
    banded,
    frick_rahmatalla,
    guarded,
    hinge_position,
    mrvs,
    olsson2020,
    plug_and_play,
    qmt_axis,
    seel2012,
    sliding,
    two_imu_centre,
)
from imubench.recording import Recording


@dataclass(frozen=True)
class Estimator:
    """A method by its name, what it answers, and what it needs."""

    name: str
    summary: str  # one line
    quantity: Quantity | None  # None: its first answer says it
    imus: int  # how many it needs; 0: it does not say
    estimate: Callable[[Recording], Estimate]
    source: str
    uncertainty: bool = True  # False: it never says how sure it is, nor that nothing can be seen


ESTIMATORS: dict[str, Estimator] = {
    e.name: e
    for e in (
        Estimator(
            "olsson2020",
            "hinge axis from gyroscopes and accelerometers, both sign pairings tried",
            "joint_axis",
            2,
            olsson2020.estimate,
            "Olsson, Kok, Seel, Halvorsen, Sensors 20 (2020) 3534, Algorithm 1",
        ),
        Estimator(
            "seel2012",
            "hinge axis from gyroscopes alone; the sign pairing is taken from the declared mounts",
            "joint_axis",
            2,
            seel2012.estimate,
            "Seel, Schauer, Raisch, IEEE International Conference on Control Applications (2012) 45-49",
        ),
        Estimator(
            plug_and_play.NAME,
            "hinge axis from a stream, second by second: the first estimate that Algorithm 4 accepts",
            "joint_axis",
            2,
            plug_and_play.estimate,
            "Olsson, Kok, Seel, Halvorsen, Sensors 20 (2020) 3534, Algorithms 1 to 4",
        ),
        Estimator(
            guarded.NAME,
            "the same behind a guard against soft mounts, biases and other errors that are not white noise",
            "joint_axis",
            2,
            guarded.estimate,
            "docs/plug-and-play.md, on Olsson 2020, Algorithms 1 to 4",
        ),
        Estimator(
            banded.NAME,
            "hinge axis below a frequency that the data choose, where soft mounts too obey the hinge",
            "joint_axis",
            2,
            banded.estimate,
            "docs/band.md, on Olsson 2020, Algorithm 1",
        ),
        Estimator(
            accel_svd.NAME,
            "hinge axis from accelerometers alone, by a singular value decomposition",
            "joint_axis",
            2,
            accel_svd.estimate,
            "Olsson, Kok, Seel, Halvorsen, Sensors 20 (2020) 3534, eq. (51)",
        ),
        Estimator(
            qmt_axis.NAME,
            "hinge axis by the package qmt, where it is installed",
            "joint_axis",
            2,
            qmt_axis.estimate,
            "qmt 0.2.4, jointAxisEstHingeOlsson",
            uncertainty=False,
        ),
        Estimator(
            "arve",
            "joint centre, one r a sample: extended Kalman filter on r and the rotation",
            "joint_vector",
            1,
            arve.estimate,
            "Garcia de Villa, Jimenez Martin, Garcia Dominguez (ArVE_d), section III, without r'",
        ),
        Estimator(
            "arve-d",
            "joint centre, one r a sample: the same with the rate of r",
            "joint_vector",
            1,
            arve_d.estimate,
            "Garcia de Villa, Jimenez Martin, Garcia Dominguez (ArVE_d), section III-A",
        ),
        Estimator(
            "mrvs",
            "joint centre, one r for the record, by least squares",
            "joint_vector",
            1,
            mrvs.estimate,
            "Garcia de Villa, Jimenez Martin, Garcia Dominguez (ArVE_d), section III-B",
        ),
        Estimator(
            "mrvs-window",
            "joint centre, one r for each window of 45 samples, by least squares",
            "joint_vector",
            1,
            mrvs.estimate_window,
            "Garcia de Villa, Jimenez Martin, Garcia Dominguez (ArVE_d), section III-B",
        ),
        Estimator(
            frick_rahmatalla.NAME,
            "joint centre, one r a sample: gradient descent from the whole record's least squares",
            "joint_vector",
            1,
            frick_rahmatalla.estimate,
            "Frick, Rahmatalla, Sensors 18 (2018) 1089 and 2563, as Garcia de Villa et al. (ArVE_d) describe it",
            uncertainty=False,
        ),
        Estimator(
            sliding.NAME,
            "joint centre, one r a sample: a constant, oscillations of unknown frequency or a spring, by evidence",
            "joint_vector",
            1,
            sliding.estimate,
            "docs/soft-tissue.md, on the equations of Garcia de Villa et al. with the sensor's own motion in them",
        ),
        Estimator(
            sliding.STREAM,
            "the same on a stream: the last 8 s fitted again and again",
            "joint_vector",
            1,
            sliding.estimate_stream,
            "docs/soft-tissue.md",
        ),
        Estimator(
            "hinge-position",
            "joint centre of a hinge from two IMUs, whatever the joint centre itself does",
            "joint_vector",
            2,
            hinge_position.estimate,
            "Seel, Schauer, Raisch, CCA 2012; Olsson and Halvorsen, Fusion 2017",
        ),
        Estimator(
            two_imu_centre.NAME,
            "joint centre from two IMUs, one r a sample for either, whatever the joint centre itself does",
            "joint_vector",
            2,
            two_imu_centre.estimate,
            "docs/moving-pivot.md, on the constraint of Seel, Schauer, Raisch, CCA 2012",
        ),
    )
}


def find(name: str) -> Estimator:
    """Return the estimator of that name; `InputError` lists the known ones."""
    if name not in ESTIMATORS:
        raise unknown("estimator", name, ESTIMATORS)
    return ESTIMATORS[name]
