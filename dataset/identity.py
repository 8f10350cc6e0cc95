"""What decides about the bytes of a result: the code that computes them, the versions under it, the machine."""

import hashlib
import platform
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import imubench
from imubench.reproduce.parts import hash_code

if TYPE_CHECKING:
    from imubench.dataset.shard import Job
    from imubench.dataset.spec import Spec

DECIDING = ("numpy", "scipy", "mujoco", "pyarrow")  # packages whose versions decide about bytes
COMPUTING = ("imubench.dataset", "imubench.effects", "imubench.models", "imubench.scenarios", "imubench.sim")


def identity(job: "Job") -> dict[str, Any]:
    """Return what decides about the bytes of a dataset: what was asked, and what computes it."""
    return {
        "spec": hashes(job.content),
        **rigs_of(job.spec),
        "seed": job.seed,
        "count": job.count,
        **computed_by(COMPUTING, DECIDING),
    }


def rigs_of(spec: "Spec") -> dict[str, Any]:
    """Return `rig_files`, what changes with each rig that a package offers; nothing where there is none."""
    return {"rig_files": spec.rig_keys} if spec.rig_keys else {}


def hashes(content: Mapping[str, bytes]) -> dict[str, str]:
    """Return the SHA-256 of each file of a spec by its name."""
    return {name: hashlib.sha256(file).hexdigest() for name, file in sorted(content.items())}


def computed_by(packages: Sequence[str], deciding: Sequence[str]) -> dict[str, Any]:
    """Return `versions`, `code` and `machine`.

    Args:
        packages: those of this project whose code computes; every line of it counts.
        deciding: those of others.
    """
    digest = hashlib.sha256()
    hash_code(digest, packages)
    return {
        "versions": {"imubench": imubench.__version__} | {name: version(name) for name in deciding},
        "code": digest.hexdigest(),
        "machine": f"{platform.system()} {platform.machine()}",
    }
