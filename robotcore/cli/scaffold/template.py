"""Templates: whole, working projects, named after something that does not exist."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from importlib import resources
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import sys

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
