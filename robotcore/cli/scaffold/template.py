"""Create a project or a package from a template: check its name, and copy all files or none."""

from __future__ import annotations

import errno
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

from robotcore.cli.scaffold.names import describe_reserved_use, require_valid_name, spell_name
from robotcore.compatibility import format_minimum
from robotcore.errors import UsageError
from robotcore.files import is_working_folder_deleted

if TYPE_CHECKING:
    if sys.version_info >= (3, 11):
        from importlib.resources.abc import Traversable
    else:
        from importlib.abc import Traversable


CACHES = ("__pycache__", "_cache")
"""The names of cache folders end like this. Installers, test runners and linters create them. They are not copied."""

TEMPLATE_MINIMUM = ">=0.1"
"""The range of robotcore's versions in the templates. A copy has the range from the installed version on.

The user may add any part of the installed version to a copy.
"""


@dataclass(frozen=True)
class Template:
    """A complete project in ``templates/FOLDER`` that can be copied under a new name.

    In texts and file names of the copy, the new name replaces the template's own name in three spellings: ``my-robot``
    as a project, ``my_robot`` as a module, ``MyRobot`` as a class.

    >>> PROJECT.rename_text("my-robot: import my_robot", "rover-2")
    'rover-2: import rover_2'
    """

    folder: str
    """The template's folder in ``templates``."""

    own_name: str
    """The name in the template's files. In a copy, the new name replaces it."""

    first_steps: tuple[str, ...]
    """The commands to run first in the new project."""

    @cached_property
    def root(self) -> Traversable:
        """The folder to copy."""
        return resources.files("robotcore.cli.scaffold").joinpath("templates", self.folder)

    def rename_text(self, text: str, name: str) -> str:
        """Return a text of the template with the new name, and with the installed version of robotcore."""
        words = dict(zip(spell_name(self.own_name), spell_name(name), strict=True))
        words[TEMPLATE_MINIMUM] = format_minimum()
        return re.sub("|".join(map(re.escape, words)), lambda found: words[found[0]], text)

    def entries(self, folder: Traversable) -> Iterator[Traversable]:
        """Yield the files and folders in a folder of the template, without caches."""
        return (each for each in folder.iterdir() if not each.name.endswith(CACHES))

    @property
    def reserved_names(self) -> set[str]:
        """The names that a new project cannot have, because other files of the template have them."""
        stems = (each.name.partition(".")[0] for each in self.entries(self.root))
        return {stem for stem in stems if stem not in spell_name(self.own_name)}

    def uses_class_name(self, name: str) -> bool:
        """Return whether the class of a new project would have the name of another thing in the template's modules."""
        own, new = spell_name(self.own_name)[-1], spell_name(name)[-1]
        modules = (each.read_text(encoding="utf-8") for each in self.entries(self.root) if each.name.endswith(".py"))
        words = {word for module in modules for word in re.findall(r"\w+", module)}
        return own in words and (new in words or iskeyword(new))


PROJECT = Template(
    "project",
    "my-robot",
    (
        "robotcore run search.py --robot my_robot.toml --world room.toml --seed 7",
        "sh ci.sh install",
        "sh ci.sh",
        "robotcore deploy push pi@rover.local",
    ),
)
"""The template of a project with an app, a robot, a room, their tests, and a CI that runs them."""

DRIVER = Template(
    "driver",
    "my-board",
    (
        "python -m pip install -e .",
        "python -m pytest",
        "robotcore run avoid-obstacles --backend my-board --robot my_board.toml",
    ),
)
"""The template of a package with a backend and its conformance test."""


KIND = Template(
    "kind",
    "my-sensor",
    (
        "python -m pip install -e .",
        "robotcore run cautious.py --robot robot.toml --world open",
        "python -m pytest",
    ),
)
"""The template of a package with a kind of device, an app and its test."""


