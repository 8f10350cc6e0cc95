"""Recordings of others, each with a sealed sidecar that says which disturbance its experimenters documented.

    DIR/NAME/                   the recording in format 1
    DIR/NAME.truth.json         what was done; written by hand, and given to nobody
    DIR/NAME.commitment.json    hashes of the truth and the recording; published
    DIR/NAME.sealed.json        the truth with its salt; kept back until the diagnosis is done

`seal` makes the last two of the first two. A truth:

    {"documented": "foam under IMU 1", "effects": [[{"effect": "rocking_mount", "at": "imu1"}]], "may": []}

Every disturbance is a list of the answers that are accepted for it; none: []. `unknown` stands for physics outside the
table. What `may` be there besides counts neither for nor against a diagnosis. The hash binds the recording as well.
"""

import hashlib
import secrets
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from imubench import format1
from imubench.answers import write_json
from imubench.atomic import MARKER, atomic_file, atomic_files, remove_partial_files, writing
from imubench.diagnosis.result import PLACES, UNKNOWN, Diagnosis
from imubench.diagnosis.solve.subset import cut
from imubench.effects import EFFECTS
from imubench.errors import InputError, shown, unknown
from imubench.inputs.json import load_json
from imubench.inputs.limits import JSON_BYTES
from imubench.lock import locked
from imubench.trials.match import names
from imubench.trials.scoring import verdict_of
from imubench.trials.seal import Truth, commitment, folder_hash

KEYS = ("documented", "effects", "may")


def seal(written: Path) -> str:
    """Write the commitment and the sealed sidecar beside NAME.truth.json and return the commitment."""
    name = written.name.removesuffix(".truth.json")
    if name == written.name:
        raise InputError(f"{written}: expected a file NAME.truth.json beside the folder NAME")
    truth = checked(_json(written), str(written))
    recording = written.parent / name
    format1.read(recording)  # a recording that cannot be read is not sealed
    truth["recording"] = folder_hash(recording)
    salt = secrets.token_hex(32)
    public = {"format": 1, "truth": commitment(truth, salt), "recording": truth["recording"]}
    sealed_file, public_file = (written.with_name(f"{name}.{kind}.json") for kind in ("sealed", "commitment"))
    with writing(written), locked(written.with_name(f".{name}.lock"), written):
        for file in (sealed_file, public_file):
            remove_partial_files(file)
        with atomic_files(sealed_file, public_file) as (
            sealed_part,
            public_part,
        ):  # nothing is published that is not kept
            write_json(sealed_part, {"format": 1, "salt": salt, "truth": truth})
            write_json(public_part, public)
    return str(public["truth"])


def checked(truth: Any, where: str) -> Truth:
    """Return a documented truth; raises `InputError` for a missing key, an unknown effect or no such place."""
    if not isinstance(truth, dict) or set(truth) - {"recording"} != set(KEYS):
        got = ", ".join(sorted(truth)) if isinstance(truth, dict) else type(truth).__name__
        raise InputError(f"{where}: expected the keys {', '.join(KEYS)}, got {got}")
    if not isinstance(truth["effects"], list) or any(not isinstance(e, list) or not e for e in truth["effects"]):
        raise InputError(f"{where}: effects: expected a list of lists of accepted answers, [] for no disturbance")
    if not isinstance(truth["may"], list):
        raise InputError(f"{where}: may: expected a list of answers, got {shown(truth['may'])}")
    for answer in (*truth["may"], *(a for answers in truth["effects"] for a in answers)):
        if not isinstance(answer, dict) or not {"effect", "at"} <= answer.keys() <= {"effect", "at", "parameters"}:
            raise InputError(f"{where}: expected an answer with the keys effect and at, got {shown(answer)}")
        if not isinstance(answer["effect"], str) or answer["effect"] not in (*EFFECTS, UNKNOWN):
            raise unknown("effect", answer["effect"], [*EFFECTS, UNKNOWN])
        if not PLACES.fullmatch(str(answer["at"])):
            raise InputError(f"{where}: at: expected imu1, imu2, joint, body or world, got {shown(answer['at'])}")
    return dict(truth)


