"""A table of displacements, in memory or in a file, as a campaign."""

from __future__ import annotations

import contextlib
import csv
import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tribotrack._errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterator

_SECTIONS = {
    "platform": (
        "amplitude_mm",
        "amplitude_y_mm",
        "angular_frequency_rad_s",
        "frequency_hz",
        "phase_shift_rad",
        "gravity_m_s2",
        "tilt_x_rad",
        "tilt_y_rad",
    ),
    "fit": ("parameters", "start", "cycles", "fixed", "guess", "prior", "exact"),
    "data": ("alpha_sd_rad", "v_sd_mm_s"),
}
_OTHER_NAMES = {"omega_rad_s": "angular_frequency_rad_s", "epsilon_rad": "phase_shift_rad"}


def is_table(value: Any) -> bool:
    """A pandas DataFrame, a dict of columns (a campaign's has sections), or the path of a table."""
    if isinstance(value, (str, os.PathLike)):
        return Path(value).suffix.lower() in (".csv", ".tsv", ".txt", ".dat")
    return hasattr(value, "columns") or (isinstance(value, dict) and not {"run", "data", "platform", "fit"} & value.keys())


@contextlib.contextmanager
def campaign_of(table: Any, conditions: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """The structure of a campaign file. Columns that are keys of [[run]] become runs, a cell without a value left out; any
    other names go the way of a table in a file."""
    campaign: dict[str, Any] = {"platform": {}, "fit": {}, "data": {}}
    for name, value in conditions.items():
        name = _OTHER_NAMES.get(name, name)
        section = next((section for section, names in _SECTIONS.items() if name in names or name.removesuffix("_sd") in names), None)
        if section is None:
            known = ", ".join(sum(_SECTIONS.values(), ()))
            raise InputError(f"`{name}` is not a condition of a table's runs; known: {known}")
        campaign[section][name] = value
    if isinstance(table, (str, os.PathLike)):
        campaign["data"]["table"] = os.fspath(table)
        yield campaign
        return
    columns = {str(name): list(table[name]) for name in table.keys()}
    lengths = {name: len(column) for name, column in columns.items()}
    if len(set(lengths.values())) != 1:
        raise InputError(f"table: its columns differ in length: {lengths}")
    if {"phi_rad", "alpha_sd_rad", "v_sd_mm_s"} <= columns.keys():
        if not campaign["data"]:
            del campaign["data"]
        rows = zip(*columns.values())
        campaign["run"] = [{name: _plain(cell) for name, cell in zip(columns, row) if not _is_empty(cell)} for row in rows]
        yield campaign
        return
    with tempfile.TemporaryDirectory(prefix="tribotrack-") as folder:
        file = Path(folder, "table.csv")
        with file.open("w", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream)
            writer.writerow(columns)
            writer.writerows([["" if _is_empty(cell) else cell for cell in row] for row in zip(*columns.values())])
        campaign["data"]["table"] = str(file)
        yield campaign


def _is_empty(cell: Any) -> bool:
    return cell is None or cell != cell


def _plain(cell: Any) -> Any:
    """A whole number for 20.0: pandas makes floats of a column in which a value is missing."""
    cell = cell.item() if hasattr(cell, "item") else cell
    return int(cell) if isinstance(cell, float) and cell.is_integer() else cell
