"""Robots with damaged, endless or no output. Each call ends with an error, and prints no control characters."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import pytest

from robotcore.deploy import robot_answers as answers
from robotcore.deploy import rpc
from robotcore.deploy.errors import CALL_FAILED, DAMAGED
from robotcore.deploy.process_output import MalformedError
from robotcore.deploy.robot_answers import (
    BeginAnswer,
    EmptyAnswer,
    HealthAnswer,
    ProbeAnswer,
    ProgressMessage,
    RecordingsAnswer,
    Refusal,
    RobotMessage,
)
from robotcore.deploy.rpc import RobotLink, parse_answer
from robotcore.errors import DeployError
from tests.robotcore.deploy.conftest import ECHO, WAIT, AddAction
from tests.robotcore.deploy.sshd import Sshd, serving
from tests.texts import Raises

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

HEALTH: dict[str, Any] = {
    **dict.fromkeys(("outcome", "reason"), ""),
    "release": "2026-11-21T22-40-03Z",
    "lines": [],
    "current": None,
    "is_running": True,
    "is_stopped": False,
}
REFUSAL = {"problem": "a", "remedy": "b", "kind": "full"}


@pytest.mark.parametrize(
    "model, valid, key, value",
    [
        (ProbeAnswer, FACTS, "python", "3.11.2; rm -rf /"),
        (ProbeAnswer, FACTS, "machine", "../../aarch64"),
        (ProbeAnswer, FACTS, "libc_version", "2.999999999"),
        (ProbeAnswer, FACTS, "free_bytes", -1),
        (ProbeAnswer, FACTS, "free_bytes", "1"),
        (ProbeAnswer, FACTS, "has_environment", "no"),
        (HealthAnswer, HEALTH, "release", ".."),
        (HealthAnswer, HEALTH, "release", "2026-11-21T22-40-03Z/.."),
        (HealthAnswer, HEALTH, "current", "2026-11-21T22-40-03Z\n"),
        (Refusal, REFUSAL, "kind", "broken"),
        (RecordingsAnswer, {"recordings": []}, "recordings", [[]] * 1_000_000),
    ],
)
def test_impossible_value_is_damaged(model: type[RobotMessage], valid: dict[str, Any], key: str, value: Any) -> None:
    answers.validate(model, {**valid, "unknown": 1}, "done")
    with pytest.raises(MalformedError, match=rf"done\.{key}: "):
        answers.validate(model, {**valid, key: value}, "done")


def test_message_quotes_only_the_beginning_of_a_long_value() -> None:
    with pytest.raises(MalformedError, match=r"done\.to: ") as caught:
        answers.validate(BeginAnswer, {"release": HEALTH["release"], "to": "/" * 1_000_000, "copy_from": None}, "done")
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize("message", [b'{"other": 1}', b"{}"])
def test_unknown_message_is_damaged(message: bytes) -> None:
    with pytest.raises(MalformedError, match="neither progress, nor an answer, nor a refusal"):
        parse_answer([b'\x1e{"begun": "raw"}\n\x1e' + message + b"\n"], Home)


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
        b'\x1e{"done": 5}',
        b'\x1e{"done": {"home": NaN}}',
        b'\x1e{"text": "it starts", "release": "../../etc"}',
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
@pytest.mark.parametrize("piece", [b"x" * (1 << 16), b"x\n" * (1 << 15), b'\x1e{"text": "more"}\n' * 3000])
def test_endless_output_ends_the_call(link: RobotLink, add_action: AddAction, piece: bytes) -> None:
    add_action("raw", RAW.format(raw=b"") + f"    while True:\n        sys.stdout.buffer.write({piece!r})\n")
    with pytest.raises(DeployError) as caught:
        link.call("raw", Home)
    assert caught.value.kind == DAMAGED


@pytest.mark.slow
def test_silence_ends_the_call(
    link: RobotLink, robot: Sshd, add_action: AddAction, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.setattr(rpc, "SILENCE_S", 1.0)
    add_action("wait", WAIT)
    with raises(DeployError, "damaged", hide=[robot.config]):
        link.call("wait", EmptyAnswer)


def test_output_on_stderr_is_no_silence() -> None:
    answer = parse_answer([*[b""] * 3000, b'\x1e{"done": {"home": "/home/pi"}}\n'], Home)
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
        "raw",
        RAW.format(raw=b'a\x1b]0;t\x07\r\tb\n\x1e{"text": "1\\n\\u001b[2J"}\n\x1e{"done": {"home": "\\u202e"}}\n'),
    )
    answer = link.call("raw", Home, on_message=said.append)
    link.stream("raw", lines.append, max_bytes=None)
    assert (answer.home, said[0].text) == (r"\u202e", r"1\n\x1b[2J")
    assert lines == ["a\\x1b]0;t\\x07\\r\tb"]


@pytest.mark.parametrize(
    "shell, kind",
    [
        ('yes evil | head -c 200000000 >&2; eval "$SSH_ORIGINAL_COMMAND"', "login-shell-ended"),
        ("yes evil", DAMAGED),
    ],
    ids=["log", "output"],
)
def test_login_shell_with_endless_output_ends_the_connection(tmp_path: Path, shell: str, kind: str) -> None:
    with (
        serving(tmp_path / "sshd", f"ForceCommand {shell}") as sshd,
        pytest.raises(DeployError) as caught,
        RobotLink(sshd.address),
    ):
        pass
    assert caught.value.kind == kind


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
            with RobotLink(sshd.address):
                environment = (tmp_path / "environment").read_text()
        finally:
            agent.terminate()
            agent.wait()
    assert "SSH_CONNECTION" in environment
    assert "SSH_AUTH_SOCK" not in environment
    assert "DISPLAY" not in environment
