"""Calls of _core: keywords as the flags of a command, the work in a thread of its own, what is refused as exceptions.

While the work goes on without Python's lock, the calling thread waits, hears Ctrl-C and calls `progress`. Where either
raises, the work ends when it next tells of its progress; until then Python itself waits for its thread before it ends.
"""

from __future__ import annotations

import json
import os
import re
import threading
import warnings
from typing import TYPE_CHECKING, Any, Optional

from tribotrack import _core
from tribotrack._errors import InputError, MissingFileError, QualityWarning

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


def is_path(source: Any) -> bool:
    return isinstance(source, str) or hasattr(source, "__fspath__")


def call(
    command: str,
    source: Any,
    options: dict[str, Any],
    progress: Any = None,
    frames: Any = None,
    bits: Optional[int] = None,
    given: Any = None,
) -> dict[str, Any]:
    """The command with these options as its flags. `source`: a path or a name, or None. The arrays and the object that the
    command hands over, in one dict."""
    path = [] if source is None else [os.fsdecode(source)]
    words = [command, *path, *_flags(options)]
    text = _json(given)
    try:
        columns, said, doubts = _released(lambda tell: _core.run(words, tell, frames, bits, text), progress)
    except InputError as error:
        error.args = (in_keywords(str(error)),)
        if path and frames is None and given is None and "%" not in path[0] and not os.path.exists(path[0]):
            raise MissingFileError(*error.args) from None
        raise
    for doubt in doubts:
        warnings.warn(in_keywords(doubt), QualityWarning, stacklevel=3)
    lists = [name for name, column in columns.items() if isinstance(column, list)]
    if lists:
        import numpy as np

        columns.update({name: np.array(columns[name], dtype=str) for name in lists})
    return {**columns, **json.loads(said)}


def _flags(options: dict[str, Any]) -> Iterator[str]:
    """What is None or False is not given."""
    for name, value in options.items():
        flag = "--" + name.replace("_", "-")
        if isinstance(value, dict):  # of axes
            for axis, values in value.items():
                listed = [_text(one) for one in values]
                yield f"{flag}={axis}={','.join(listed)}" if len(listed) != 1 else f"{flag}={axis}={listed[0]}:{listed[0]}:1"
        elif name == "frames" and isinstance(value, (tuple, list)):
            yield f"{flag}={':'.join('' if one is None else _text(one) for one in value)}"
        elif value is not None and value is not False:
            yield flag if value is True else f"{flag}={_text(value)}"


def _text(value: Any) -> str:
    if not isinstance(value, (str, int, float, list, tuple)):
        value = _plain(value)
    if isinstance(value, (list, tuple)):
        return ",".join(_text(one) for one in value)
    return str(int(value)) if isinstance(value, float) and value.is_integer() else str(value)


def in_keywords(sentence: str) -> str:
    """The program names flags, "--disc-diameter-mm 6"; here they are keywords: "disc_diameter_mm=6"."""
    sentence = sentence.removesuffix(" (see --help)")
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


def _json(given: Any) -> str:
    try:
        return json.dumps(_without_none(given), default=_plain, allow_nan=False)
    except ValueError as error:
        raise error if isinstance(error, InputError) else InputError(f"campaign: {error}") from None


def _without_none(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _without_none(entry) for name, entry in value.items() if entry is not None}
    return [_without_none(entry) for entry in value] if isinstance(value, (list, tuple)) else value


def _plain(value: Any) -> Any:
    if hasattr(value, "__fspath__"):
        return os.fsdecode(value)
    for what in ("tolist", "__index__", "__float__"):
        if hasattr(value, what):
            return getattr(value, what)()
    raise InputError(f"{value!r} must be a number, a text, a list or a dict, not {type(value).__name__}")


def _released(work: Callable[[Callable[[str, int, int], None]], Any], progress: Any) -> Any:
    # Waits for an event and not for the thread: a join() that Ctrl-C interrupts takes a running thread for ended
    # (Python 3.11), and the interpreter is then taken down under it.
    told: list[tuple[str, int, int]] = []
    stop = threading.Event()
    over = threading.Event()
    ended: dict[str, Any] = {}

    def tell(stage: str, done: int, total: int) -> None:
        if stop.is_set():
            raise InterruptedError
        told.append((stage, done, total))

    def run() -> None:
        try:
            ended["result"] = work(tell)
        except BaseException as error:
            ended["error"] = error
        over.set()

    threading.Thread(target=run).start()
    try:
        running = True
        while running:
            running = not over.wait(0.05)
            while told:
                if progress is not None:
                    progress(*told[0])
                del told[0]
    except BaseException:
        stop.set()
        over.wait(0.1)
        raise
    if "error" in ended:
        raise ended["error"]
    return ended["result"]
