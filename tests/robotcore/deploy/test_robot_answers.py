"""Robots with damaged, endless or no output. Each call ends with an error, and prints no control characters."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robotcore.deploy import robot_answers as answers
from robotcore.deploy import rpc
from robotcore.deploy.errors import CALL_FAILED, DAMAGED
from robotcore.deploy.host import RobotAddress
from robotcore.deploy.process_output import MalformedError
from robotcore.deploy.robot_answers import (
    EmptyAnswer,
    HealthAnswer,
    ProbeAnswer,
    ProgressMessage,
    RecordingsAnswer,
    Refusal,
    RobotMessage,
    StatusAnswer,
)
from robotcore.deploy.rpc import RemoteCall, RobotLink
from robotcore.errors import DeployError
from tests.robotcore.deploy.conftest import ECHO, WAIT, AddAction
from tests.robotcore.deploy.sshd import serving
from tests.texts import Raises

MODELS = [each for each in vars(answers).values() if isinstance(each, type) and issubclass(each, RobotMessage)]
KEYS = sorted(
    {field.alias or name for model in MODELS for name, field in model.model_fields.items()}
    | {"done", "refused", "say", "begun"}
)

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


def list_texts(value: Any) -> list[str]:
    if isinstance(value, dict):
        return [text for each in value.values() for text in list_texts(each)]
    if isinstance(value, (list, tuple)):
        return [text for each in value for text in list_texts(each)]
    return [value] if isinstance(value, str) else []


def parse_texts(model: type[RobotMessage], *pieces: bytes) -> list[str]:
    """Parse the output of a robot. Return all texts that the client gets from it, also in an error."""
    said: list[str] = []
    call = RemoteCall("status", model, on_message=lambda message: said.append(message.text), on_line=said.append)
    try:
        answer = call.parse_answer(pieces)
    except MalformedError as error:
        return [*said, str(error)]
    return [*said, *list_texts(answer.model_dump() if answer else None)]


@pytest.mark.slow
@settings(max_examples=100, deadline=None)
@given(model=st.sampled_from(MODELS), messages=st.lists(st.dictionaries(st.sampled_from(KEYS), VALUES), max_size=3))
def test_any_json_is_an_answer_or_damaged_and_its_texts_are_printable(
    model: type[RobotMessage], messages: list[dict[str, Any]]
) -> None:
    raw = "".join(f"\x1e{json.dumps(each)}\n" for each in ({"begun": "status"}, *messages)).encode()
    assert all(text.replace("\t", "").isprintable() for text in parse_texts(model, raw))


@pytest.mark.slow
@settings(max_examples=300, deadline=None)
@given(model=st.sampled_from(MODELS), pieces=st.lists(st.binary() | st.just(b"\x1e") | st.just(b"\n"), max_size=8))
def test_any_bytes_are_an_answer_or_damaged_and_their_texts_are_printable(
    model: type[RobotMessage], pieces: list[bytes]
) -> None:
    assert all(text.replace("\t", "").isprintable() for text in parse_texts(model, b'\x1e{"begun": 1}\n', *pieces))


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
def test_impossible_facts_are_damaged(key: str, value: Any) -> None:
    answers.validate(ProbeAnswer, FACTS, "done")
    with pytest.raises(MalformedError, match=f"done.{key}: "):
        answers.validate(ProbeAnswer, {**FACTS, key: value}, "done")


def test_unknown_key_is_ignored() -> None:
    assert answers.validate(ProbeAnswer, {**FACTS, "colour": "red"}, "done") == ProbeAnswer(**FACTS)


@pytest.mark.parametrize("name", ["..", "/etc", "2026-11-21T22-40-03Z/..", "2026-11-21T22-40-03Z\n", "", "current"])
def test_invalid_name_of_a_release_is_damaged(name: str) -> None:
    payload: dict[str, Any] = {"release": name, "outcome": "", "reason": "", "lines": [], "current": None}
    with pytest.raises(MalformedError, match=r"done\.release"):
        answers.validate(HealthAnswer, {**payload, "is_running": True, "is_standing": False}, "done")


def test_robot_cannot_refuse_with_a_kind_of_the_client() -> None:
    with pytest.raises(MalformedError, match=r"refused\.kind"):
        answers.validate(Refusal, {"fault": "a", "remedy": "b", "kind": "broken"}, "refused")


def test_too_long_list_is_damaged() -> None:
    with pytest.raises(MalformedError, match=r"done\.recordings: "):
        answers.validate(RecordingsAnswer, {"recordings": [[]] * 1_000_000}, "done")


@pytest.mark.parametrize("for_s", [1e300, -1.0, float("nan"), float("inf"), "1"])
def test_impossible_time_is_damaged(for_s: Any) -> None:
    payload = {"release": None, "verdict": None, "on_trial": None, "last": None, "state": "running", "for_s": for_s}
    with pytest.raises(MalformedError, match=r"done\.for_s"):
        answers.validate(StatusAnswer, payload, "done")


RAW = """
import os, sys

def act(layout, **arguments):
    sys.stdout.buffer.write({raw!r})
    sys.stdout.flush()
    if {raw!r}:
        os._exit(0)
