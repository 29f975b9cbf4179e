"""What a connection makes of servers that are not there, are others, or answer nonsense."""

from __future__ import annotations

import signal
import socket
import sys
import threading
from collections.abc import Iterator
from typing import Any

import cbor
import numpy as np
import pytest
import zmq
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.coppeliasim import address as address_module
from drivers.coppeliasim.address import Address
from drivers.coppeliasim.backend import diagnose
from drivers.coppeliasim.client import Client
from drivers.coppeliasim.connection import Connection, RefusedError
from robotcore.errors import BackendError
from robotcore.hal.wall_clock import MonotonicClock
from tests.doubles.coppeliasim.double import Double
from tests.doubles.coppeliasim.scene import Simulator
from tests.doubles.coppeliasim.scenes import default_scene
from tests.doubles.coppeliasim.zmq import ZmqServer
from tests.drivers.coppeliasim.servers import ScriptedServer

ANSWER_S = 0.2
BOUND_S = 5.0
"""Against a hang only."""

INFO = {"getObjectPosition": {"func": {}}, "handle_all": {"const": -2}}


def encode(reply: object) -> bytes:
    return bytes(cbor.dumps(reply))


def greeting(message: bytes) -> bytes:
    """Answer as CoppeliaSim does when a client comes."""
    return encode({"ret": [INFO] if cbor.loads(message)["func"].endswith("info") else {}})


def connected(port: int) -> Connection:
    return Connection.open(Address(port=port), ANSWER_S)


@pytest.fixture(scope="module")
def double() -> Iterator[Double]:
    with Double(default_scene()) as double:
        yield double


@pytest.fixture(scope="module")
def babbling() -> Iterator[ScriptedServer]:
    with ScriptedServer(greeting) as server:
        yield server


def test_where_nobody_listens_it_says_what_to_start() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    with pytest.raises(BackendError, match=rf"nobody listens at 127\.0\.0\.1:{port}\. Start CoppeliaSim"):
        connected(port)


def test_doctor_names_no_option_as_its_own() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        address = Address(port=taken.getsockname()[1])
    (finding,) = diagnose(address)
    assert "nobody listens" in finding.said
    assert f"of robotcore run and check: the doctor looks at {address} alone" in finding.remedy


