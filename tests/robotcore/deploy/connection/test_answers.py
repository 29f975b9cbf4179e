from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robotcore.deploy.connection import answers
from robotcore.deploy.connection.answers import Answer, Judgement, ProbeAnswer, Recordings, Refusal, State
from robotcore.deploy.connection.link import Call
from robotcore.deploy.connection.process_output import MalformedError

MODELS = [each for each in vars(answers).values() if isinstance(each, type) and issubclass(each, Answer)]
KEYS = sorted({key for model in MODELS for key in model.model_fields} | {"done", "refused", "say", "begun"})

FACTS: dict[str, Any] = {
    "host": "rover",
    "machine": "aarch64",
    "system": "Debian 12",
    "python": "3.11.2",
    "libc": "glibc",
    "libc_version": "2.36",
    "free_bytes": 1,
    "has_environment": True,
}

VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text()
    | st.sampled_from(["2026-11-21T22-40-03Z", "a/b"]),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from(KEYS) | st.text(), inner, max_size=8),
    max_leaves=8,
)


def texts_in(value: Any) -> list[str]:
    if isinstance(value, dict):
        return [text for each in value.values() for text in texts_in(each)]
    if isinstance(value, (list, tuple)):
        return [text for each in value for text in texts_in(each)]
    return [value] if isinstance(value, str) else []


def answered(model: type[Answer], *pieces: bytes) -> list[str]:
    """Let a robot say something; return each text of it that the desk has then, also in an error."""
    said: list[str] = []
    call = Call("status", model, on_say=lambda notice: said.append(notice.say), on_line=said.append)
    try:
        answer = call.parse_answer(pieces)
    except MalformedError as error:
        return [*said, str(error)]
    return [*said, *texts_in(answer.model_dump() if answer else None)]


@settings(max_examples=100, deadline=None)
@given(model=st.sampled_from(MODELS), messages=st.lists(st.dictionaries(st.sampled_from(KEYS), VALUES), max_size=3))
def test_any_json_is_an_answer_or_damaged_and_what_it_says_is_printable(
    model: type[Answer], messages: list[dict[str, Any]]
) -> None:
    raw = "".join(f"\x1e{json.dumps(each)}\n" for each in ({"begun": "status"}, *messages)).encode()
    assert all(text.replace("\t", "").isprintable() for text in answered(model, raw))


@settings(max_examples=300, deadline=None)
@given(model=st.sampled_from(MODELS), pieces=st.lists(st.binary() | st.just(b"\x1e") | st.just(b"\n"), max_size=8))
def test_any_bytes_are_an_answer_or_damaged_and_what_they_say_is_printable(
    model: type[Answer], pieces: list[bytes]
) -> None:
    assert all(text.replace("\t", "").isprintable() for text in answered(model, b'\x1e{"begun": 1}\n', *pieces))


@pytest.mark.parametrize(
    "key, value",
    [
        ("python", "3.11.2; rm -rf /"),
        ("python", "3"),
        ("machine", "../../aarch64"),
        ("libc_version", "2.999999999"),
        ("libc_version", "2."),
        ("free_bytes", -1),
        ("free_bytes", "1"),
        ("free_bytes", float("nan")),
        ("has_environment", "no"),
        ("host", None),
    ],
)
def test_facts_that_no_robot_has_are_damaged(key: str, value: Any) -> None:
    answers.validate(ProbeAnswer, FACTS, "done")
    with pytest.raises(MalformedError, match=f"done.{key}: "):
        answers.validate(ProbeAnswer, {**FACTS, key: value}, "done")


def test_key_that_is_unknown_is_ignored() -> None:
    assert answers.validate(ProbeAnswer, {**FACTS, "colour": "red"}, "done") == ProbeAnswer(**FACTS)


@pytest.mark.parametrize("name", ["..", "/etc", "2026-11-21T22-40-03Z/..", "2026-11-21T22-40-03Z\n", "", "current"])
def test_release_without_the_name_of_one_is_damaged(name: str) -> None:
    told: dict[str, Any] = {"release": name, "outcome": "", "reason": "", "lines": [], "current": None}
    with pytest.raises(MalformedError, match=r"done\.release"):
        answers.validate(Judgement, {**told, "is_running": True, "is_standing": False}, "done")


def test_robot_cannot_refuse_by_a_kind_that_only_the_desk_gives() -> None:
    with pytest.raises(MalformedError, match=r"refused\.kind"):
        answers.validate(Refusal, {"fault": "a", "remedy": "b", "kind": "broken"}, "refused")


def test_list_without_an_end_is_damaged() -> None:
    with pytest.raises(MalformedError, match=r"done\.recordings: List should have at most"):
        answers.validate(Recordings, {"recordings": [[]] * 1_000_000}, "done")


@pytest.mark.parametrize("for_s", [1e300, -1.0, float("nan"), float("inf"), "1"])
def test_time_that_no_robot_has_is_damaged(for_s: Any) -> None:
    told = {"release": None, "verdict": None, "on_trial": None, "last": None, "state": "running", "for_s": for_s}
    with pytest.raises(MalformedError, match=r"done\.for_s"):
        answers.validate(State, told, "done")
