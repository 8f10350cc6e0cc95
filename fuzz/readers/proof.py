"""What `imubench prove` reads: seals and truths, recordings to add effects to, and what a run keeps until its end."""

from pathlib import Path

from fuzz.mutate import csv, json, toml
from fuzz.reader import Reader
from fuzz.seeds import proofs
from imubench.trials.beside import fit_baselines
from imubench.trials.blind import finished
from imubench.trials.make import refuse_leaks
from imubench.trials.real import made_real, questions
from imubench.trials.seal import check_proof
from imubench.trials.sealed import as_scored, opened, publish_sealed, seal
from imubench.trials.stages import publish

SCORED = {
    **{"kind": "none", "rig": "hinge", "effects": [], "answers": [], "observable": True, "strength": "strong"},
    **{"freedom": [], "visibility": [], "bounds": [], "neighbour": None, "noise": "white"},
    "options": {"rate": 100.0, "rate2": 100.0, "colour": 0.0, "misdeclared": 0.0, "declare_noise": True},
}
"""A truth, as a case is scored with it."""


def checked(f: Path, o: Path) -> object:
    """Check the seals of a finished proof."""
    return check_proof(f)


def check(f: Path, o: Path) -> list[str]:
    """Return the words that check them."""
    return ["prove", "--check", str(f)]


def sealing(f: Path, o: Path) -> object:
    """Seal a documented truth."""
    return seal(f / "monday.truth.json")


def seal_words(f: Path, o: Path) -> list[str]:
    """Return the words that seal it."""
    return ["prove", "--seal", str(f / "monday.truth.json")]


def committed(f: Path, o: Path) -> object:
    """Read the commitments of sealed recordings and copy these."""
    return publish_sealed(f / "lab", o, None)


def published_again(f: Path, o: Path) -> object:
    """The same where an earlier run did so already."""
    return publish_sealed(f / "lab", f / "kept", None)


def made_again(f: Path, o: Path) -> object:
    """Publish the commitments of made cases where an earlier run did so already."""
    return publish({"000": proofs.MADE}, f, 1)


def open_truths(f: Path, o: Path) -> object:
    """Open sealed truths and make them such as a case is scored with."""
    truths, _ = opened(f / "lab", ["monday"])
    return as_scored(truths["monday"], f / "lab" / "monday")


def added(f: Path, o: Path) -> object:
    """Add effects to a recording, and look for what would tell them."""
    for name, question in questions(f / "lab", 0, 2).items():
        refuse_leaks(o / name / "recording", made_real(question, o / name / "recording"))
    return True


def went(f: Path, o: Path) -> object:
    """Read how a diagnosis of an earlier run went."""
    return finished(f / "case")


def beside(f: Path, o: Path) -> object:
    """Score the baselines of an earlier run."""
    return fit_baselines({"case": SCORED}, f, f, 1, lambda *seen: None)


READERS = (
    Reader("proof-commitments", "commitments.json", proofs.finished, json.mutate, checked, check),
    Reader("proof-truths", "truths.json", proofs.finished, json.mutate, checked, check),
    Reader(
        *("seal-truth", "monday.truth.json", proofs.to_seal, json.mutate, sealing, seal_words), writes="when accepted"
    ),
    Reader("real-commitment", "lab/monday.commitment.json", proofs.sealed, json.mutate, committed),
    Reader("real-sealed", "lab/monday.sealed.json", proofs.sealed, json.mutate, open_truths),
    Reader("real-kept", "kept/commitments.json", proofs.sealed, json.mutate, published_again),
    Reader("proof-kept", "commitments.json", proofs.published, json.mutate, made_again),
    Reader("added-toml", "lab/walk/recording.toml", proofs.added, toml.mutate, added),
    Reader("added-csv", "lab/walk/imu2.csv", proofs.added, csv.mutate, added),
    Reader("proof-run-json", "case/run.json", proofs.run, json.mutate, went),
    Reader("proof-baseline", "case/L1.json", proofs.baselines, json.mutate, beside),
    Reader("proof-no-baseline", "case/error.json", proofs.no_baselines, json.mutate, beside),
)
