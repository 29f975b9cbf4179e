"""Robots that answer with damaged, endless or no output. Each ends the call with an error, and harms no terminal."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from robotcore.deploy.connection import link as link_module
from robotcore.deploy.connection.answers import Answer, Nothing, Notice
from robotcore.deploy.connection.failures import DAMAGED
from robotcore.deploy.connection.host import Host
from robotcore.deploy.connection.link import Call, Link
from robotcore.errors import DeployError
from tests.robotcore.deploy.actions import ECHO, WAIT, Aboard
from tests.robotcore.deploy.sshd import serving

RAW = """
import os, sys

def act(layout, **told):
    sys.stdout.buffer.write({raw!r})
    sys.stdout.flush()
    if {raw!r}:
        os._exit(0)
"""


class Home(Answer):
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
def test_an_answer_that_is_not_as_it_has_to_be_is_named_as_damaged(link: Link, aboard: Aboard, raw: bytes) -> None:
    aboard("raw", RAW.format(raw=raw))
    with pytest.raises(DeployError, match="its answer to 'raw' is damaged") as caught:
        link.call("raw", Home)
    assert caught.value.kind == DAMAGED
    assert str(caught.value).isprintable()


@pytest.mark.parametrize("piece", [b"x" * (1 << 16), b"x\n" * (1 << 15), b'\x1e{"say": "more"}\n' * 3000])
def test_a_robot_that_writes_without_an_end_is_cut_off(link: Link, aboard: Aboard, piece: bytes) -> None:
    aboard("raw", RAW.format(raw=b"") + f"    while True:\n        sys.stdout.buffer.write({piece!r})\n")
    with pytest.raises(DeployError, match=r"damaged: it (is longer|has a line longer) than") as caught:
        link.call("raw", Home)
    assert caught.value.kind == DAMAGED


def test_a_robot_that_says_nothing_is_not_waited_for_without_an_end(
    link: Link, aboard: Aboard, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(link_module, "SILENCE_S", 1.0)
    aboard("wait", WAIT)
    with pytest.raises(DeployError, match="damaged: it has not come: the robot sent nothing for 1 s"):
        link.call("wait", Nothing)


def test_many_short_pieces_of_stderr_are_no_silence() -> None:
    answer = Call("raw", Home).parse_answer([*[b""] * 3000, b'\x1e{"done": {"home": "/home/pi"}}\n'])
    assert answer == Home(home="/home/pi")


def test_what_a_robot_writes_on_stderr_fills_neither_memory_nor_disk(link: Link, aboard: Aboard) -> None:
    flood = "    for _ in range(400):\n        sys.stderr.write('\\x1b]0;t' + 'x' * 100_000 + '\\n')\n    os._exit(3)\n"
    aboard("raw", RAW.format(raw=b"") + flood)
    with pytest.raises(DeployError, match="it failed there") as caught:
        link.call("raw", Home)
    assert len(str(caught.value)) < 1 << 15
    assert str(caught.value).isprintable()


def test_what_a_robot_says_is_escaped(link: Link, aboard: Aboard) -> None:
    said: list[Notice] = []
    lines: list[str] = []
    aboard(
        "raw", RAW.format(raw=b'a\x1b]0;t\x07\r\tb\n\x1e{"say": "1\\n\\u001b[2J"}\n\x1e{"done": {"home": "\\u202e"}}\n')
    )
    answer = link.call("raw", Home, on_say=said.append)
    link.stream("raw", lines.append, most=None)
    assert (answer.home, said[0].say) == (r"\u202e", r"1\n\x1b[2J")
    assert lines == ["a\\x1b]0;t\\x07\\r\tb"]


def test_a_login_that_floods_the_log_of_ssh_ends(tmp_path: Path) -> None:
    shell = 'yes evil | head -c 200000000 >&2; eval "$SSH_ORIGINAL_COMMAND"'
    with (
        serving(tmp_path / "sshd", f"ForceCommand {shell}") as sshd,
        pytest.raises(DeployError, match="its login shell ended at once"),
        Link(Host.parse("robot"), sshd.config),
    ):
        pass


def test_a_login_shell_that_prints_without_an_end_is_cut_off(tmp_path: Path) -> None:
    with (
        serving(tmp_path / "sshd", "ForceCommand yes evil") as sshd,
        pytest.raises(DeployError, match=r"damaged: it has more than \d+ bytes from the login shell") as caught,
        Link(Host.parse("robot"), sshd.config),
    ):
        pass
    assert caught.value.kind == DAMAGED


def test_the_agent_of_the_user_is_not_handed_to_a_robot(tmp_path: Path, aboard: Aboard) -> None:
    aboard("echo", ECHO)
    note = f'env > {tmp_path}/environment; eval "$SSH_ORIGINAL_COMMAND"'
    with serving(tmp_path / "sshd", f"ForceCommand {note}") as sshd:
        command = ("ssh-agent", "-D", "-a", tmp_path / "agent")
        agent = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        try:
            own = f"ForwardAgent yes\nForwardX11 yes\nIdentityAgent {tmp_path}/agent\n"
            sshd.config.write_text(own + sshd.config.read_text())
            while not (tmp_path / "agent").exists():
                assert agent.poll() is None
            with Link(Host.parse("robot"), sshd.config):
                environment = (tmp_path / "environment").read_text()
        finally:
            agent.terminate()
            agent.wait()
    assert "SSH_CONNECTION" in environment
    assert "SSH_AUTH_SOCK" not in environment
    assert "DISPLAY" not in environment
