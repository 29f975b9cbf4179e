"""A package of the user's, built at the desk and laid out beside robotcore."""

from __future__ import annotations

import shlex
import shutil
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from tempfile import TemporaryDirectory

from robotcore.deploy.packages.pip import pip
from robotcore.deploy.packages.pip import told as told_by_pip
from robotcore.deploy.packages.requirements import Requirement
from robotcore.deploy.staging.copying import copied
from robotcore.deploy.table import FILE
from robotcore.description import read_table
from robotcore.errors import DeployError, UsageError
from robotcore.text import escape

COMPILED = (".so", ".pyd", ".dylib")
"""What holds machine code."""

_OF_THIS_MACHINE = ("RECORD", "direct_url.json", "REQUESTED", "INSTALLER")
"""Of a package's metadata, what tells where it is installed here."""


def build(source: Path, site: Path) -> tuple[str, ...]:
    """Install a package, a folder or an archive, into ``site`` without what it depends on.

    A folder is built from a copy of what would be sent of it, so that nothing is left in it. Returns its files that
    may hold a secret, which are not in that copy, with the name of the folder before them. Raises DeployError if it
    cannot be built, UsageError if it has compiled code: that is for this machine, and the robot is another.
    """
    with TemporaryDirectory(prefix="robotcore-") as scratch:
        tree, built = Path(scratch, "source"), Path(scratch, "built")
        secrets = copied(source, tree).secrets if source.is_dir() else ()
        asked = pip(
            [
                *("install", "--quiet", "--no-deps", "--no-compile", "--target", str(built)),
                *(["--no-build-isolation"] if _has_all_to_build(tree) else []),
                str(tree if source.is_dir() else source),
            ]
        )
        if asked.returncode:
            raise DeployError(
                f"{escape(str(source))} cannot be built: {told_by_pip(asked)}. Build it here until it works: "
                f"pip wheel --no-deps {shlex.quote(str(source))}"
            )
        _require_pure(source, built)
        _move(built, site)
    return tuple(f"{source.name}/{name}" for name in secrets)


def _has_all_to_build(tree: Path) -> bool:
    """Return whether what it is built with is installed here, so that no index has to be asked."""
    if not (tree / FILE).is_file():
        return False
    table = read_table(str(tree / FILE)).get("build-system", {})
    return "requires" in table and all(map(_is_here, table["requires"]))


def _is_here(text: str) -> bool:
    requirement = Requirement(text)
    if requirement.marker and not requirement.marker.evaluate():
        return True
    try:
        return requirement.specifier.contains(version(requirement.name), prereleases=True)
    except PackageNotFoundError:
        return False


def _require_pure(source: Path, built: Path) -> None:
    compiled = next((file for file in built.rglob("*") if file.suffix in COMPILED), None)
    if compiled:
        raise UsageError(
            f"{escape(str(source))} has code compiled for this machine ({escape(compiled.name)}). Publish it with "
            "wheels for the robot, and name it in the project's dependencies"
        )


def _move(built: Path, site: Path) -> None:
    """Put what was built beside what is in ``site``; commands stay here, as does what tells of this machine."""
    shutil.rmtree(built / "bin", ignore_errors=True)
    for name in _OF_THIS_MACHINE:
        for file in built.glob(f"*.dist-info/{name}"):
            file.unlink()
    shutil.copytree(built, site, dirs_exist_ok=True)
