"""Each snapshot of a text belongs to a test, and the fixture `raises` compares kinds and fields."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from robotcore.errors import UnknownNameError, UsageError
from tests.texts import FILE, Raises, _update, has_test

FOLDER = Path(__file__).parent


def test_a_kind_and_its_fields_are_those_of_the_raise(raises: Raises) -> None:
    with raises(UsageError, "rate-too-low", rate_hz=0.5):
        raise UsageError("a rate of 0.5 Hz is below 1 Hz", kind="rate-too-low", rate_hz=0.5)


def test_an_error_without_a_kind_has_that_of_its_class(raises: Raises) -> None:
    with raises(UsageError):
        raise UsageError("a run needs an app")


def test_an_unknown_name_has_the_kind_of_what_was_named(raises: Raises) -> None:
    with raises(UnknownNameError, "unknown-backend", name="pibullet"):
        raise UnknownNameError("backend", "pibullet", ["pybullet", "mock"])


def test_another_kind_fails(raises: Raises) -> None:
    with pytest.raises(AssertionError), raises(UsageError, "one"):
        raise UsageError("a run needs an app", kind="another")


def test_an_update_drops_the_texts_of_removed_tests(tmp_path: Path) -> None:
    (tmp_path / "test_it.py").write_text("def test_this(): ...\ndef test_that(): ...\n")
    kept = {"test_it::test_that[a]": "1", "test_it::test_that[a] 2": "2"}
    file = tmp_path / FILE
    file.write_text(json.dumps({**kept, "test_it::test_gone": "3", "test_no::test_this": "4"}))
    assert _update(file, "test_it::test_this", "5") == {**kept, "test_it::test_this": "5"}
    assert json.loads(file.read_text()) == {**kept, "test_it::test_this": "5"}


def test_each_text_belongs_to_a_test() -> None:
    for file in sorted(FOLDER.rglob(FILE)):
        for key in json.loads(file.read_text(encoding="utf-8")):
            assert has_test(file, key), f"{file}: {key}"
