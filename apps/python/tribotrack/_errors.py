"""What tribotrack raises and warns of."""

from __future__ import annotations


class InputError(ValueError):
    """An input or an option that cannot be used: one sentence with file, place and remedy."""


class MissingFileError(InputError, FileNotFoundError):
    """A file or folder that is not there."""


class AmbiguousPartError(InputError):
    """Several discs may be the part: give one of them as `disc`.

    Attributes:
        frame: the recording's own number of a frame in which all of them are seen.
        discs_px: (x, y, radius) of each, in pixels.
    """

    frame: int = 0
    discs_px: list[tuple[float, float, float]] = []


class QualityWarning(UserWarning):
    """A result that should not be used as it is: the sentence says why, and what to do."""
