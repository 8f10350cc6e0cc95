"""Every reader that a command has: to add one, add it to the list of its module below.

A test fails where the package reads something and no reader covers it.
"""

from importlib import import_module

from fuzz.reader import Reader
from fuzz.readers import check, conversion, dataset, diagnosis, paper, proof, recording, sweeping
from fuzz.seeds.outside import files as outside

# What the commands import when they run, so that no input pays for it.
for name in ("run", *(f"commands.work.{one}" for one in ("check", "diagnose", "generate", "prove", "reproduce"))):
    import_module(f"imubench.{name}")

MODULES = (recording, dataset, diagnosis, conversion, proof, paper, sweeping, check)

READERS: dict[str, Reader] = {reader.name: reader for module in MODULES for reader in module.READERS}
"""The readers by name."""

__all__ = ["READERS", "outside"]
