from __future__ import annotations

from pathlib import Path

import pytest

from robotcore.compatibility import read_version
from robotcore.description import load_any, load_robot, load_world
from robotcore.errors import DescriptionError
from tests.robotcore.description.files import ARENA, ROVER, find_errors
from tests.texts import Raises

LOADS = [(load_robot, ROVER), (load_world, ARENA), (load_any, ROVER), (load_any, ARENA)]


@pytest.mark.parametrize("load, text", LOADS)
def test_a_file_for_this_version_is_loaded(tmp_path: Path, load: object, text: str) -> None:
    file, plain = tmp_path / "my.toml", tmp_path / "plain.toml"
    file.write_text(f'robotcore = ">=0.1"\n{text}', encoding="utf-8")
    plain.write_text(text, encoding="utf-8")
    assert callable(load)
    assert load(str(file)) == load(str(plain))


@pytest.mark.parametrize("load, text", LOADS)
def test_a_file_for_a_newer_version_is_refused_before_its_other_keys(
    tmp_path: Path, load: object, text: str, raises: Raises
) -> None:
    file = tmp_path / "my.toml"
    file.write_text(f'robotcore = ">=1000"\nwheels = "five"\n{text}', encoding="utf-8")
    assert callable(load)
    with raises(DescriptionError, "robotcore-version", key="robotcore", needed=">=1000", hide=[read_version()]):
        load(str(file))


@pytest.mark.parametrize(
    "value", ["0.2", '"newest"', '["0.2"]', "true", '"0.2"', '" "', f'">=0.1{",>=0.1" * 30}"', f'">={"9" * 5000}"']
)
def test_a_value_that_is_no_range_is_refused(tmp_path: Path, value: str, raises: Raises) -> None:
    file = tmp_path / "my.toml"
    file.write_text(f"robotcore = {value}\n{ROVER}", encoding="utf-8")
    with raises(DescriptionError, "wrong-form", key="robotcore"):
        load_robot(str(file))


def test_a_misspelt_key_suggests_it(tmp_path: Path) -> None:
    (error,) = find_errors(tmp_path, f'robot_core = ">=0.1"\n{ROVER}')
    assert error.remedy.endswith("Did you mean 'robotcore'?")
