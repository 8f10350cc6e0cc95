"""Estimators from outside: found by a file, a module or an installed package's entry point.

An estimator is a function of a `Recording`. It returns an `Estimate`, or a plain array where it says of what: then
`function.quantity` is `joint_axis` or `joint_vector`, and the array (m, 3) holds one row for each of the recording's
IMUs (docs/your-estimator.md). It may say how many IMUs it needs, `function.imus`. An `Estimator` says all that itself.
"""

import inspect
import sys
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from types import ModuleType
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from imubench.entry_points import ESTIMATORS as ESTIMATOR_POINTS
from imubench.entry_points import attribute, imported, offered, origin, said, target, the_one
from imubench.errors import InputError, shown, unknown
from imubench.estimate import QUANTITIES, AnswerError, Estimate, Quantity
from imubench.estimators import ESTIMATORS, Estimator
from imubench.inputs.files import read_bytes, real
from imubench.recording import Recording

FORMS = "or FILE.py:FUNCTION, or PACKAGE.MODULE:FUNCTION"
LOADED = 64  # files whose modules are kept: more than anyone names in one command


class Function(Protocol):
    """An estimator as its author writes it."""

    def __call__(self, recording: Recording, /) -> Estimate | ArrayLike:
        """Return what the recording tells of the joint."""


@dataclass(frozen=True)
class Outside:
    """The `estimate` of an estimator from outside; sent to another process, it is loaded anew there.

    Raises:
        InputError: there is nothing to be loaded.
        AnswerError: the answer is no estimate.
    """

    name: str  # that its answers are given, whatever they call themselves
    target: str  # FILE.py:FUNCTION with an absolute path, or MODULE:FUNCTION
    content: bytes | None = field(default=None, repr=False)  # of the file when it was asked for, whatever becomes of it

    def __call__(self, recording: Recording) -> Estimate:
        """Return its estimate, under the name by which it was asked for."""
        found = self.load()
        if isinstance(found, Estimator):
            return _answer(self.name, found.estimate(recording), found.quantity)
        return _answer(self.name, found(recording), getattr(found, "quantity", None))

    def load(self) -> Callable[[Recording], object] | Estimator:
        """Return the function or the `Estimator` that its name stands for; `InputError` where there is none."""
        if ":" in self.name:  # it says where
            return self._loaded()
        try:
            return self._loaded()
        except InputError as error:
            raise InputError(f"estimator '{self.name}': {error}") from None

    def _loaded(self) -> Callable[[Recording], object] | Estimator:
        module, _, path = self.target.rpartition(":")
        loaded = _from_module(module) if self.content is None else _from_file(Path(module), self.content)
        found = attribute(loaded, path, module, "function")
        if isinstance(found, Estimator):
            return found
        if not callable(found):
            raise InputError(f"{self.target}: expected a function of a recording or an Estimator, got {shown(found)}")
        if not _takes_one(found):
            raise InputError(f"{self.target}: expected a function of one recording, got {inspect.signature(found)}")
        return found


def find_estimator(spec: str) -> Estimator:
    """Return the estimator that a text stands for, loaded.

    Args:
        spec: a name in `ESTIMATORS`, that of an entry point of an installed package, `path/to/file.py:function` or
            `package.module:function`; in place of the function an `Estimator`.

    Returns:
        It, named as it was asked for. Its `estimate` always returns an `Estimate` or raises, and can be sent to another
        process, which loads it anew.

    Raises:
        InputError: a name that is unknown, or something that cannot be loaded: one line says why.
    """
    if spec in ESTIMATORS:
        return ESTIMATORS[spec]
    if ":" in spec:
        module, _, function = spec.rpartition(":")
        if not module or not function:
            raise InputError(f"estimator '{spec}': expected FILE.py:FUNCTION or PACKAGE.MODULE:FUNCTION")
        if module.endswith(".py"):
            return _described(Outside(spec, f"{real(module)}:{function}", read_bytes(Path(module))), f"file {module}")
        return _described(Outside(spec, spec), f"module {module}")
    points = offered(ESTIMATOR_POINTS).get(spec)
    if points is not None:
        return _described(Outside(spec, target(the_one(spec, points, "estimator"))), origin(points))
    if spec.endswith(".py"):
        raise InputError(f"estimator '{spec}': expected a function as well, as in {spec}:estimate")
    raise unknown("estimator", spec, [*known_estimators(), FORMS])


