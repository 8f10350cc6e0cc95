"""The effects that this installation knows: our own, those that installed packages offer, those added by hand.

A package offers effects by an entry point of the group `imubench.effects`, which leads to an `Effect` or to several of
them, the variants of a law for one. They are looked for where the library is first asked. What cannot be imported, is
no effect, or has a name that is taken is left out with a warning: it may not stop the diagnosis of a stranger to it.
"""

import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cached_property
from typing import overload

from imubench.effects.effect import Effect
from imubench.effects.traits import NO_TRAITS, NUMBERS_OF_FAULT, Traits
from imubench.entry_points import EFFECTS as GROUP
from imubench.entry_points import attribute, imported, offered, origin, target, the_one
from imubench.errors import InputError

PLACES = ("imu", "joint", "body", "world")
KIND = "effect"
NAMING = ("scale", "late_by", "tone", "onset", "holds_by", "rests_at", "stops_at")
"""The traits that name one of an effect's parameters."""


class Library(Sequence[Effect]):
    """Every effect with every choice of its settings, in the order in which a diagnosis tries them."""

    def __init__(self, own: Iterable[Effect]) -> None:
        """Take our own effects."""
        self.own = tuple(own)
        self._gone: set[str] = set()
        self._added: list[Effect] = []

    @cached_property
    def _every(self) -> tuple[Effect, ...]:
        taken = {e.name for e in self.own}
        return tuple(e for e in (*self.own, *from_packages(taken), *self._added) if e.name not in self._gone)

    @cached_property
    def by_name(self) -> dict[str, Effect]:
        """The effects by name, each with the first of its settings."""
        return dict(reversed({e.name: e for e in reversed(self._every)}.items()))

    def add(self, *effects: Effect) -> None:
        """Take further effects into the library of this process.

        Args:
            effects: each with a name that no effect of the library has, but for the variants of one law.

        Raises:
            InputError: one is no effect, or its name is taken.
        """
        checked(effects, "effects", {e.name for e in self._every})
        self._added += effects
        self._forget()

    def take_out(self, name: str) -> None:
        """Take every variant of an effect out of the library of this process."""
        self._gone.add(name)
        self._forget()

    def put_back(self, name: str) -> None:
        """Have an effect of our own or of a package again that was taken out; forget one that was added."""
        self._gone.discard(name)
        self._added = [e for e in self._added if e.name != name]
        self._forget()

    @contextmanager
    def ours_alone(self) -> Iterator[None]:
        """Have our own effects alone in the library, for the block it opens: our pages are not about a package's."""
        others = {e.name for e in self._every} - {e.name for e in self.own}
        before = set(self._gone)
        self._gone |= others
        self._forget()
        try:
            yield
        finally:
            self._gone = before
            self._forget()

    def look_again(self) -> None:
        """Look anew for what packages offer: one was installed since, or Python looks into other folders."""
        self._forget()

    def _forget(self) -> None:
        for key in ("_every", "by_name"):
            self.__dict__.pop(key, None)

    @overload
    def __getitem__(self, index: int) -> Effect: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[Effect, ...]: ...

    def __getitem__(self, index: int | slice) -> Effect | tuple[Effect, ...]:
        return self._every[index]

    def __len__(self) -> int:
        return len(self._every)

    def __iter__(self) -> Iterator[Effect]:
        return iter(self._every)


class ByName(Mapping[str, Effect]):
    """A library's effects by name, each with the first of its settings."""

    def __init__(self, library: Library) -> None:
        """Take the library."""
        self._library = library

    def __getitem__(self, name: str) -> Effect:
        return self._library.by_name[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._library.by_name)

    def __len__(self) -> int:
        return len(self._library.by_name)

    def first(self, asked: Callable[[Effect], object]) -> Effect | None:
        """Return the first effect of which something is so; None where it is of none."""
        return next((e for e in self.values() if asked(e)), None)

    def name_of(self, asked: Callable[[Effect], object]) -> str:
        """Return the name of the first effect of which something is so, taken out of the library or not.

        What shows in the raw samples has that name, even where no fit may have the effect.

        Raises:
            KeyError: it is so of none.
        """
        return self.whichever(asked).name

    def whichever(self, asked: Callable[[Effect], object]) -> Effect:
        """Return the first effect of which something is so, taken out of the library or not.

        Raises:
            KeyError: it is so of none.
        """
        for effect in (*self._library.own, *self.values()):
            if asked(effect):
                return effect
        raise KeyError("no effect of the library is of that kind")

    def traits(self, name: str) -> Traits:
        """Return what is declared of the effect of a name; of what is none, that nothing is."""
        return self._library.by_name.get(name, NO_TRAITS)


def from_packages(taken: Iterable[str]) -> tuple[Effect, ...]:
    """Return the effects that installed packages offer under names that are not taken.

    What is broken is left out, with a warning that says of whom it is.
    """
    found: list[Effect] = []
    for name, points in offered(GROUP).items():
        try:
            module, _, path = target(the_one(name, points, KIND)).rpartition(":")
            got = attribute(imported(module), path, module, KIND)
            several = (got,) if isinstance(got, Effect) else got
            if not isinstance(several, Sequence) or not several:
                raise InputError(f"expected an Effect or some in {module}:{path}, got {type(got).__name__}")
            found += checked(several, f"{module}:{path}", {*taken, *(e.name for e in found)})
        except InputError as error:
            warnings.warn(f"effect '{name}' {origin(points)} is left out: {error}", stacklevel=2)
    return tuple(found)


def checked(effects: Sequence[object], where: str, taken: Iterable[str]) -> tuple[Effect, ...]:
    """Return effects from outside; `InputError` where one is no effect, or its name is another's.

    Args:
        effects: an effect and its variants, or several effects.
        where: that they come from, for the message.
        taken: names of other effects.
    """
    out: list[Effect] = []
    known = set(taken)
    for effect in effects:
        if not isinstance(effect, Effect):
            raise InputError(f"{where}: expected an Effect, got {type(effect).__name__}")
        for key in ("name", "place", "law"):
            if not isinstance(getattr(effect, key, None), str):
                raise InputError(f"{where}: expected a text as {key} of {type(effect).__name__}, got none")
        if effect.place not in PLACES:
            raise InputError(f"{where}: expected {', '.join(PLACES)} as place of {effect.name}, got '{effect.place}'")
        if not effect.name.isidentifier():
            raise InputError(f"{where}: expected a name of letters, digits and _, got '{effect.name}'")
        if lacking := numbers_lacking(effect):
            raise InputError(f"{where}: expected the numbers {', '.join(lacking)} of {effect.name}, got none")
        if effect.name in known:
            raise InputError(f"{where}: expected a name that no other effect has, got '{effect.name}'")
        out.append(effect)
    if len({(e.name, e.variant) for e in out}) < len(out):
        raise InputError(f"{where}: expected variants that differ in `variant`, got one twice")
    return tuple(out)


def numbers_lacking(effect: Effect) -> tuple[str, ...]:
    """Return the numbers that an effect must have by its traits, and has not."""
    needed = {name for key in NAMING if (name := getattr(effect, key))}
    needed |= {"rotation", "translation"} if effect.misplaces else set()
    needed |= {"amplitude"} if effect.tone else set()
    needed |= NUMBERS_OF_FAULT.get(effect.fault, set()) if effect.fault is not None else set()
    return tuple(sorted(needed - {p.name for p in effect.parameters} - {f.name for f in effect.found}))


__all__ = ["ByName", "Library", "numbers_lacking"]
