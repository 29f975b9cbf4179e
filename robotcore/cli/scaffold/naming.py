"""Which names a new project may have: those that shadow nothing, wherever Python or robotcore looks for them."""

from __future__ import annotations

import os
import re
import sys
from importlib.util import find_spec
from keyword import iskeyword
from pathlib import Path

from robotcore.cli.scaffold.template import DRIVER, Template, module_of
from robotcore.errors import UsageError

NAME = re.compile(r"[a-z][a-z0-9]*(?:[-_][a-z0-9]+)*")
"""What packages, modules, and robots in their files may all be called."""


def require_free(template: Template, folder: Path) -> None:
    """Raise UsageError where nothing can be made as ``folder``: its last part is no name, or one that is in use."""
    name = folder.name
    _require_place(folder)
    if not NAME.fullmatch(name):
        raise UsageError(
            f"{name!r} is no name for a project: take lower-case letters, digits, and single - or _ between them, "
            f"beginning with a letter{_such_as(name)}"
        )
    if use := _use_of(template, name):
        raise UsageError(f"{name!r} is {use}. Take another name, {name}-{template.folder} for instance")


def _require_place(folder: Path) -> None:
    """Raise UsageError where there is something of that name, or nowhere to make it."""
    if os.path.lexists(folder):
        raise UsageError(f"{folder} is there already, and stays as it is. Take another name, or move it away")
    if not os.path.isdir(folder.parent):  # noqa: PTH112  it takes any name, however long
        raise UsageError(f"{folder.parent} is no folder, so nothing can be made in it. Make it first")


def _such_as(name: str) -> str:
    """Return the name that was probably meant, in words."""
    meant = re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")
    return f"; {meant} for instance" if NAME.fullmatch(meant) else ""


def _use_of(template: Template, name: str) -> str:
    """Return what a name already stands for, in words; nothing where it is free."""
    module = module_of(name)
    if iskeyword(module):
        return "a word of Python's own"
    if module in template.own_words:
        return "the name of something in every new project"
    if module in sys.stdlib_module_names or find_spec(module):
        return "the name of a Python module in use, for which the new one would be taken"
    return _use_as_backend(name) if template is DRIVER else ""


def _use_as_backend(name: str) -> str:
    """Return what a backend's name already stands for: another one, or a part of every robot's file."""
    from robotcore.description import RobotDescription
    from robotcore.plugins import backend_names

    if name in backend_names():
        return "the name of a backend that is installed"
    return "a part of every robot's file" if name in RobotDescription.model_fields else ""
