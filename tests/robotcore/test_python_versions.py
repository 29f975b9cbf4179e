"""A Python that is too old gets one line. It must parse the modules that are imported first."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from robotcore import python_versions
from robotcore.deploy.agent import bootstrap
from tests.texts import CheckText

ROOT = Path(__file__).parents[2]
FIRST = ("__init__.py", "python_versions.py", "__main__.py")
"""The modules that are imported before the version is checked, or that a command starts with."""


def find_old_python() -> Path | None:
    """Return a Python from 3.6 to 3.9 on this machine."""
    folders = [Path(each) for each in os.get_exec_path()] + list(Path.home().glob(".pyenv/versions/3.*/bin"))
    found = (folder / f"python3.{minor}" for minor in (9, 8, 7, 6) for folder in folders if "shims" not in folder.parts)
    return next((python for python in found if os.access(python, os.X_OK)), None)


@pytest.mark.parametrize("name", FIRST)
def test_python_3_8_can_parse_the_first_modules(name: str) -> None:
    ast.parse((ROOT / "robotcore" / name).read_text(encoding="utf-8"), feature_version=(3, 8))


def test_an_old_python_gets_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], check_text: CheckText
) -> None:
    monkeypatch.setattr(sys, "version_info", (3, 9, 2, "final", 0))
    monkeypatch.setattr(sys, "version", "3.9.2 (main)")
    with pytest.raises(SystemExit) as ending:
        python_versions.require_supported_python()
    assert ending.value.code == 2
    check_text(capsys.readouterr().err, hide=[sys.executable])


@pytest.mark.slow
def test_a_real_old_python_gets_one_line() -> None:
    if not (python := find_old_python()):
        pytest.skip("needs a Python from 3.6 to 3.9")
    run = subprocess.run(
        [python, "-m", "robotcore", "--version"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert (run.returncode, run.stdout) == (2, "")
    assert re.fullmatch(r"error: robotcore needs Python 3\.10 or newer, and .* is Python 3\..*\n", run.stderr)


def test_the_oldest_python_is_that_of_the_package_and_of_the_deploy_agent() -> None:
    oldest = ".".join(map(str, python_versions.MIN_PYTHON))
    assert f'requires-python = ">={oldest}"' in (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert bootstrap.MIN_PYTHON == python_versions.MIN_PYTHON
