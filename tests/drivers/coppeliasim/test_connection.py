"""Tests of connections to servers that are absent, slow, or send invalid answers, or that have another protocol."""

from __future__ import annotations

import signal
import socket
import sys
import threading
from collections.abc import Iterator
from typing import Any

import cbor
import pytest
import zmq
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.coppeliasim.address import Address, RefusedError
from drivers.coppeliasim.backend import diagnose
from drivers.coppeliasim.client import Client
from drivers.coppeliasim.connection import SimulatorConnection
from robotcore.errors import BackendError
from robotcore.hal.wall_clock import MonotonicClock
from tests.doubles.coppeliasim.double import Double
from tests.doubles.coppeliasim.scene import Simulator
from tests.doubles.coppeliasim.scenes import default_scene
from tests.doubles.coppeliasim.zmq import ZmqServer
from tests.drivers.coppeliasim.servers import ScriptedServer
from tests.texts import CheckText, Raises

ANSWER_S = 0.2
BOUND_S = 5.0
"""The time after which a call counts as hanging, in seconds."""

INFO = {"getObjectPosition": {"func": {}}, "handle_all": {"const": -2}}


def encode(reply: object) -> bytes:
    return bytes(cbor.dumps(reply))


def greet(message: bytes) -> bytes:
    """Answer the messages of a new client as CoppeliaSim does."""
    return encode({"ret": [INFO] if cbor.loads(message)["func"].endswith("info") else {}})


def connect(port: int) -> SimulatorConnection:
    return SimulatorConnection.open(Address(port=port), ANSWER_S)


@pytest.fixture(scope="module")
def double() -> Iterator[Double]:
    with Double(default_scene()) as double:
        yield double


@pytest.fixture(scope="module")
def scripted() -> Iterator[ScriptedServer]:
    with ScriptedServer(greet) as server:
        yield server


def test_address_without_a_server_is_an_error(raises: Raises) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    with raises(BackendError, "connection-refused", hide=[port], address=f"127.0.0.1:{port}"):
        connect(port)


def test_doctor_explains_that_the_options_are_of_other_commands(check_text: CheckText) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        address = Address(port=taken.getsockname()[1])
    (finding,) = diagnose(address)
    assert finding.kind == "connection-refused"
    check_text(f"{finding.message}. {finding.remedy}", hide=[address.port])


