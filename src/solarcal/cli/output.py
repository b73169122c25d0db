"""How commands print: one JSON document, or text."""

import json
import sys
from typing import Any


def plain(value: Any) -> Any:
    """Numpy scalars and arrays as Python numbers, not-a-number as null, recursively."""
    import numpy as np

    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


def print_json(document: Any) -> None:
    """Exactly one JSON document on stdout."""
    json.dump(plain(document), sys.stdout, indent=2, allow_nan=False)
    sys.stdout.write("\n")


def say(sentence: str) -> None:
    """Progress for a person; stderr, so that stdout stays the result."""
    print(sentence, file=sys.stderr, flush=True)