"""


class Home(RobotMessage):
    home: str


@pytest.mark.parametrize(
    "raw",
    [
        b"\x1e{",
        b"\x1e[]",
        b"\x1enull",
        b'\x1e{"done": 5}',
        b'\x1e{"done": {"home": 5}}',
        b'\x1e{"done": {}}',
        b'\x1e{"done": {"home": NaN}}',
        b'\x1e{"refused": {}}',
        b'\x1e{"refused": {"fault": "a", "remedy": "b", "kind": "broken"}}',
        b'\x1e{"say": 5}',
        b'\x1e{"say": "it starts", "release": "../../etc"}',
        b'\x1e{"done": {"home": "\xff"}}',
        b"\x1e" + b"[" * 100_000,
        b"\x1e" + b"9" * 5000,
    ],
)
def test_invalid_answer_is_damaged(link: RobotLink, add_action: AddAction, raw: bytes) -> None:
    add_action("raw", RAW.format(raw=raw))
    with pytest.raises(DeployError) as caught:
        link.call("raw", Home)
    assert caught.value.kind == DAMAGED
    assert str(caught.value).isprintable()


@pytest.mark.slow
@pytest.mark.parametrize("piece", [b"x" * (1 << 16), b"x\n" * (1 << 15), b'\x1e{"say": "more"}\n' * 3000])
def test_endless_output_ends_the_call(link: RobotLink, add_action: AddAction, piece: bytes) -> None:
    add_action("raw", RAW.format(raw=b"") + f"    while True:\n        sys.stdout.buffer.write({piece!r})\n")
    with pytest.raises(DeployError) as caught:
        link.call("raw", Home)
    assert caught.value.kind == DAMAGED


@pytest.mark.slow
def test_silence_ends_the_call(
    link: RobotLink, add_action: AddAction, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.setattr(rpc, "SILENCE_S", 1.0)
    add_action("wait", WAIT)
    with raises(DeployError, "damaged"):
        link.call("wait", EmptyAnswer)


def test_output_on_stderr_is_no_silence() -> None:
    answer = RemoteCall("raw", Home).parse_answer([*[b""] * 3000, b'\x1e{"done": {"home": "/home/pi"}}\n'])
    assert answer == Home(home="/home/pi")


@pytest.mark.slow
def test_endless_stderr_fills_neither_memory_nor_disk(link: RobotLink, add_action: AddAction) -> None:
    flood = "    for _ in range(400):\n        sys.stderr.write('\\x1b]0;t' + 'x' * 100_000 + '\\n')\n    os._exit(3)\n"
    add_action("raw", RAW.format(raw=b"") + flood)
    with pytest.raises(DeployError) as caught:
        link.call("raw", Home)
    assert caught.value.kind == CALL_FAILED
    assert len(str(caught.value)) < 1 << 15
    assert str(caught.value).isprintable()


def test_texts_of_a_robot_are_escaped(link: RobotLink, add_action: AddAction) -> None:
    said: list[ProgressMessage] = []
    lines: list[str] = []
    add_action(
        "raw", RAW.format(raw=b'a\x1b]0;t\x07\r\tb\n\x1e{"say": "1\\n\\u001b[2J"}\n\x1e{"done": {"home": "\\u202e"}}\n')
    )
    answer = link.call("raw", Home, on_message=said.append)
    link.stream("raw", lines.append, max_bytes=None)
    assert (answer.home, said[0].text) == (r"\u202e", r"1\n\x1b[2J")
    assert lines == ["a\\x1b]0;t\\x07\\r\tb"]


def test_login_shell_that_floods_the_log_of_ssh_ends(tmp_path: Path) -> None:
    shell = 'yes evil | head -c 200000000 >&2; eval "$SSH_ORIGINAL_COMMAND"'
    with (
        serving(tmp_path / "sshd", f"ForceCommand {shell}") as sshd,
        pytest.raises(DeployError) as caught,
        RobotLink(RobotAddress.parse("robot"), sshd.config),
    ):
        pass
    assert caught.value.kind == "login-shell-ended"


def test_login_shell_with_endless_output_ends_the_connection(tmp_path: Path) -> None:
    with (
        serving(tmp_path / "sshd", "ForceCommand yes evil") as sshd,
        pytest.raises(DeployError) as caught,
        RobotLink(RobotAddress.parse("robot"), sshd.config),
    ):
        pass
    assert caught.value.kind == DAMAGED


def test_robot_does_not_get_the_users_ssh_agent(tmp_path: Path, add_action: AddAction) -> None:
    add_action("echo", ECHO)
    note = f'env > {tmp_path}/environment; eval "$SSH_ORIGINAL_COMMAND"'
    with serving(tmp_path / "sshd", f"ForceCommand {note}") as sshd:
        command = ("ssh-agent", "-D", "-a", tmp_path / "agent")
        agent = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        try:
            own = f"ForwardAgent yes\nForwardX11 yes\nIdentityAgent {tmp_path}/agent\n"
            sshd.config.write_text(own + sshd.config.read_text())
            while not (tmp_path / "agent").exists():
                assert agent.poll() is None
            with RobotLink(RobotAddress.parse("robot"), sshd.config):
                environment = (tmp_path / "environment").read_text()
        finally:
            agent.terminate()
            agent.wait()
    assert "SSH_CONNECTION" in environment
    assert "SSH_AUTH_SOCK" not in environment
    assert "DISPLAY" not in environment