def require_free(template: Template, folder: Path) -> None:
    """Raise UsageError if the project ``folder`` cannot be created.

    The folder must not exist, its parent must exist, and its name must be valid and free.
    """
    name = folder.name
    if name in ("", ".."):
        text = f"{str(folder)!r} does not end with a name for the project. Name a new folder, such as my-robot"
        raise UsageError(text, kind="invalid-project-name", name="", meant="my-robot")
    if os.path.lexists(folder):
        text = f"{folder} exists already, and was not changed. Choose another name, or move {folder}"
        raise UsageError(text, kind="folder-exists")
    if not os.path.isdir(folder.parent):  # noqa: PTH112  it takes any name, however long
        if is_working_folder_deleted(folder):
            raise _build_working_folder_error(folder)
        raise UsageError(f"{folder.parent} is not a folder. Create it first", kind="no-such-folder")
    require_valid_name(name)
    if use := _describe_use(template, name):
        text = f"{name!r} is {use}. Choose another name, such as {name}-{template.folder}"
        raise UsageError(text, kind="project-name-in-use", name=name, use=use)


def _describe_use(template: Template, name: str) -> str:
    module = name.replace("-", "_")
    if use := describe_reserved_use(module):
        return use
    if module in template.reserved_names:
        return "the name of a file in every new project"
    if template.uses_class_name(name):
        return f"a name whose class {spell_name(name)[-1]} would hide another one"
    if module in sys.stdlib_module_names or find_spec(module):
        return "the name of an installed Python module"
    from robotcore.plugins import kind_names

    if template is KIND and module in kind_names():
        return "the name of an installed kind"
    return _use_as_backend(name) if template is DRIVER else ""


def _use_as_backend(name: str) -> str:
    from robotcore.description import RobotDescription
    from robotcore.plugins import backend_names

    if name in backend_names():
        return "the name of an installed backend"
    return "a key of every robot's file" if name in RobotDescription.model_fields else ""


_FREE_SPACE = "Free some space, or choose another folder"

REMEDIES = {
    errno.ENOSPC: _FREE_SPACE,
    errno.EDQUOT: _FREE_SPACE,
    errno.EFBIG: _FREE_SPACE,
    errno.EACCES: "Choose a folder that you can write",
    errno.EPERM: "Choose a folder that you can write",
    errno.EROFS: "Choose a folder that you can write",
    errno.ENAMETOOLONG: "Choose a folder with a shorter path",
}
"""The remedy for each error of the system that prevents a new project."""


def make(template: Template, folder: Path) -> None:
    """Create a project from a template.

    template: the template to copy.
    folder: the folder of the new project, which must not exist. The last part of its path is the project's name.

    The files are written into a temporary folder, which is renamed at the end. So a project that exists is complete.
    Raises UsageError if the name is invalid or in use, or if the files cannot be written.
    """
    require_free(template, folder)
    try:
        with TemporaryDirectory(prefix=".new-", dir=folder.parent) as scratch:
            made = Path(scratch, folder.name)
            _copy(template, template.root, made, folder.name)
            made.rename(folder)
    except OSError as error:
        if is_working_folder_deleted(folder):
            raise _build_working_folder_error(folder) from error
        remedy = REMEDIES.get(error.errno or 0, "Choose another folder")
        text = f"{folder} cannot be created: {error.strerror}. {remedy}"
        raise UsageError(text, kind="folder-unwritable") from error


def _build_working_folder_error(folder: Path) -> UsageError:
    text = f"{folder} cannot be created: the working folder has been deleted. Change to another folder with cd"
    return UsageError(text, kind="folder-unwritable")


def _copy(template: Template, source: Traversable, target: Path, name: str) -> None:
    target.mkdir()
    for each in template.entries(source):
        made = target / template.rename_text(each.name, name)
        if each.is_dir():
            _copy(template, each, made, name)
        else:
            made.write_text(template.rename_text(each.read_text(encoding="utf-8"), name), encoding="utf-8")
