"""Fits that are asked for more than once in a diagnosis: solved once.

A search looks one effect ahead, and tries that effect again once it has decided; what a model is without one of its
effects is asked by the terms without a name, by what the effect moves and by the simulations.
"""

from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import fields, is_dataclass
from functools import wraps
from hashlib import blake2b
from inspect import signature
from threading import Lock
from typing import ParamSpec, Protocol, TypeVar, cast
from weakref import WeakKeyDictionary

import numpy as np

from imubench.recording import Recording


class Solved(Protocol):
    """A fit, as far as keeping it goes."""

    @property
    def knots(self) -> int:
        """How many knots its splines have: what it holds grows with them."""


P = ParamSpec("P")
F = TypeVar("F", bound=Solved)
K = TypeVar("K", bound=Solved)
V = TypeVar("V")


class Memory:
    """The last fits by what they were asked for with, of no more than `most` knots together."""

    def __init__(self, most: int) -> None:
        self.most = most
        self._fits: OrderedDict[Hashable, Solved] = OrderedDict()
        self._lock = Lock()

    def get(self, key: Hashable) -> Solved | None:
        """Return the fit that was asked for so, if it is still kept."""
        with self._lock:
            if key in self._fits:
                self._fits.move_to_end(key)
            return self._fits.get(key)

    def put(self, key: Hashable, fit: Solved) -> None:
        """Keep a fit, and of all only the last ones."""
        with self._lock:
            self._fits[key] = fit
            while self._fits and sum(f.knots for f in self._fits.values()) > self.most:
                self._fits.popitem(last=False)


_memory: ContextVar[Memory | None] = ContextVar("_memory", default=None)


@contextmanager
def remembering(most: int = 10_000) -> Iterator[None]:
    """Keep fits, of no more than `most` knots together (some 50 MB), for the block it opens."""
    token = _memory.set(Memory(most))
    try:
        yield
    finally:
        _memory.reset(token)


def remembered(function: Callable[P, F]) -> Callable[P, F]:
    """Return the function, a fit that it was asked for before in the same block of `remembering` kept."""
    named = signature(function)

    @wraps(function)
    def known(*args: P.args, **kwargs: P.kwargs) -> F:
        memory = _memory.get()
        if memory is None:
            return function(*args, **kwargs)
        asked = named.bind(*args, **kwargs)
        asked.apply_defaults()
        key = (function, content(asked.arguments))
        if (kept := memory.get(key)) is not None:
            return cast(F, kept)
        fit = function(*args, **kwargs)
        memory.put(key, fit)
        return fit

    return known


def kept_with(function: Callable[[K], V]) -> Callable[[K], V]:
    """Return the function, what it says of a fit kept as long as the fit itself; nothing of it may hold the fit."""
    said: WeakKeyDictionary[K, V] = WeakKeyDictionary()

    @wraps(function)
    def known(fit: K) -> V:
        if fit not in said:
            said[fit] = function(fit)
        return said[fit]

    return known


def content(value: object) -> Hashable:
    """Return what tells one argument of a fit from another; effects and recordings count as the objects they are."""
    if isinstance(value, np.ndarray):
        return value.shape, blake2b(np.ascontiguousarray(value).tobytes(), digest_size=16).digest()
    if isinstance(value, Mapping):
        return tuple((k, content(v)) for k, v in value.items())
    if isinstance(value, (tuple, list)):
        return tuple(content(v) for v in value)
    if isinstance(value, (set, frozenset)):
        return frozenset(value)
    if isinstance(value, Recording):
        return id(value)
    if is_dataclass(value) and not isinstance(value, type):
        return type(value), *(content(getattr(value, f.name)) for f in fields(value))
    assert isinstance(value, Hashable)
    return value


__all__ = ["kept_with", "remembered", "remembering"]
