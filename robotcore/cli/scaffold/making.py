"""Making a project from its template: whole, or not at all."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from robotcore.cli.scaffold.naming import require_free
from robotcore.errors import UsageError

if TYPE_CHECKING:
    import sys

    from robotcore.cli.scaffold.template import Template

    if sys.version_info >= (3, 11):
        from importlib.resources.abc import Traversable
    else:
        from importlib.abc import Traversable


def make(template: Template, folder: Path) -> None:
    """Make the template's project as ``folder``, named after it.

    It is written in a folder beside, and renamed when it is whole: whatever ends this, it is whole or it is not there.
    Raises UsageError where the name cannot be, or the files cannot be written.
    """
    require_free(template, folder)
    try:
        with TemporaryDirectory(prefix=".new-", dir=folder.parent) as beside:
            whole = Path(beside, folder.name)
            _copy(template, template.root, whole, folder.name)
            whole.rename(folder)
    except OSError as error:
        raise UsageError(
            f"{folder} cannot be made: {error.strerror}. Nothing is left of it; make room, or take another folder"
        ) from error


def _copy(template: Template, source: Traversable, target: Path, name: str) -> None:
    target.mkdir()
    for each in template.entries(source):
        made = target / template.named(each.name, name)
        if each.is_dir():
            _copy(template, each, made, name)
        else:
            made.write_text(template.named(each.read_text(encoding="utf-8"), name), encoding="utf-8")
