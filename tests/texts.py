"""Errors by kind, and the texts that users read, in one file a package of tests.

A test asserts what happened: the class of an error, its kind and its fields. The text of the error is in the file
``texts.json`` beside the test. ``pytest --update-texts`` writes these files again. Read the change in the diff.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from functools import cache
from pathlib import Path
from typing import Any, Protocol, TypeVar

import pytest

FILE = "texts.json"
ROOT = Path(__file__).parents[1]
ErrorT = TypeVar("ErrorT", bound=BaseException)


class CheckText(Protocol):
    """Compare a text with the snapshot of the running test."""

    def __call__(self, text: object, *, hide: Sequence[object] = ()) -> None: ...


class Raises(Protocol):
    """Expect an error of a class and a kind, with these fields, and with the text of the snapshot."""

    def __call__(
        self, expected: type[ErrorT], kind: str = "", *, hide: Sequence[object] = (), **fields: object
    ) -> AbstractContextManager[pytest.ExceptionInfo[ErrorT]]: ...


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--update-texts", action="store_true", help="write the texts of the tests that run")


@pytest.fixture
def check_text(request: pytest.FixtureRequest) -> CheckText:
    """Compare a text with the one in ``texts.json`` beside the test; several in one test are counted.

    The test's temporary folder and the project's folder are replaced by names, and each part in ``hide`` by ``…``.
    """
    file = request.path.parent / FILE
    test = f"{request.path.stem}::{request.node.name}"
    numbers = iter(range(1, 1000))

    def check(text: object, *, hide: Sequence[object] = ()) -> None:
        key = test if (number := next(numbers)) == 1 else f"{test} {number}"
        plain = _hide(str(text), request, hide)
        known = _update(file, key, plain) if request.config.getoption("--update-texts") else _read(file)
        assert key in known, f"{file} has no text for {key}; run pytest --update-texts"
        assert plain == known[key]

    return check


@pytest.fixture
def raises(check_text: CheckText) -> Raises:
    """Expect an error of exactly this class, of this kind, with these fields; its text is in the snapshot."""

    @contextmanager
    def expect(
        expected: type[ErrorT], kind: str = "", *, hide: Sequence[object] = (), **fields: object
    ) -> Iterator[pytest.ExceptionInfo[ErrorT]]:
        with pytest.raises(expected) as caught:
            yield caught
        assert type(caught.value) is expected
        error: Any = caught.value
        assert error.kind == (kind or expected.kind)  # type: ignore[attr-defined]
        found = vars(error) | dict(error.fields)
        assert {name: found.get(name) for name in fields} == fields
        check_text(error, hide=hide)

    return expect


def _hide(text: str, request: pytest.FixtureRequest, hide: Sequence[object]) -> str:
    for part in hide:
        text = text.replace(str(part), "…")
    if "tmp_path" in request.fixturenames:
        folder: Path = request.getfixturevalue("tmp_path")
        text = text.replace(str(folder), "TMP")
    return text.replace(str(ROOT), "ROOT")


def _read(file: Path) -> dict[str, str]:
    texts: dict[str, str] = json.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
    return texts


def has_test(file: Path, key: str) -> bool:
    """Return whether the test function of a key in a file of texts exists."""
    module, _, test = key.partition("::")
    name = re.split(r"[\[ ]", test)[0]
    return f"def {name}(" in _read_module(file.parent / f"{module}.py")


@cache
def _read_module(module: Path) -> str:
    return module.read_text(encoding="utf-8") if module.is_file() else ""


def _update(file: Path, key: str, text: str) -> dict[str, str]:
    """Write one text, drop those of removed tests, and return all; processes of pytest-xdist take turns."""
    import fcntl  # only the developers who update texts need it

    with file.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        kept = {each: known for each, known in _read(file).items() if has_test(file, each)}
        texts = dict(sorted({**kept, key: text}.items()))
        file.write_text(json.dumps(texts, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        return texts
