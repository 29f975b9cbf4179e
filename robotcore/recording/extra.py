"""The libraries that only recordings need: foxglove-sdk writes them, mcap reads them."""

from __future__ import annotations

from importlib.util import find_spec

from robotcore.errors import BackendMissingError

REMEDY = "pip install 'robotcore[record]'"


def require_extra() -> None:
    """Raise BackendMissingError, with the remedy, where a library is missing; none is imported for it."""
    if missing := [name for name in ("foxglove", "mcap") if find_spec(name) is None]:
        raise BackendMissingError(f"recordings need {' and '.join(missing)}. {REMEDY}")