def test_port_where_who_listens_says_nothing_is_reported_to_iton(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("drivers.coppeliasim.address.GREETING_S", ANSWER_S)
    with (
        socket.create_server(("127.0.0.1", 0)) as silent,
        pytest.raises(BackendError, match=r"says nothing; that is not .* --backend vrep"),
    ):
        connected(silent.getsockname()[1])


def test_port_of_the_legacy_remote_api_is_reported_with_its_backend(
    double: Double, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("drivers.coppeliasim.address.GREETING_S", ANSWER_S)
    with pytest.raises(BackendError, match=r"says nothing; that is not .* --backend vrep"):
        connected(double.legacy_port)


def test_server_that_greets_and_does_not_answer_is_not_waited_for_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("drivers.coppeliasim.connection.LOADING_S", ANSWER_S)
    with zmq.Context() as context, context.socket(zmq.REP) as silent:
        port = silent.bind_to_random_port("tcp://127.0.0.1")
        with pytest.raises(BackendError, match=r"has not answered zmqRemoteApi\.require for 0\.2 s\. Look whether"):
            connected(port)


def test_host_that_is_none_is_reported() -> None:
    with pytest.raises(BackendError, match=r"nobody listens at no\.such\.host\.invalid:23000 \(\S+"):
        Connection.open(Address(host="no.such.host.invalid"), ANSWER_S)


def test_first_protocol_is_distinguished_from_its_answer() -> None:
    old = encode({"success": False, "error": "No such function: zmqRemoteApi.require"})
    with ScriptedServer(lambda _: old) as server, pytest.raises(BackendError, match=r"first protocol .* up to 4\.5"):
        connected(server.port)


def test_server_that_lets_wait_and_wait_is_left_at_the_deadline(babbling: ScriptedServer) -> None:
    babbling.reply = greeting
    connection = connected(babbling.port)
    babbling.reply = lambda _: encode({"func": "_*wait*_", "args": {}})
    with pytest.raises(BackendError, match=r"has not answered sim\.step for 0\.2 s"):
        connection.call("sim.step")
    connection.close()


def test_reply_that_names_a_function_of_the_program_runs_nothing(babbling: ScriptedServer) -> None:
    ran: list[int] = []
    sys.modules["__main__"].__dict__["victim"] = ran.append
    try:
        babbling.reply = greeting
        connection = connected(babbling.port)
        babbling.reply = lambda _: encode({"func": "victim", "args": [1]})
        with pytest.raises(BackendError, match="not CoppeliaSim's ZeroMQ remote API"):
            connection.call("sim.step")
        connection.close()
    finally:
        del sys.modules["__main__"].__dict__["victim"]
    assert ran == []


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
def test_random_and_cut_replies_are_a_named_error_or_an_answer_and_never_a_hang(
    babbling: ScriptedServer, reply: bytes
) -> None:
    babbling.reply = greeting
    clock = MonotonicClock()
    connection = connected(babbling.port)
    babbling.reply = lambda _: reply
    try:
        connection.call_as(float, "getObjectPosition", 1)
    except BackendError as error:
        assert str(error).startswith("coppeliasim: 127.0.0.1:")  # noqa: PT017  an answer that is one is fine too
    connection.close()
    assert clock.now() < BOUND_S


def test_server_side_error_is_reported_in_its_words_and_ends_nothing(double: Double) -> None:
    connection = connected(double.zmq_port)
    with pytest.raises(RefusedError, match=r"refused sim\.getObjectPosition: 354: .*object does not exist"):
        connection.sim("getObjectPosition", 999999)
    assert connection.call_as(int, "getSimulationState") == 0
    connection.close()


def test_lacking_function_is_named_and_an_older_name_is_taken(babbling: ScriptedServer) -> None:
    asked: list[tuple[str, list[Any]]] = []

    def old(message: bytes) -> bytes:
        request = cbor.loads(message)
        asked.append((request["func"], request["args"]))
        info = {**INFO, "createPureShape": {"func": {}}, "setJointMaxForce": {"func": {}}}
        return encode({"ret": [info] if request["func"].endswith("info") else [7]})

    babbling.reply = old
    connection = connected(babbling.port)
    assert connection.sim("createPrimitiveShape", 3, [1, 1, 1], 0) == 7
    connection.sim("setJointTargetForce", 1, 2.0)
    assert asked[-2:] == [
        ("sim.createPureShape", [3, 0, [1, 1, 1], 1.0]),
        ("sim.setJointMaxForce", [1, 2.0]),
    ]
    with pytest.raises(BackendError, match=r"has no sim\.getVisionSensorImg\. Install a newer one"):
        connection.sim("getVisionSensorImg", 1)
    connection.close()


def test_answer_that_is_there_counts_though_this_program_was_held_up(
    double: Double, monkeypatch: pytest.MonkeyPatch
) -> None:
    connection = connected(double.zmq_port)
    send, clock = Client._send, MonotonicClock()

    def held_up(client: Client, request: dict[str, object]) -> None:
        send(client, request)
        clock.sleep_until(clock.now() + 2 * ANSWER_S)

    monkeypatch.setattr(Client, "_send", held_up)
    assert connection.call_as(int, "getSimulationState") == 0
    monkeypatch.undo()
    connection.close()


def test_ctrl_c_is_heard_soon_where_a_server_hangs_that_may_take_long(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("drivers.coppeliasim.connection.HURRIED_S", ANSWER_S)
    clock = MonotonicClock()
    with socket.create_server(("127.0.0.1", 0)) as silent:
        pressing = threading.Timer(0.3, signal.pthread_kill, (threading.main_thread().ident, signal.SIGINT))
        pressing.start()
        with pytest.raises(KeyboardInterrupt):
            connected(silent.getsockname()[1])
        pressing.join()
    assert clock.now() < BOUND_S


def test_client_that_nobody_closed_holds_up_no_exit(double: Double) -> None:
    client = Client("127.0.0.1", double.zmq_port, 5.0)
    client.watch_disconnects()
    client.__del__()
    assert client.context.closed


def test_numbers_of_numpy_go_over_the_wire_as_pythons(double: Double) -> None:
    connection = connected(double.zmq_port)
    dummy = connection.sim("createDummy", np.float32(0.01))
    connection.sim("setObjectPosition", np.int64(dummy), np.array([1.0, 2.0, 3.0], np.float32))
    assert connection.sim("getObjectPosition", dummy) == [1.0, 2.0, 3.0]
    connection.sim("removeObjects", np.array([dummy]))
    connection.close()


def test_main_keeps_its_own_require(double: Double) -> None:
    main = sys.modules["__main__"].__dict__
    main["require"] = "mine"
    try:
        connected(double.zmq_port).close()
        assert main["require"] == "mine"
    finally:
        del main["require"]
    connected(double.zmq_port).close()
    assert "require" not in main


def test_closed_connection_asks_nobody(double: Double) -> None:
    connection = connected(double.zmq_port)
    connection.close()
    connection.close()
    with pytest.raises(BackendError, match="is closed"):
        connection.sim("getSimulationState")


VERY_LONG_S = 600.0


def connected_to(server: ZmqServer) -> Connection:
    return Connection.open(Address(port=server.port), VERY_LONG_S)


def test_server_that_is_gone_is_not_waited_for() -> None:
    with ZmqServer(Simulator()) as server:
        connection = connected_to(server)
        assert connection.sim("getSimulationTime") == 0
    with pytest.raises(BackendError, match=r"is gone; it died or was closed in sim\.getSimulationTime"):
        connection.sim("getSimulationTime")
    connection.close()


def test_server_that_was_started_again_is_not_taken_for_the_one_before() -> None:
    with ZmqServer(Simulator()) as server:
        connection = connected_to(server)
    with ZmqServer(Simulator(), server.port), pytest.raises(BackendError, match="is gone"):
        connection.sim("getSimulationTime")
    connection.close()


def test_errors_have_kinds_and_name_the_address() -> None:
    address = address_module.Address(port=23001)
    failures = [
        address_module.connection_refused(address, ConnectionRefusedError()),
        address_module.wrong_protocol(address, None),
        address_module.server_gone(address, "sim.step"),
        address_module.timed_out(address, "sim.step", 1.0, is_known=True),
        address_module.unexpected_answer(address, "sim.step", 7),
        address_module.server_too_old(address),
        address_module.function_missing(address, "sim.step"),
    ]
    assert [failure.kind for failure in failures] == [
        "connection-refused",
        "wrong-protocol",
        "server-gone",
        "timeout",
        "unexpected-answer",
        "server-too-old",
        "function-missing",
    ]
    assert {failure.fields["address"] for failure in failures} == {"127.0.0.1:23001"}
