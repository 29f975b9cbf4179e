"""The extras of robotcore: libraries that only some features need."""

from __future__ import annotations

from importlib.util import find_spec

from robotcore.errors import BackendMissingError

MODULES = {
    "record": ("foxglove", "mcap"),
    "view": ("starlette", "uvicorn", "websockets", "segno"),
    "sweep": ("jinja2",),
    "cluster": ("distributed",),
}
"""The modules of each extra that a feature checks before it begins."""


def require_extra(extra: str, feature: str) -> None:
    """Raise BackendMissingError if a module of an extra is not installed.

    extra: a key of `MODULES`.
    feature: the subject of the message, such as ``"the live page"``.
    """
    missing = [name for name in MODULES[extra] if find_spec(name) is None]
    if missing:
        *others, last = missing
        modules = f"{', '.join(others)} and {last}" if others else last
        raise BackendMissingError(
            f"{feature} needs {modules}. Install the extra {extra!r}: pip install 'robotcore[{extra}]'",
            kind="library-missing",
            extra=extra,
            modules=missing,
        )
