"""``robotcore backends``: what a robot can run on, and what is installed of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.output import as_json, write_json, write_table

if TYPE_CHECKING:
    from rich.console import RenderableType


@click.command("backends")
@as_json
def command(*, as_json: bool) -> None:
    """List the backends, and which are installed."""
    from robotcore.plugins import backend_names

    backends = [_backend_row(name) for name in backend_names()]
    if as_json:
        write_json(backends)
    else:
        write_table(("backend", "", "capabilities", "what it is"), map(_row, backends))


def _backend_row(name: str) -> dict[str, Any]:
    from robotcore.errors import BackendMissingError
    from robotcore.hal.backend import load_backend

    try:
        backend = load_backend(name)
    except BackendMissingError as error:
        return {"name": name, "installed": False, "summary": "", "vouches_for": [], "remedy": str(error)}
    return {
        "name": name,
        "installed": backend.is_installed,
        "summary": backend.summary,
        "vouches_for": sorted(capability.value for capability in backend.capabilities),
        "remedy": None if backend.is_installed else backend.remedy,
    }


def _row(backend: dict[str, Any]) -> tuple[RenderableType, ...]:
    from rich.text import Text

    status = Text("installed", "green") if backend["installed"] else Text("missing", "red")
    what = "\n".join(filter(None, (backend["summary"], backend["remedy"])))
    return backend["name"], status, ", ".join(backend["vouches_for"]), what