def known_estimators() -> dict[str, Estimator]:
    """Return the estimators that have a name: our own, and the entry points of installed packages.

    No package is imported for that, so one that is broken says so when it is asked for; and an entry point tells
    neither its quantity nor its number of IMUs. A name of our own is never another's.
    """
    outside = {
        name: Estimator(name, origin(points), None, 0, Outside(name, target(points[0])), origin(points))
        for name, points in offered(ESTIMATOR_POINTS).items()
        if name not in ESTIMATORS
    }
    return {**ESTIMATORS, **outside}


def is_outside(estimator: Estimator) -> bool:
    """Return whether an estimator is none of our own."""
    return ESTIMATORS.get(estimator.name) is not estimator


def _described(outside: Outside, source: str) -> Estimator:
    """Return the estimator with what its function or `Estimator` says of itself."""
    found = outside.load()
    if isinstance(found, Estimator):
        return replace(found, name=outside.name, estimate=outside)
    summary = ((inspect.getdoc(found) or "").splitlines() or [""])[0]
    quantity, imus = getattr(found, "quantity", None), getattr(found, "imus", 0)
    if quantity is not None and quantity not in QUANTITIES:
        raise unknown(f"quantity of {outside.name}", quantity, QUANTITIES)
    if not isinstance(imus, int) or imus < 0:
        raise InputError(f"{outside.name}.imus: expected a number of IMUs, got {imus!r}")
    return Estimator(outside.name, summary or source, quantity, imus, outside, source, uncertainty=False)


def _answer(name: str, found: object, quantity: Quantity | None) -> Estimate:
    """Return an answer as an estimate of that name; `AnswerError` where it is none."""
    if isinstance(found, Estimate):
        return replace(found, estimator=name)
    if found is None:
        raise AnswerError(f"{name}: expected an Estimate, got None")
    if quantity is None:
        raise AnswerError(
            f"{name}: expected an Estimate, got {type(found).__name__}; for an array set function.quantity to one of "
            + ", ".join(QUANTITIES)
        )
    try:
        rows = np.atleast_2d(found)  # type: ignore[call-overload]
    except ValueError:
        raise AnswerError(f"{name}: expected an array (m, 3), got {shown(found)}") from None
    return Estimate(quantity, name, rows, None, "not said by the estimator")


def _takes_one(function: Callable[..., object]) -> bool:
    """Return whether a function can be called with a recording alone, as far as it tells."""
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):  # compiled, without a signature
        return True
    try:
        signature.bind(None)
    except TypeError:
        return False
    return True


@lru_cache(LOADED)
def _from_file(path: Path, content: bytes) -> ModuleType:
    """Return the module that a file's content makes; it is run once."""
    _look_in(path.parent)  # for what it imports from beside itself, as Python does for a script
    try:
        code = compile(content, str(path), "exec", dont_inherit=True)
    except SyntaxError as error:
        raise InputError(f"{path}, line {error.lineno}: expected Python, got: {error.msg}") from None
    except ValueError as error:  # a null character
        raise InputError(f"{path}: expected Python, got: {error}") from None
    name = f"{path.stem}_{sha256(str(path).encode() + content).hexdigest()[:12]}"  # apart from any module's
    module = ModuleType(name)
    module.__file__ = str(path)
    sys.modules[name] = module  # dataclasses and pickle look for it there
    try:
        exec(code, vars(module))
    except (Exception, SystemExit) as error:
        del sys.modules[name]
        raise InputError(f"{path}: expected a file that can be imported, got {said(error)}") from None
    return module


def _from_module(name: str) -> ModuleType:
    _look_in(Path.cwd())
    return imported(name)


def _look_in(folder: Path) -> None:
    """Have imports look in a folder as well, last of all, so that it hides nothing."""
    if str(folder) not in sys.path:
        sys.path.append(str(folder))


__all__ = ["Function", "Outside", "find_estimator", "is_outside", "known_estimators"]