def commitments(folder: Path) -> dict[str, dict[str, str]]:
    """Return the public hashes of every sealed recording of a folder by its name."""
    recordings = sorted(p.parent for p in folder.glob("*/recording.toml"))
    if not recordings:
        raise InputError(f"{folder}: expected folders in format 1 with sealed sidecars, got none")
    out = {}
    for recording in recordings:
        public = _json(folder / f"{recording.name}.commitment.json")
        if not isinstance(public, dict) or not {"truth", "recording"} <= public.keys():
            raise InputError(f"{folder / recording.name}.commitment.json: expected the keys truth and recording")
        if folder_hash(recording) != public["recording"]:
            raise InputError(f"{recording}: expected the recording that was sealed, got one with another hash")
        out[recording.name] = {key: str(public[key]) for key in ("truth", "recording")}
    return out


def publish_sealed(folder: Path, kept: Path, seconds: float | None) -> tuple[list[str], str]:
    """Write a neutral copy of every recording and commitments.json into `kept`; return the names and its SHA-256.

    No sealed file is opened. A copy has no name of its own, no comment and no file that format 1 does not know;
    `seconds` cuts it. Where an earlier run has published other hashes, `InputError`.
    """
    cases: dict[str, dict[str, str]] = commitments(folder)
    for name, public in cases.items():
        copy = kept / "cases" / name / "recording"
        if not copy.is_dir():
            recording, reference = format1.read(folder / name)
            if seconds is not None:
                start = min(i.time[0] for i in recording.imus)
                recording = cut(recording, start, start + seconds)
            format1.write_recording(replace(recording, name="recording"), copy, reference)
            (copy / MARKER).unlink()  # no part of a recording
        public["diagnosed"] = folder_hash(copy)
    content = {
        "format": 1,
        "hash": "SHA-256 of the truth (JSON, sorted keys, no spaces) followed by the salt",
        "cases": cases,
    }
    file = kept / "commitments.json"
    if not file.is_file():
        with atomic_file(file) as partial:
            write_json(partial, content)
    elif load_json(file, JSON_BYTES) != content:
        raise InputError(f"{file}: expected the cases that an earlier run sealed, got others; remove {kept}")
    return list(cases), hashlib.sha256(file.read_bytes()).hexdigest()


def opened(folder: Path, cases: list[str]) -> tuple[dict[str, Truth], dict[str, str]]:
    """Return the truths and salts; `InputError` where one is still kept back: finished diagnoses wait for it."""
    truths, salts = {}, {}
    for name in cases:
        file = folder / f"{name}.sealed.json"
        if not file.is_file():
            raise InputError(f"{file}: expected the sealed truth to open, got none; the diagnoses are kept until then")
        content = _json(file)
        if not isinstance(content, dict) or not isinstance(content.get("salt"), str):
            raise InputError(f"{file}: expected the keys salt and truth")
        truths[name], salts[name] = checked(content.get("truth"), str(file)), content["salt"]
        if folder_hash(folder / name) != truths[name].get("recording"):
            raise InputError(f"{folder / name}: expected the recording that was sealed, got one with another hash")
    return truths, salts


def as_scored(truth: Truth, recording: Path) -> Truth:
    """Return a documented truth as `scoring` reads it."""
    found = format1.read(recording)[0]
    rates = [i.rate for i in found.imus]
    answers = [[{"parameters": {}} | a for a in accepted] for accepted in truth["effects"]]
    effects = [accepted[0] | {"inside": accepted[0]["effect"] != UNKNOWN} for accepted in answers]
    outside = any(not e["inside"] for e in effects)
    kind = "outside" if outside else ("none", "one", "several")[min(len(effects), 2)]
    options = {"rate": rates[0], "rate2": rates[-1], "colour": 0.0, "misdeclared": 0.0, "declare_noise": True}
    return {
        "kind": kind,
        "rig": found.rig,
        "observable": True,
        "noise": "real",
        "effects": effects,
        "told": [" or ".join(f"{a['effect']} at {a['at']}" for a in accepted) for accepted in answers],
        "answers": answers,
        "may": truth["may"],
        "freedom": [0 for _ in effects],
        "visibility": [None for _ in effects],
        "bounds": [None for _ in effects],
        "options": options,
    }


def without_known(d: Diagnosis, truth: Mapping[str, Any]) -> Diagnosis:
    """Return the diagnosis without the findings that may be there and nobody asks for."""
    left = tuple(
        f
        for f in d.findings
        if not names(truth["may"], f.effect, f.at) or any(names(a, f.effect, f.at) for a in truth["answers"])
    )
    fewer = len(left) < len(d.findings)
    return replace(d, findings=left, verdict=verdict_of(left, d.noise_unknown) if fewer else d.verdict)


def _json(file: Path) -> Any:
    return load_json(file)
