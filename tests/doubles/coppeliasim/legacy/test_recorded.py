"""The double held against a real server: each client's message of record is sent to it, each reply is compared."""

from __future__ import annotations

import socket
import struct
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial

import pytest

from tests.doubles.coppeliasim.legacy.client import Client
from tests.doubles.coppeliasim.legacy.codec import Command, Header, pack, packed_up, read_message, unpack
from tests.doubles.coppeliasim.legacy.codes import Code
from tests.doubles.coppeliasim.legacy.comparing import LAST_STEPS_MS, TIME_MS, Message, differences
from tests.doubles.coppeliasim.legacy.recorded import Reply, session
from tests.doubles.coppeliasim.legacy.recorded_scenes import first_scene, later_scene
from tests.doubles.coppeliasim.legacy.service import Service
from tests.doubles.coppeliasim.legacy.temporary import TemporaryService
from tests.doubles.coppeliasim.scene.simulator import Simulator

RUNNING_FOR_S = 4.95
"""The temporary service's client took time into its hands after 60 messages, at 7.95 s."""

STOP = (2).to_bytes(4, "little")


class EachMessageAStep(Service):
    """Unheld time goes on by a step with each message, as it did for the recorded clients: no clock is asked."""

    def _turn(self, client: Client) -> None:
        super()._turn(client)
        if self._simulator.state.is_advancing and not self._simulator.stepping.is_in_use:
            self._simulator.advance()


class TemporaryEachMessageAStep(EachMessageAStep, TemporaryService):
    pass


def running(simulator: Simulator) -> Simulator:
    """Return a simulator whose simulation has run for a while."""
    with simulator.lock:
        simulator.start()
        simulator.time = RUNNING_FOR_S
    return simulator


SESSIONS: dict[str, tuple[Callable[[], Simulator], type[Service]]] = {
    "legacy-wire.jsonl": (first_scene, EachMessageAStep),
    "legacy-wire-2.jsonl": (partial(later_scene, 180), EachMessageAStep),
    "legacy-wire-19999.jsonl": (lambda: running(later_scene(215)), TemporaryEachMessageAStep),
}


def send_all(service: Service, messages: list[bytes]) -> dict[int, Message]:
    """Return what a service answers, by the number of the message that each reply is to."""
    replies: dict[int, Message] = {}
    with socket.create_connection(("127.0.0.1", service.port)) as line, line.makefile("rb") as coming:
        line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        with suppress(OSError, struct.error):
            for message in messages:
                line.sendall(packed_up(message))
                header, commands = unpack(read_message(coming.read))
                replies[header.message] = (header, commands)
    return replies


def is_a_stop(reply: Reply) -> bool:
    return any((each.code, each.identity) == (Code.START_PAUSE_STOP_SIMULATION, STOP) for each in reply.commands)


@pytest.mark.parametrize("name", SESSIONS)
def test_every_reply_is_the_real_servers(name: str) -> None:
    scene, service_of = SESSIONS[name]
    recorded, service = session(name), service_of(scene())
    try:
        replies = send_all(service, recorded.messages)
    finally:
        service.close()
    time_ms, found = TIME_MS, list[str]()
    for reply in recorded.replies:
        real = (reply.header, reply.commands)
        found += [f"{reply.answers}: {each}" for each in differences(real, replies[reply.answers], time_ms)]
        time_ms = LAST_STEPS_MS if is_a_stop(reply) else time_ms
    assert found == []


def test_each_session_holds_replies_to_compare() -> None:
    counts = {name: len(session(name).replies) for name in SESSIONS}
    assert counts == {"legacy-wire.jsonl": 56, "legacy-wire-2.jsonl": 88, "legacy-wire-19999.jsonl": 93}


@pytest.mark.parametrize("name", SESSIONS)
def test_what_is_read_from_a_recording_is_written_the_same(name: str) -> None:
    for message in session(name).messages:
        header, commands = unpack(message)
        for command in commands:
            assert unpack(pack(header, [command])) == (header, [command])


def test_a_difference_is_reported() -> None:
    header, command = Header(3, 0, state=1), Command(Code.GET_JOINT_POSITION, 0, b"abcd", bytes(4))
    assert differences((header, [command]), (header, [command])) == []
    for other in (replace(command, status=1), replace(command, data=b"\0\0\x80?"), replace(command, sim_ms=50)):
        assert len(differences((header, [command]), (header, [other]))) == 1
    assert differences((header, [command]), (replace(header, state=0), [command])) == ["header: state 0, recorded 1"]
    assert "commands" in differences((header, [command]), (header, []))[0]
