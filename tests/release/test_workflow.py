"""The workflow of a release runs commands of this repository, with no more rights than each job needs."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

yaml = pytest.importorskip("yaml")

ROOT = Path(__file__).parents[2]
FILE = ROOT / ".github" / "workflows" / "release.yml"


@pytest.fixture(scope="module")
def workflow() -> Any:
    return yaml.safe_load(FILE.read_text(encoding="utf-8"))


def test_a_tag_of_a_version_starts_it(workflow: Any) -> None:
    assert workflow[True] == {"push": {"tags": ["v*"]}}  # YAML reads the key `on` as a boolean


def test_only_the_job_that_publishes_may_write(workflow: Any) -> None:
    assert workflow["permissions"] == {}
    rights = {name: set(job["permissions"].values()) for name, job in workflow["jobs"].items()}
    assert rights == {"build": {"read"}, "test": {"read"}, "publish": {"write"}}
    assert workflow["jobs"]["publish"]["environment"] == "release"
    assert set(workflow["jobs"]["publish"]["needs"]) == {"build", "test"}


def test_its_commands_exist() -> None:
    text = FILE.read_text(encoding="utf-8")
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    called = [target for line in re.findall(r"\bmake ([a-z -]+)$", text, re.MULTILINE) for target in line.split()]
    assert {"lint", "package", "system-package"} <= set(called)
    for target in called:
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target
    for module in re.findall(r"python -m (release\S*)", text):
        assert Path(ROOT, *module.split(".")).with_suffix(".py").is_file()


def test_it_names_no_host() -> None:
    assert not re.search(r"https?://|\w\.(org|com|io)\b", FILE.read_text(encoding="utf-8"))
