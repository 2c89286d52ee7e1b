"""A table of displacements, one row a run, as a campaign."""

from __future__ import annotations

from typing import Any

from tribotrack._errors import InputError

_SECTIONS = {
    "platform": (
        "amplitude_mm",
        "amplitude_y_mm",
        "angular_frequency_rad_s",
        "phase_shift_rad",
        "gravity_m_s2",
        "tilt_x_rad",
        "tilt_y_rad",
    ),
    "fit": ("parameters", "start", "cycles", "fixed", "guess", "prior"),
}
_OTHER_NAMES = {"omega_rad_s": "angular_frequency_rad_s", "epsilon_rad": "phase_shift_rad"}


def is_table(value: Any) -> bool:
    """A pandas DataFrame, or a dict of columns; a campaign's dict has the key `run`."""
    return hasattr(value, "columns") or (isinstance(value, dict) and "phi_rad" in value)


def campaign_of(table: Any, conditions: dict[str, Any]) -> dict[str, Any]:
    """The structure of a campaign file. Columns are the keys of [[run]]; a cell without a value is left out."""
    columns = {str(name): list(table[name]) for name in table.keys()}
    lengths = {name: len(column) for name, column in columns.items()}
    if len(set(lengths.values())) != 1:
        raise InputError(f"table: its columns differ in length: {lengths}")
    rows = zip(*columns.values())
    runs = [{name: _plain(cell) for name, cell in zip(columns, row) if not _is_empty(cell)} for row in rows]
    campaign: dict[str, Any] = {"platform": {}, "fit": {}, "run": runs}
    for name, value in conditions.items():
        name = _OTHER_NAMES.get(name, name)
        quantity = name[:-3] if name.endswith("_sd") else name
        section = next((section for section, names in _SECTIONS.items() if quantity in names), None)
        if section is None:
            known = ", ".join(sum(_SECTIONS.values(), ()))
            raise InputError(f"`{name}` is not a condition of a table's runs; known: {known}")
        campaign[section][name] = value
    return campaign


def _is_empty(cell: Any) -> bool:
    return cell is None or cell != cell


def _plain(cell: Any) -> Any:
    """A whole number for 20.0: pandas makes floats of a column in which a value is missing."""
    cell = cell.item() if hasattr(cell, "item") else cell
    return int(cell) if isinstance(cell, float) and cell.is_integer() else cell