def test_port_of_the_legacy_remote_api_is_an_error(
    double: Double, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.setattr("drivers.coppeliasim.address.GREETING_S", ANSWER_S)
    with raises(BackendError, "wrong-protocol", hide=[double.legacy_port]):
        connect(double.legacy_port)


def test_server_that_greets_and_does_not_answer_times_out(monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    monkeypatch.setattr("drivers.coppeliasim.connection.LOADING_S", ANSWER_S)
    with zmq.Context() as context, context.socket(zmq.REP) as silent:
        port = silent.bind_to_random_port("tcp://127.0.0.1")
        with raises(BackendError, "timeout", hide=[port], function="zmqRemoteApi.require", limit_s=ANSWER_S):
            connect(port)


def test_server_of_the_first_protocol_is_too_old(raises: Raises) -> None:
    old = encode({"success": False, "error": "No such function: zmqRemoteApi.require"})
    with ScriptedServer(lambda _: old) as server, raises(BackendError, "server-too-old", hide=[server.port]):
        connect(server.port)


def test_server_that_sends_wait_without_end_times_out(scripted: ScriptedServer, raises: Raises) -> None:
    scripted.reply = greet
    connection = connect(scripted.port)
    scripted.reply = lambda _: encode({"func": "_*wait*_", "args": {}})
    with raises(BackendError, "timeout", hide=[scripted.port], function="sim.step", limit_s=ANSWER_S):
        connection.call("sim.step")
    connection.close()


def test_reply_that_names_a_function_of_the_program_runs_nothing(scripted: ScriptedServer, raises: Raises) -> None:
    ran: list[int] = []
    sys.modules["__main__"].__dict__["victim"] = ran.append
    try:
        scripted.reply = greet
        connection = connect(scripted.port)
        scripted.reply = lambda _: encode({"func": "victim", "args": [1]})
        with raises(BackendError, "unexpected-answer", hide=[scripted.port], function="sim.step"):
            connection.call("sim.step")
        connection.close()
    finally:
        del sys.modules["__main__"].__dict__["victim"]
    assert ran == []


def test_deeply_nested_reply_is_an_error(scripted: ScriptedServer, raises: Raises) -> None:
    scripted.reply = greet
    connection = connect(scripted.port)
    scripted.reply = lambda _: b"\x81" * 300_000 + b"\0"
    with raises(BackendError, "unexpected-answer", hide=[scripted.port], function="sim.step"):
        connection.call("sim.step")
    connection.close()


@pytest.mark.slow
@given(
    st.one_of(
        st.binary(max_size=40),
        st.integers(0, 200).map(lambda cut: encode({"ret": [INFO, "x" * 99]})[:cut]),
        st.recursive(
            st.one_of(st.none(), st.integers(-(2**63), 2**63), st.floats(), st.text(max_size=5), st.binary(max_size=5)),
            lambda part: st.lists(part, max_size=4) | st.dictionaries(st.sampled_from(["ret", "func", "args"]), part),
            max_leaves=8,
        ).map(encode),
    )
)
@settings(max_examples=150, deadline=None)
def test_random_and_cut_replies_never_hang_or_raise_other_errors(scripted: ScriptedServer, reply: bytes) -> None:
    scripted.reply = greet
    clock = MonotonicClock()
    connection = connect(scripted.port)
    scripted.reply = lambda _: reply
    try:
        connection.call_as(float, "getObjectPosition", 1)
    except BackendError as error:
        assert error.fields["address"] == f"127.0.0.1:{scripted.port}"  # noqa: PT017  some replies are valid
    connection.close()
    assert clock.now() < BOUND_S


def test_error_of_the_server_does_not_end_the_connection(double: Double, raises: Raises) -> None:
    connection = connect(double.zmq_port)
    with raises(RefusedError, hide=[double.zmq_port], function="sim.getObjectPosition"):
        connection.sim("getObjectPosition", 999999)
    assert connection.call_as(int, "getSimulationState") == 0
    connection.close()


def test_older_names_are_called_and_a_missing_function_is_an_error(scripted: ScriptedServer, raises: Raises) -> None:
    calls: list[tuple[str, list[Any]]] = []

    def answer_as_old(message: bytes) -> bytes:
        request = cbor.loads(message)
        calls.append((request["func"], request["args"]))
        info = {**INFO, "writeCustomDataBlock": {"func": {}}, "readCustomDataBlock": {"func": {}}}
        return encode({"ret": [info] if request["func"].endswith("info") else [7]})

    scripted.reply = answer_as_old
    connection = connect(scripted.port)
    assert connection.sim("readCustomStringData", 3, "tag") == 7
    connection.sim("writeCustomStringData", 3, "tag", "note")
    assert calls[-2:] == [
        ("sim.readCustomDataBlock", [3, "tag"]),
        ("sim.writeCustomDataBlock", [3, "tag", "note"]),
    ]
    with raises(BackendError, "function-missing", hide=[scripted.port], function="sim.getVisionSensorImg"):
        connection.sim("getVisionSensorImg", 1)
    connection.close()


@pytest.mark.slow
def test_ctrl_c_ends_a_long_call_soon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("drivers.coppeliasim.connection.INTERRUPTED_S", ANSWER_S)
    clock = MonotonicClock()
    with socket.create_server(("127.0.0.1", 0)) as silent:
        pressing = threading.Timer(0.3, signal.pthread_kill, (threading.main_thread().ident, signal.SIGINT))
        pressing.start()
        with pytest.raises(KeyboardInterrupt):
            connect(silent.getsockname()[1])
        pressing.join()
    assert clock.now() < BOUND_S


def test_client_that_was_not_closed_does_not_delay_the_exit(double: Double) -> None:
    client = Client(Address(port=double.zmq_port), 5.0)
    client.watch_disconnects()
    client.__del__()
    assert client.context.closed


def test_main_keeps_its_own_require(double: Double) -> None:
    main = sys.modules["__main__"].__dict__
    main["require"] = "mine"
    try:
        connect(double.zmq_port).close()
        assert main["require"] == "mine"
    finally:
        del main["require"]
    connect(double.zmq_port).close()
    assert "require" not in main


def test_closed_connection_raises(double: Double, raises: Raises) -> None:
    connection = connect(double.zmq_port)
    connection.close()
    connection.close()
    with raises(BackendError, "connection-closed", hide=[double.zmq_port]):
        connection.sim("getSimulationState")


VERY_LONG_S = 600.0


def connect_to(server: ZmqServer) -> SimulatorConnection:
    return SimulatorConnection.open(Address(port=server.port), VERY_LONG_S)


def test_call_to_a_server_that_has_ended_fails_at_once(raises: Raises) -> None:
    with ZmqServer(Simulator()) as server:
        connection = connect_to(server)
        assert connection.sim("getSimulationTime") == 0
    with raises(BackendError, "server-gone", hide=[server.port], function="sim.getSimulationTime"):
        connection.sim("getSimulationTime")
    connection.close()


def test_connection_does_not_continue_with_a_restarted_server(raises: Raises) -> None:
    with ZmqServer(Simulator()) as server:
        connection = connect_to(server)
    with ZmqServer(Simulator(), server.port), raises(BackendError, "server-gone", hide=[server.port]):
        connection.sim("getSimulationTime")
    connection.close()
