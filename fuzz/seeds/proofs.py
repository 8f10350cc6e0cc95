"""What `imubench prove` reads: sealed truths, a finished proof, what a run keeps until its end."""

import json
from dataclasses import asdict
from pathlib import Path

from fuzz.seeds import laid_out, models, recordings
from imubench.answers import write_json
from imubench.diagnosis.result_file import as_dict
from imubench.trials.blind import Run
from imubench.trials.seal import commitment, folder_hash, salt_of
from imubench.trials.sealed import publish_sealed
from imubench.trials.stages import publish

MADE = {"kind": "none", "rig": "hinge", "effects": [], "seed": 1}
TRUTH = {
    "documented": "foam under the second IMU",
    "effects": [[{"effect": "rocking_mount", "at": "imu2"}, {"effect": "soft_mount", "at": "imu2", "parameters": {}}]],
    "may": [{"effect": "accel_bias", "at": "imu1"}],
}


@laid_out
def finished(folder: Path) -> None:
    """Write the seals and the truths of a finished proof."""
    names = ("000", "001")
    cases = {name: {"truth": commitment(MADE, salt_of(1, name)), "recording": "00"} for name in names}
    write_json(folder / "commitments.json", {"format": 1, "hash": "SHA-256", "cases": cases})
    write_json(folder / "truths.json", {name: {"salt": salt_of(1, name), "truth": MADE} for name in names})


@laid_out
def to_seal(folder: Path) -> None:
    """Write a recording, and beside it what was done, to be sealed."""
    recordings.write(folder / "monday")
    (folder / "monday.truth.json").write_text(json.dumps(TRUTH), encoding="utf-8")


@laid_out
def sealed(folder: Path) -> None:
    """Write a sealed recording below lab/, and what a run of a proof keeps of it below kept/; the salt is no secret."""
    lab = folder / "lab"
    recordings.write(lab / "monday")
    truth, salt = TRUTH | {"recording": folder_hash(lab / "monday")}, "00" * 32
    public = {"format": 1, "truth": commitment(truth, salt), "recording": truth["recording"]}
    write_json(lab / "monday.commitment.json", public)
    write_json(lab / "monday.sealed.json", {"format": 1, "salt": salt, "truth": truth})
    publish_sealed(lab, folder / "kept", None)


@laid_out
def published(folder: Path) -> None:
    """Write a case of a proof and the commitments that a run keeps of it."""
    recordings.write(folder / "cases" / "000" / "recording")
    publish({"000": MADE}, folder, 1)


@laid_out
def added(folder: Path) -> None:
    """Write a folder with a recording that effects are to be added to."""
    recordings.write(folder / "lab" / "walk")


@laid_out
def run(folder: Path) -> None:
    """Write how a diagnosis went, which a proof keeps until its end."""
    (folder / "case").mkdir()
    write_json(folder / "case" / "run.json", asdict(Run(1.5, 0, "", ("read /etc",))))


@laid_out
def baselines(folder: Path) -> None:
    """Write what a proof keeps of the baselines on one case."""
    (folder / "case").mkdir()
    for name in ("L1", "oracle"):
        write_json(folder / "case" / f"{name}.json", as_dict(models.diagnosis(models.BIASED)))


@laid_out
def no_baselines(folder: Path) -> None:
    """Write why the baselines of a case said nothing."""
    (folder / "case").mkdir()
    write_json(folder / "case" / "error.json", "ValueError: no fit")
