"""New projects and driver packages from templates: free names, and a copy that is whole or not made."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from importlib import resources
from importlib.util import find_spec
from keyword import iskeyword
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from robotcore.errors import UsageError

if TYPE_CHECKING:
    if sys.version_info >= (3, 11):
        from importlib.resources.abc import Traversable
    else:
        from importlib.abc import Traversable


CACHES = ("__pycache__", "_cache")
"""How folders end that installers, test runners and linters leave in a template."""


@dataclass(frozen=True)
class Template:
    """A project in ``templates/FOLDER`` that is to be had under another name than its own, ``stand_in``.

    It works, and is checked, as it stands. Wherever it spells its name, in a text or as a file's, the new one is put:
    ``my-robot`` as it is typed, ``my_robot`` as a module, ``MyRobot`` as a class. ``first_steps`` are the commands to
    type in it first.
    """

    folder: str
    stand_in: str
    first_steps: tuple[str, ...]

    @cached_property
    def root(self) -> Traversable:
        """The folder that is copied."""
        return resources.files("robotcore.cli.scaffold").joinpath("templates", self.folder)

    def named(self, text: str, name: str) -> str:
        """Return a text of the template with the new name in the place of its own."""
        words = dict(zip(_spelt(self.stand_in), _spelt(name), strict=True))
        return re.sub("|".join(words), lambda found: words[found[0]], text)

    def entries(self, folder: Traversable) -> Iterator[Traversable]:
        """Yield what is to be copied of a folder of the template."""
        return (each for each in folder.iterdir() if not each.name.endswith(CACHES))

    @property
    def own_words(self) -> set[str]:
        """What its files and folders are called besides; a project of such a name would have two of one name."""
        stems = (each.name.partition(".")[0] for each in self.entries(self.root))
        return {stem for stem in stems if stem not in _spelt(self.stand_in)}


PROJECT = Template(
    "project",
    "my-robot",
    (
        "robotcore run search.py --robot my_robot.toml --world room.toml --seed 7",
        "python -m pytest",
        "robotcore deploy push pi@rover.local",
    ),
)
"""An app, a robot, a room, and their tests."""

DRIVER = Template(
    "driver",
    "my-board",
    (
        "python -m pip install -e .",
        "python -m pytest",
        "robotcore run avoid-obstacles --backend my-board --robot my_board.toml",
    ),
)
"""A package with a backend, and the kit's test of it."""


def module_of(name: str) -> str:
    """Return a project's name as that of a module."""
    return name.replace("-", "_")


def _spelt(name: str) -> tuple[str, str, str]:
    """Return a name as it is typed, as a module's, and as a class's."""
    return name, module_of(name), "".join(part.capitalize() for part in re.split("[-_]", name))


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
