"""The functions of `import imubench as ib` that have no other home: from a name to a recording, and on to an answer."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from imubench.diagnosis.result import TOLERANCE, Diagnosis
from imubench.recording import Recording
from imubench.reference import Reference
from imubench.sources import Source, read
from imubench.truth import Truth

if TYPE_CHECKING:  # what computes is imported where it is called
    from imubench.checks.check import Checked
    from imubench.sim.imu_model import Declared
    from imubench.sim.imu_profile import ImuProfile
    from imubench.sweeps.cells import Cell


def load(source: Source) -> Recording:
    """Return a recording.

    Args:
        source: a folder in format 1, or `DIR#17`: recording 17 of a dataset (a folder or a URL).

    Raises:
        InputError: no recording there, or one that cannot be what it says.
    """
    return read(source)[0]


def load_reference(source: Source) -> Reference | None:
    """Return the reference of a recording: it judges, and never enters a fit.

    Args:
        source: as of `load`. Of a dataset's recording the reference is its truth.

    Returns:
        None where there is none.

    Raises:
        InputError: as `load`.
    """
    return read(source)[1]


def observe(
    truth: Truth,
    profile: "str | ImuProfile | Mapping[str, str | ImuProfile]" = "xsens_mtw",
    seed: int | np.random.Generator = 0,
    name: str = "simulated",
    declared: "Declared | None" = None,
) -> Recording:
    """Return what IMUs record of a truth.

    Args:
        truth: of `simulate`, or of `imubench.sim.play.play`.
        profile: the name of an IMU (`imubench list`), a profile, or one of these for each sensor by name.
        seed: the same seed gives the same numbers; or a generator.
        name: of the recording.
        declared: what the owner says beside the samples; None: poses of the mounts at the segment's origin, unknown.

    Raises:
        InputError: an unknown profile or sensor.
    """
    from imubench.sim import imu_model

    rng = np.random.default_rng(seed) if isinstance(seed, int) else seed
    if isinstance(profile, Mapping):
        profiles = {sensor: _profile(one) for sensor, one in profile.items()}
        return imu_model.observe(truth, profiles, rng, name, declared)
    return imu_model.observe(truth, _profile(profile), rng, name, declared)


def diagnose(
    recording: Recording | Source,
    reference: Reference | None = None,
    time_limit: float = 600.0,
    tolerance: tuple[float, float] = TOLERANCE,
    baseline: Diagnosis | None = None,
) -> Diagnosis:
    """Return where a recording differs from its model, and what physics the model leaves out.

    Args:
        recording: a recording, or where it is, as of `load`.
        reference: judges what was found, and never enters the fit; of a recording that is loaded here, its own.
        time_limit: s of processor time; then what is known is said.
        tolerance: deg and mm; what moves less is immaterial.
        baseline: a diagnosis of an undisturbed recording of the same sensors; only what is new is found then.

    Raises:
        InputError: no recording there, a rig of one's own, a baseline of other sensors.
    """
    from imubench.diagnosis.budget import Budget
    from imubench.diagnosis.on_disk import diagnosed

    if not isinstance(recording, Recording):
        recording, own = read(recording)
        reference = own if reference is None else reference
    return diagnosed(recording, reference, budget=Budget(time_limit), tolerance=tolerance, baseline=baseline)[0]


def sweep(
    spec: str | Path,
    estimators: Sequence[str],
    out: str | Path,
    seed: int = 0,
    recordings: int | None = None,
    workers: int | None = None,
) -> "list[Cell]":
    """Return the errors of estimators over a grid of one or two numbers; table, page and spec go into a folder.

    Args:
        spec: a TOML file, a dataset's spec with axis tables (docs/your-tissue.md).
        estimators: names, `FILE.py:FUNCTION` or `PACKAGE.MODULE:FUNCTION`.
        out: the folder; the same call goes on with what was interrupted.
        seed: the same seed gives the same recordings.
        recordings: in each cell, instead of the spec's.
        workers: processes; None: one a core.

    Returns:
        Every cell of every estimator.

    Raises:
        InputError: the spec, an estimator or the folder is not what it should be.
    """
    from imubench.sweeps.run import sweep as swept
    from imubench.sweeps.spec import load_sweep

    path = Path(spec)
    return swept(load_sweep(path, recordings), estimators, Path(out), seed, workers, inputs=[path])


def check(
    claims: str | Path,
    estimator: str | None = None,
    against: str | Path | None = None,
    seed: int = 0,
    workers: int = 1,
) -> "list[Checked]":
    """Return what simulated recordings say about claims, each decided by as few as its confidence needs.

    Args:
        claims: a TOML file (docs/your-claim.md).
        estimator: taken whatever the file says.
        against: the claims.json of an earlier check, to be compared with.
        seed: number of the first recording.
        workers: processes; a script that asks for more than one needs `if __name__ == "__main__":`.

    Returns:
        One for each claim, in the order of the file.

    Raises:
        InputError: a file is not what it should be, or there is no such estimator.
    """
    from imubench.checks.baseline import read_baselines
    from imubench.checks.check import check as decided
    from imubench.checks.claim import load_claims
    from imubench.checks.runs import running

    asked = load_claims(Path(claims), estimator)
    earlier = {} if against is None else read_baselines(Path(against), asked)
    with running(workers, None) as runs:
        return decided(asked, runs, seed, earlier)


def _profile(one: "str | ImuProfile") -> "ImuProfile":
    from imubench.sim.profiles import profile as named

    return named(one) if isinstance(one, str) else one
