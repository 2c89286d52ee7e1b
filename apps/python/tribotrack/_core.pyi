from collections.abc import Callable
from typing import Any, Optional

__version__: str

def run(
    words: list[str], tell: Callable[[str, int, int], None], frames: Any, bits: Optional[int], input: str
) -> tuple[dict[str, Any], str, list[str]]: ...
