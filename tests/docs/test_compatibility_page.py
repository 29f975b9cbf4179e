"""The pages about compatibility and installation say what the code does."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from robotcore import compatibility
from robotcore.description import load_robot
from robotcore.errors import DescriptionError
from robotcore.python_versions import MAX_PYTHON, MIN_PYTHON
from tests.docs.listings import list_listings, read_rows
from tests.robotcore.description.files import ROVER, replace

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "compatibility.md").read_text(encoding="utf-8")
INSTALLATION = (ROOT / "docs" / "installation.md").read_text(encoding="utf-8")
PROJECT = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
VERSIONS = "{}.{} to {}.{}".format(*MIN_PYTHON, *MAX_PYTHON)


@pytest.fixture
def release(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Return a function that lets this robotcore be of another version."""

    def set_version(version: str) -> None:
        monkeypatch.setattr(compatibility, "read_version", lambda: version)

    return set_version


def test_the_key_of_the_page_is_read(tmp_path: Path) -> None:
    (listing,) = (each.text for each in list_listings(PAGE) if each.language == "toml")
    file = tmp_path / "my_robot.toml"
    file.write_text(replace(ROVER, 'name = "rover"\n', listing), encoding="utf-8")
    assert load_robot(str(file)).name == "my_robot"


def test_the_message_for_a_newer_file_is_that_of_the_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, release: Callable[[str], None]
) -> None:
    monkeypatch.chdir(tmp_path)
    release("0.1.0")
    Path("my_robot.toml").write_text('robotcore = ">=0.3"\n', encoding="utf-8")
    with pytest.raises(DescriptionError) as caught:
        load_robot("my_robot.toml")
    assert f"error: {caught.value}\n" in PAGE


def test_the_pages_have_the_versions_of_python() -> None:
    assert f"| Python | {VERSIONS}." in PAGE
    assert f"robotcore needs Python {VERSIONS} on a 64-bit system" in INSTALLATION


def test_the_page_has_every_extra_for_users() -> None:
    section = PROJECT.partition("[project.optional-dependencies]")[2].partition("\n[project.scripts]")[0]
    extras = set(re.findall(r"^(\w+) = \[", section, re.MULTILINE)) - {
        "demo",
        "dev",
        "docs",
        "test",
        "mujoco",
        "pybullet",
    }
    listed = {name for row, _ in read_rows(INSTALLATION, "From a wheel") for name in re.findall(r"\w+", row)}
    assert listed == extras
