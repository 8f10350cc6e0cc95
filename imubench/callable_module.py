"""A module that is called as the function it is about.

`imubench.estimate` and `imubench.score` are modules with types that others import, and the functions `ib.estimate` and
`ib.score` of the library. Python gives a package one attribute of a name, and that of an imported module is the module.
"""

import inspect
import sys
from importlib import import_module
from types import ModuleType
from typing import Any


class CallableModule(ModuleType):
    """A module that hands calls on to a function, which is imported when it is called first."""

    _called: tuple[str, str]  # module and name of the function

    def __call__(self, *args: Any, **named: Any) -> Any:
        """Return what the function returns."""
        return self._function()(*args, **named)

    @property
    def __signature__(self) -> inspect.Signature:
        return inspect.signature(self._function())

    def _function(self) -> Any:
        home, name = self._called
        return getattr(import_module(home), name)


def call_as(module: str, home: str, name: str) -> None:
    """Have calls of an imported module go to the function `name` of the module `home`."""
    found = sys.modules[module]
    found.__class__ = CallableModule
    found.__dict__["_called"] = (home, name)
