"""The reference of thresholds, computed from the config and written as docs/thresholds.md."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import is_dataclass
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType

from imubench.diagnosis import config
from imubench.setting import SOURCES, settings_of


def page() -> str:
    """Return docs/thresholds.md."""
    count = Counter(s.source for module in modules() for _, record in records(module) for s in settings_of(record))
    text = [
        "# Thresholds\n\nEvery number of `diagnosis/config/` that the diagnosis decides by. Written by\n"
        "`python scripts/threshold_table.py`; what the search decides by still stands in its modules.\n",
        "To see what a number does to a recording: `python -m benchmarks.why RECORDING --set RECORD.FIELD=VALUE`\n"
        '([how](rules.md)). A test may replace one by `monkeypatch.setattr(module, "RECORD",\n'
        "dataclasses.replace(RECORD, field=value))`, but for what is read when its module is imported.\n",
        "| source | a value that is | how many |\n|---|---|---:|",
        *(f"| {name} | {means} | {count[name]} |" for name, means in SOURCES.items()),
    ]
    for module in modules():
        text.append(f"\n## {module.__name__.rpartition('.')[2]}\n\n{module.__doc__}")
        for name, record in records(module):
            text.append(f"\n### `{name}`\n\n{type(record).__doc__}\n")
            text.append("| field | value | unit | reason | source |\n|---|---|---|---|---|")
            for s in settings_of(record):
                cells = (f"`{s.name}`", shown(s.value), s.unit, s.reason, s.source)
                text.append(f"| {' | '.join(c.replace('|', chr(92) + '|') for c in cells)} |")
            told = [(n, p) for n, p in vars(type(record)).items() if isinstance(p, property)]
            if told:
                text.append("\nComputed from these:\n")
            text += [f"- `{n}` = {shown(getattr(record, n))}: {p.__doc__}" for n, p in told]
    return "\n".join(text) + "\n"


def modules() -> Iterator[ModuleType]:
    """Yield the modules of the config by name."""
    yield from (import_module(f"{config.__name__}.{m.name}") for m in iter_modules(config.__path__))


def records(module: ModuleType) -> Iterator[tuple[str, object]]:
    """Yield the records of a module of the config with their names, in their order; not those that it imports."""
    own = ((name, x) for name, x in vars(module).items() if is_dataclass(x) and not isinstance(x, type))
    yield from ((name, x) for name, x in own if type(x).__module__ == module.__name__)


def shown(value: object) -> str:
    """Return a value as it is read most easily."""
    if isinstance(value, tuple):
        return ", ".join(shown(v) for v in value)
    return f"{value:.6g}" if isinstance(value, float) else str(value)
