"""Signals while the command measures: the report says what ended the test."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from robotcore.cli.doctor.loopback import run_loopback
from robotcore.errors import DeviceError, Interrupted
from robotcore.hal.loopback import LoopbackPerson, LoopbackRequest, LoopbackTest, RuleResult

RULES = ("a", "b", "c")


class InterruptedTest(LoopbackTest):
    """A test with three rules. A signal arrives during the second one."""

    rules = RULES
    topics: Mapping[str, tuple[str, ...]] = {"wires": ("ready",)}
    pins = ((20, 21),)

    def __init__(self, handle: Callable[[], None]) -> None:
        self._handle = handle

    def describe_board(self) -> Mapping[str, str]:
        return {}

    def run(self, person: LoopbackPerson, write: Callable[[str], object]) -> Generator[RuleResult, None, None]:
        for rule in RULES:
            if rule == "b":
                self._handle()
            yield RuleResult.from_measurement(rule, "1", "1", is_met=True)


@pytest.fixture(autouse=True)
def _handle_sigint() -> Iterator[None]:
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def measure(handle: Callable[[], None], file: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    class Board:
        def plan_loopback(self, _: LoopbackRequest) -> LoopbackTest:
            return InterruptedTest(handle)

    monkeypatch.setattr("robotcore.hal.backend.load_backend", lambda _: Board())
    with pytest.raises(Interrupted):
        run_loopback(None, LoopbackRequest(), [("wires", "ready")], file, as_json=False)
    found: dict[str, Any] = json.loads(file.read_text())
    return found


def test_a_signal_whose_exception_python_discards_ends_the_test_after_the_rule(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def discard() -> None:
        with suppress(Interrupted):  # as Python does in a callback of a weak reference
            signal.raise_signal(signal.SIGINT)

    report = measure(discard, tmp_path / "r.json", monkeypatch)
    assert report["ended"] == "interrupted by SIGINT"
    assert [rule["verdict"] for rule in report["rules"]] == ["passed", "passed", "skipped"]


@pytest.mark.parametrize("error", [RuntimeError("no"), DeviceError("motor", "unplugged", kind="unplugged")], ids=repr)
def test_an_error_in_place_of_the_signal_does_not_hide_it(
    error: Exception, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def convert() -> None:
        with suppress(Interrupted):
            signal.raise_signal(signal.SIGINT)
        raise error

    report = measure(convert, tmp_path / "r.json", monkeypatch)
    assert report["ended"] == "interrupted by SIGINT"
    assert [rule["verdict"] for rule in report["rules"]] == ["passed", "skipped", "skipped"]
