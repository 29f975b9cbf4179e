"""Links to child processes, by an inherited socket and over the loopback interface."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager
from threading import Thread

import pytest

from robotcore import child_process
from robotcore.child_process import build_session_options, start_linked_process
from robotcore.system import HAS_POSIX

ECHO = (
    "import sys; from robotcore.child_process import receive_link; link = receive_link(sys.argv[1]); "
    "link.sendall(repr((sys.argv[2:], sys.stdin.read())).encode() + link.recv(9))"
)


@pytest.fixture(params=["loopback", pytest.param("inherited", marks=pytest.mark.posix("it inherits a socket"))])
def way(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    if request.param == "loopback":
        monkeypatch.setattr(child_process, "HAS_POSIX", False)
    return str(request.param)


@contextmanager
def linked(code: str, *arguments: str) -> Iterator[tuple[subprocess.Popen[bytes], socket.socket]]:
    process, link = start_linked_process(code, arguments, stdout=subprocess.DEVNULL)
    with closing(link):
        yield process, link
    process.wait(10)


def read_all(link: socket.socket) -> bytes:
    with link.makefile("rb") as file:
        return file.read()


def test_both_processes_send_over_the_link_and_stdin_is_empty(way: str) -> None:
    with linked(ECHO, "a", "b c") as (_, link):
        link.sendall(b"ping")
        assert read_all(link) == b"(['a', 'b c'], '')ping"


@pytest.mark.posix("it inherits a socket")
def test_a_process_with_closed_standard_streams_can_be_linked() -> None:
    code = (
        "import os; os.close(0); os.close(1); from robotcore.child_process import start_linked_process as start; "
        f"link = start({ECHO!r}, ['a'], stdout=2)[1]; link.sendall(b'ping'); "
        "os.write(2, link.makefile('rb').read())"
    )
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False, timeout=20)
    assert (ended.stderr, ended.returncode) == (b"(['a'], '')ping", 0)


def test_a_process_that_ends_at_once_leaves_a_link_at_its_end(way: str) -> None:
    with linked("raise SystemExit(7)") as (process, link):
        assert read_all(link) == b""
        assert process.wait(10) == 7


def test_a_process_that_cannot_be_started_leaves_no_link(way: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "executable", "/nowhere/python")
    with pytest.raises(FileNotFoundError):
        start_linked_process(ECHO, stdout=subprocess.DEVNULL)


@pytest.mark.slow
def test_a_process_that_does_not_connect_in_time_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(child_process, "HAS_POSIX", False)
    monkeypatch.setattr(child_process, "CONNECTING_S", 0.3)
    with linked("import threading; threading.Event().wait()") as (process, link):
        assert read_all(link) == b""
        assert process.wait(10) != 0


def test_a_stranger_without_the_secret_gets_no_link(monkeypatch: pytest.MonkeyPatch) -> None:
    """Another program of this machine may connect first, as the port is visible to it."""
    answers: list[bytes] = []

    def connect(address: tuple[str, int]) -> socket.socket:
        listener = socket.create_server(address)
        place = listener.getsockname()
        stranger = Thread(target=lambda: answers.append(talk(place)))
        stranger.start()
        stranger.join(0.5)
        return listener

    def talk(place: tuple[str, int]) -> bytes:
        with socket.create_connection(place) as link:
            link.sendall(b"x" * 32)
            return link.recv(1)

    monkeypatch.setattr(child_process, "HAS_POSIX", False)
    monkeypatch.setattr(child_process, "create_server", connect)
    with linked(ECHO) as (_, link):
        link.sendall(b"ping")
        assert read_all(link).endswith(b"ping")
    assert answers == [b""]


@pytest.mark.posix("it sends a signal to a process group")
def test_a_signal_of_the_terminal_does_not_reach_the_process() -> None:
    process = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE, **build_session_options())
    assert os.getpgid(process.pid) != os.getpgrp()
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    assert process.stdin
    process.stdin.close()


def test_a_system_without_posix_inherits_no_handles(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(child_process, "HAS_POSIX", False)
    assert "pass_fds" not in build_session_options([3])
    assert HAS_POSIX or not build_session_options([3]).get("start_new_session")
