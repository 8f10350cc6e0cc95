"""A recording's folder in format 1: recording.toml and a table of numbers for each sensor."""

import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from imubench.proof.rotation import Array


def write_folder(folder: Path, top: Mapping[str, Any], tables: Mapping[str, list[dict[str, Any]]]) -> None:
    """Write a recording; `folder` must not exist, and is complete or not there.

    top: the keys of recording.toml; tables: by kind (imu, encoder, ...), each with its keys and, where it has a file,
    its name under `file` and its columns under `columns`. `body` and `reference` are single tables.
    """
    folder = Path(folder)
    if folder.exists():
        raise FileExistsError(f"{folder}: expected no such folder, got one")
    partial = folder.with_name(folder.name + ".partial")
    shutil.rmtree(partial, ignore_errors=True)
    try:
        partial.mkdir(parents=True)
        _write(partial, top, tables)
        partial.rename(folder)
    except BaseException:
        shutil.rmtree(partial, ignore_errors=True)
        raise


def _write(folder: Path, top: Mapping[str, Any], tables: Mapping[str, list[dict[str, Any]]]) -> None:
    lines = [f"{key} = {toml(value)}" for key, value in top.items()]
    for kind, entries in tables.items():
        for entry in entries:
            lines += ["", f"[{kind}]" if kind in ("body", "reference") else f"[[{kind}]]"]
            lines += [f"{key} = {toml(value)}" for key, value in entry.items() if key != "columns"]
            if "columns" in entry:
                write_table(folder / entry["file"], entry["columns"])
    (folder / "recording.toml").write_text("\n".join(lines) + "\n")


def write_table(path: Path, columns: Mapping[str, Array]) -> None:
    """Write columns as CSV; a NaN becomes an empty cell."""
    table = np.stack(list(columns.values()), axis=1)
    row = ",".join(["%.9f"] + ["%.9g"] * (table.shape[1] - 1))
    text = "\n".join(row % tuple(values) for values in table.tolist())
    path.write_text(",".join(columns) + "\n" + text.replace("nan", "") + "\n")


def toml(value: Any) -> str:
    """Return a value as TOML has it: text, a number or a list of numbers."""
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, np.ndarray | list | tuple):
        return "[" + ", ".join(toml(x) for x in np.asarray(value).tolist()) + "]"
    if isinstance(value, int) and not isinstance(value, bool):
        return str(value)
    return repr(float(value))
