"""Calls of _core: keywords as JSON, the work in a thread of its own, what is refused as exceptions.

While the work goes on without Python's lock, the calling thread waits, hears Ctrl-C and calls `progress`. Where either
raises, the work ends when it next tells of its progress; until then Python itself waits for its thread before it ends.
"""

from __future__ import annotations

import json
import os
import re
import threading
import warnings
from typing import TYPE_CHECKING, Any

from tribotrack._errors import InputError, MissingFileError, QualityWarning

if TYPE_CHECKING:
    from collections.abc import Callable


def is_path(source: Any) -> bool:
    return isinstance(source, str) or hasattr(source, "__fspath__")


def call(function: Callable[..., Any], source: Any, options: dict[str, Any], progress: Any = None, *more: Any) -> dict[str, Any]:
    """`source`: a path, or None. The arrays and the object that the function returns, in one dict."""
    path = "" if source is None else os.fsdecode(source)
    text = _json(options)
    try:
        columns, said, doubts = _released(lambda tell: function(path, text, tell, *more), progress)
    except InputError as error:
        error.args = (in_keywords(str(error)),)
        if path and "%" not in path and not os.path.exists(path):
            raise MissingFileError(*error.args) from None
        raise
    for doubt in doubts:
        warnings.warn(in_keywords(doubt), QualityWarning, stacklevel=3)
    lists = [name for name, column in columns.items() if isinstance(column, list)]
    if lists:
        import numpy as np

        columns.update({name: np.array(columns[name], dtype=str) for name in lists})
    return {**columns, **json.loads(said)}


def in_keywords(sentence: str) -> str:
    """The program names flags, "--disc-diameter-mm 6"; here they are keywords: "disc_diameter_mm=6"."""
    return re.sub(
        r"(?:^|(?<=[ (`]))--([a-z][a-z0-9-]*)( (?=[0-9]))?",
        lambda flag: flag[1].replace("-", "_") + ("=" if flag[2] else ""),
        sentence,
    )


def csv_of(table: Any) -> str:
    """The text of a track's CSV with these columns: arrays, lists or a pandas DataFrame's; `meta` left out."""
    columns = {name: list(table[name]) for name in table.keys() if isinstance(name, str) and name != "meta"}
    for name, column in columns.items():
        first, rows = next(iter(columns.items()))
        if len(column) != len(rows):
            raise InputError(f"track: the column {name} has {len(column)} rows, {first} has {len(rows)}")
        if name != "status":
            try:
                columns[name] = ["" if cell is None or cell != cell else repr(float(cell)).removesuffix(".0") for cell in column]
            except (TypeError, ValueError):
                raise InputError(f"track: the column {name} must be a row of numbers") from None
    return "\n".join(",".join(map(str, row)) for row in [columns, *zip(*columns.values())]) + "\n"


def _json(options: dict[str, Any]) -> str:
    for name, value in options.items():
        try:
            json.dumps(value, default=_plain, allow_nan=False)
        except ValueError as error:
            if isinstance(error, InputError):
                raise
            raise InputError(f"{name} must be a finite number, not {value!r}" if isinstance(value, float) else f"{name}: {error}") from None
    return json.dumps(options, default=_plain)


def _plain(value: Any) -> Any:
    if hasattr(value, "__fspath__"):
        return os.fsdecode(value)
    for what in ("tolist", "__index__", "__float__"):
        if hasattr(value, what):
            return getattr(value, what)()
    raise InputError(f"{value!r} must be a number, a text, a list or a dict, not {type(value).__name__}")


def _released(work: Callable[[Callable[[str, int, int], None]], Any], progress: Any) -> Any:
    told: list[tuple[str, int, int]] = []
    stop = threading.Event()
    ended: dict[str, Any] = {}

    def tell(stage: str, done: int, total: int) -> None:
        if stop.is_set():
            raise InterruptedError
        told[:] = [(stage, done, total)]

    def run() -> None:
        try:
            ended["result"] = work(tell)
        except BaseException as error:
            ended["error"] = error

    thread = threading.Thread(target=run)
    thread.start()
    try:
        while thread.is_alive():
            thread.join(0.05)
            if told and progress is not None:
                progress(*told.pop())
    except BaseException:
        stop.set()
        thread.join(0.1)
        raise
    if "error" in ended:
        raise ended["error"]
    return ended["result"]
