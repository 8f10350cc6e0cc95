"""Effects added to real recordings, each judged beside the untouched recording's own diagnosis.

A real recording is not clean: its own diagnosis finds something. Only what the recording with the effect has and the
untouched one has not counts as an answer: a finding of its own, or the change of one that both have.
"""

from dataclasses import dataclass, replace
from pathlib import Path

from imubench import format1
from imubench.diagnosis.result import Diagnosis
from imubench.diagnosis.sensor_errors.baseline_change import changed, differ
from imubench.errors import InputError, first_line
from imubench.proof.added import add, addable, copy, options_of, read_header, read_samples
from imubench.proof.options import Effect, stream
from imubench.proof.ranges import STRENGTHS
from imubench.proof.told import plain
from imubench.trials.make import answers, freedom
from imubench.trials.match import sure
from imubench.trials.scoring import verdict_of
from imubench.trials.seal import Truth


@dataclass(frozen=True)
class Added:
    """One case to be made: a recording, and the effect to add; without one it is the untouched recording."""

    recording: Path
    base: str  # name of the case with the untouched recording
    effect: str = ""
    at: str = ""
    seed: int = 0
    strength: str = ""


def questions(folder: Path, seed: int, n: int) -> dict[str, Added]:
    """Return every recording below a folder untouched, and n cases with an effect added to one of them, by name.

    Raises `InputError` where there is none. The recordings take turns; names follow a random order, so that a name
    does not tell which are touched.
    """
    recordings = sorted(p.parent for p in folder.rglob("recording.toml"))
    if not recordings:
        raise InputError(f"{folder}: expected folders in format 1, got none")
    for recording in recordings:
        if not format1.read(recording)[0].imus:  # what is broken is said here, before anything is written
            raise InputError(f"{recording}: expected an IMU to add effects to, got none")
        try:
            header = read_header(recording)
        except ValueError as error:  # which our own reader may take, as a mark of the byte order
            raise InputError(f"{recording}: expected plain TOML to add effects to, got: {first_line(error)}") from None
        for imu in header["imu"]:
            file = recording / imu["file"]
            if file.suffix != ".csv" or not file.is_file():
                raise InputError(f"{recording}: expected CSV files to add effects to, got '{imu['file']}'")
            try:
                read_samples(file)
            except (ValueError, LookupError) as error:
                raise InputError(f"{file}: expected a plain CSV table to add to, got: {first_line(error)}") from None
    rng = stream(seed, "added")
    recordings = recordings[: max(n, 1)]
    names = [f"{i:03d}" for i in rng.permutation(len(recordings) + n)]
    out = {names[i]: Added(r, names[i], seed=int(rng.integers(2**30, 2**31))) for i, r in enumerate(recordings)}
    for k in range(n):
        which = k % len(recordings)
        places = addable(recordings[which])
        effect, at = places[int(rng.integers(len(places)))]
        strength = str(rng.choice(STRENGTHS[1:]))
        out[names[len(recordings) + k]] = Added(
            recordings[which], names[which], effect, at, int(rng.integers(2**30, 2**31)), strength
        )
    return dict(sorted(out.items()))


def made_real(question: Added, folder: Path) -> Truth:
    """Write the recording of a question into the new folder, and return its truth, which no file holds."""
    q = question
    header = read_header(q.recording)
    entry = next((imu for imu in header["imu"] if imu["name"] == q.at), header["imu"][0])
    options = options_of(header, entry, read_samples(q.recording / entry["file"]))
    if q.effect:
        truth = add(q.recording, folder, q.effect, q.at, q.seed, q.strength)
    else:
        copy(q.recording, folder)
        truth = {"format": 1, "seed": q.seed, "rig": header["rig"], "effects": []}
    effects = [Effect(e["effect"], e["at"], e["parameters"]) for e in truth["effects"]]
    told = {"rate": entry["rate"], "rate2": None, "colour": 0.0, "misdeclared": 0.0, "declare_noise": True}
    return truth | {
        "kind": "one" if effects else "untouched",
        "observable": True,
        "strength": q.strength or "untouched",
        "base": q.base,
        "answers": [plain(answers(e, options)) for e in effects],
        "freedom": [freedom(e) for e in effects],
        "visibility": [None for _ in effects],
        "bounds": [None for _ in effects],
        "options": plain(told),
    }


def beside(touched: Diagnosis, untouched: Diagnosis) -> Diagnosis:
    """Return the diagnosis with only those findings that the untouched recording's own does not have.

    Of a finding that both have the change counts, if it is one: errors that add up, a bias for one, say by how much.
    """
    known = {(f.effect, f.at): f for f in sure(untouched.findings)}
    told = [(f, known.get((f.effect, f.at))) for f in touched.findings]
    new = tuple(f if own is None else changed(f, own) for f, own in told if own is None or differ(f, own))
    return replace(touched, findings=new, verdict=verdict_of(new, touched.noise_unknown))
