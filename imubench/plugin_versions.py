"""What tells one version of an estimator, or of anything else from outside, from another."""

from collections.abc import Callable
from functools import lru_cache
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, packages_distributions, version
from importlib.util import find_spec
from pathlib import Path

from imubench.estimators import Estimator
from imubench.inputs.files import read_bytes
from imubench.plugins import Outside

OURS = "ours"
"""Of an estimator of our own: told by the hash of this project's code, which whoever asks adds."""


def estimator_version(estimator: Estimator) -> str:
    """Return what changes with an estimator from outside; that of ours is `OURS`.

    Of a file: its content as it was loaded, and every module beside it. Of a module or an entry point: every module
    beside the one that has the function, and the version of its package. What those import from elsewhere is not in it.
    """
    outside = estimator.estimate
    if not isinstance(outside, Outside):
        return OURS
    if outside.content is not None:
        return _hash(outside.content, Path(outside.target.rpartition(":")[0]))
    own = outside.load()
    return module_version(module_of(own.estimate if isinstance(own, Estimator) else own))


def module_version(module: str) -> str:
    """Return what changes with an installed module: the versions of its package, a hash of the modules beside it."""
    package = module.partition(".")[0]
    told = [f"{name} {package_version(name)}" for name in dict.fromkeys(packages_distributions().get(package, []))]
    file = _source(module)
    return ", ".join([*told, _hash(read_bytes(file), file) if file is not None else "no source"])


@lru_cache(64)
def package_version(package: str) -> str:
    """Return the version of an installed package; empty where there is none."""
    try:
        return version(package)
    except PackageNotFoundError:
        return ""


def _hash(content: bytes, file: Path) -> str:
    digest = sha256(content)
    for source in sorted(file.parent.glob("*.py")):
        if source != file:
            digest.update(source.name.encode() + read_bytes(source))
    return digest.hexdigest()


def module_of(function: Callable[..., object]) -> str:
    """Return the module that a function comes from; that of its class where it is an object that can be called."""
    return str(getattr(function, "__module__", None) or type(function).__module__)


def _source(module: str) -> Path | None:
    try:
        found = find_spec(module)
    except (ImportError, ValueError):
        return None
    file = None if found is None or found.origin is None else Path(found.origin)
    return file if file is not None and file.suffix == ".py" else None


__all__ = ["OURS", "estimator_version", "module_of", "module_version", "package_version"]
