"""The functions of `drivers.vrep.simx`: codes, operation modes and types as in the official binding."""

from __future__ import annotations

import inspect
import struct
import threading
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from drivers.vrep import simx
from drivers.vrep.simx.clients import CLIENTS
from drivers.vrep.wire.requests import Request
from robotcore.hal.wall_clock import MonotonicClock
from tests.doubles.coppeliasim.legacy.faults import Hang, SendGarbage
from tests.doubles.coppeliasim.legacy.server import LegacyServer
from tests.doubles.coppeliasim.scene import Simulator
from tests.doubles.coppeliasim.scene.graph import Graph
from tests.doubles.coppeliasim.scene.objects import Joint, VisionSensor
from tests.texts import CheckText

LEFT, CAMERA, UNKNOWN = 182, 190, 99999
PATIENCE_S = 5.0
WAIT = simx.simx_opmode_blocking


@pytest.fixture
def client(server: LegacyServer) -> int:
    return start(server.port)


@pytest.fixture
def screen() -> Iterator[LegacyServer]:
    graph = Graph()
    graph.add(VisionSensor("v1", width=4, height=2, takes_external_pictures=True))
    with LegacyServer(Simulator(graph)) as server:
        yield server


def start(port: int, *, reconnects: bool = False, timeout_ms: int = 5000) -> int:
    """Start a client, and wait for the server's first answer."""
    client = simx.simxStart("127.0.0.1", port, True, not reconnects, timeout_ms, 1)
    simx.simxGetPingTime(client)
    return client


def wait_for(condition: Callable[[], object]) -> None:
    clock = MonotonicClock()
    while not condition():
        assert clock.now() < PATIENCE_S
        clock.sleep_until(clock.now() + 0.002)


def target(simulator: Simulator) -> float:
    joint = simulator.graph[LEFT]
    assert isinstance(joint, Joint)
    return joint.target_velocity


def test_client_does_not_start_without_a_server(unused_port: int) -> None:
    assert start(unused_port, timeout_ms=100) == -1
    assert start(unused_port, reconnects=True, timeout_ms=100) == -1
    assert simx.simxStart("127.0.0.1", -3, True, True, 100, 5) == -1


@pytest.mark.parametrize("client", [-1, 0, 300])
def test_unknown_client_returns_a_code(client: int) -> None:
    assert simx.simxGetJointPosition(client, 1, WAIT) == (64, 0.0)
    assert simx.simxSetJointTargetVelocity(client, 1, 1.0, WAIT) == 64
    assert simx.simxGetVisionSensorImage(client, 1, 0, WAIT) == (64, [], [])
    assert simx.simxReadProximitySensor(client, 1, WAIT) == (64, False, [0.0] * 3, 0, [0.0] * 3)
    assert simx.simxGetConnectionId(client) == -1
    assert simx.simxGetInMessageInfo(client, simx.simx_headeroffset_server_time) == (-1, 0)
    simx.simxFinish(client)


def test_client_gets_the_lowest_free_number_and_an_address_has_one_client(
    server: LegacyServer, screen: LegacyServer
) -> None:
    assert [start(server.port), start(screen.port), start(server.port)] == [0, 1, -1]
    simx.simxFinish(0)
    assert start(server.port) == 0


def test_finish_of_minus_one_ends_all_clients_and_threads(server: LegacyServer, screen: LegacyServer) -> None:
    before = threading.active_count()
    clients = start(server.port), start(screen.port)
    simx.simxFinish(-1)
    assert [simx.simxGetConnectionId(client) for client in clients] == [-1, -1]
    assert threading.active_count() == before


def test_stream_continues_until_it_is_discontinued(client: int) -> None:
    simx.simxStartSimulation(client, WAIT)
    simx.simxSetJointTargetVelocity(client, LEFT, 1.0, WAIT)
    assert simx.simxGetJointPosition(client, LEFT, simx.simx_opmode_buffer) == (1, 0.0)
    assert simx.simxGetJointPosition(client, LEFT, simx.simx_opmode_streaming) == (1, 0.0)
    wait_for(lambda: simx.simxGetJointPosition(client, LEFT, simx.simx_opmode_buffer)[1] > 0.1)
    assert simx.simxGetLastCmdTime(client) > 0
    simx.simxGetJointPosition(client, LEFT, simx.simx_opmode_discontinue)
    wait_for(lambda: simx.simxGetJointPosition(client, LEFT, simx.simx_opmode_buffer) == (1, 0.0))


def test_removed_answer_comes_again_with_its_stream(client: int) -> None:
    def position(mode: int) -> int:
        return simx.simxGetObjectPosition(client, LEFT, -1, mode)[0]

    position(simx.simx_opmode_streaming)
    wait_for(lambda: position(simx.simx_opmode_buffer) == 0)
    simx.simxPauseCommunication(client, True)
    assert [position(simx.simx_opmode_remove) for _ in range(20)][-1] == 1
    simx.simxPauseCommunication(client, False)
    wait_for(lambda: position(simx.simx_opmode_buffer) == 0)


def test_answer_to_a_blocking_call_is_returned_once(client: int) -> None:
    assert simx.simxGetJointPosition(client, LEFT, WAIT) == (0, 0.0)
    assert simx.simxGetJointPosition(client, LEFT, simx.simx_opmode_buffer) == (1, 0.0)


def test_oneshot_command_returns_the_code_of_the_previous_answer(client: int) -> None:
    oneshot = simx.simx_opmode_oneshot
    assert simx.simxSetJointTargetVelocity(client, LEFT, 1.0, oneshot) == 1
    assert simx.simxSetJointTargetVelocity(client, UNKNOWN, 1.0, oneshot) == 1
    simx.simxGetPingTime(client)
    assert simx.simxSetJointTargetVelocity(client, LEFT, 1.0, oneshot) == 0
    assert simx.simxSetJointTargetVelocity(client, UNKNOWN, 1.0, oneshot) == 8
    _, errors = simx.simxGetLastErrors(client, WAIT)
    assert errors[0] == "object does not exist. (simSetJointTargetVelocity)"
    assert simx.simxGetJointPosition(client, LEFT, 0x90000) == (4, 0.0)
    assert simx.simxReadStringStream(client, "s", WAIT) == (4, bytearray())
    assert simx.simxReadStringStream(client, "s", simx.simx_opmode_streaming) == (1, bytearray())


def test_commands_of_a_pause_are_sent_in_one_message(client: int, simulator: Simulator) -> None:
    simx.simxGetPingTime(client)
    simx.simxPauseCommunication(client, True)
    _, before = simx.simxGetOutMessageInfo(client, simx.simx_headeroffset_message_id)
    for handle in (LEFT, LEFT + 2):
        simx.simxSetJointTargetVelocity(client, handle, 2.0, simx.simx_opmode_oneshot)
    _, after = simx.simxGetOutMessageInfo(client, simx.simx_headeroffset_message_id)
    assert after - before <= 1
    simx.simxPauseCommunication(client, False)
    wait_for(lambda: target(simulator) == 2.0)


@pytest.mark.parametrize("mode", ["hangs", "garbage", "lost"])
def test_failing_server_gives_codes_and_no_exceptions(mode: str, server: LegacyServer) -> None:
    client = start(server.port, timeout_ms=-200)
    if mode == "lost":
        server.service.disconnect()
    else:
        server.service.fail(Hang() if mode == "hangs" else SendGarbage(b"?" * 100))
    assert simx.simxGetJointPosition(client, LEFT, WAIT) == (3, 0.0)
    assert simx.simxGetJointPosition(client, LEFT, simx.simx_opmode_oneshot) == (1, 0.0)
    server.service.fail(None)


def test_client_reconnects(server: LegacyServer) -> None:
    client = start(server.port, reconnects=True)
    assert simx.simxGetConnectionId(client) == 1
    server.service.disconnect()
    wait_for(lambda: simx.simxGetConnectionId(client) == 2)
    assert simx.simxGetObjectHandle(client, "/rover/leftMotor", WAIT) == (0, LEFT)


@pytest.mark.parametrize(
    "image",
    [
        list(range(-12, 12)),
        [value & 0xFF for value in range(-12, 12)],
        np.arange(-12, 12, dtype=np.int8),
        np.arange(-12, 12).astype(np.uint8).reshape(2, 4, 3),
        bytes(value & 0xFF for value in range(-12, 12)),
        bytearray(value & 0xFF for value in range(-12, 12)),
    ],
    ids=["signed list", "unsigned list", "signed array", "unsigned array", "bytes", "bytearray"],
)
def test_image_of_any_type_is_read_back_as_signed_bytes(image: object, screen: LegacyServer) -> None:
    client = start(screen.port)
    _, handle = simx.simxGetObjectHandle(client, "v1", WAIT)
    assert simx.simxSetVisionSensorImage(client, handle, image, 0, WAIT) == 0
    assert simx.simxGetVisionSensorImage(client, handle, 0, WAIT) == (0, [4, 2], list(range(-12, 12)))


def test_grey_image_has_one_byte_a_pixel(screen: LegacyServer) -> None:
    client = start(screen.port)
    _, handle = simx.simxGetObjectHandle(client, "v1", WAIT)
    assert simx.simxSetVisionSensorImage(client, handle, list(range(8)), 1, WAIT) == 0
    assert simx.simxGetVisionSensorImage(client, handle, 1, WAIT) == (0, [4, 2], list(range(8)))
    assert simx.simxSetVisionSensorImage(client, handle, list(range(8)), 0, WAIT) == 8
    with pytest.raises(TypeError):
        simx.simxSetVisionSensorImage(client, handle, [0.5] * 8, 1, WAIT)


def test_message_fields_are_available(client: int) -> None:
    simx.simxStartSimulation(client, WAIT)
    assert simx.simxGetInMessageInfo(client, simx.simx_headeroffset_version) == (1, 11)
    wait_for(lambda: simx.simxGetPingTime(client) and simx.simxGetInMessageInfo(client, 17)[1] & 1)
    assert simx.simxGetInMessageInfo(client, 99) == (-1, 0)
    assert simx.simxGetOutMessageInfo(client, simx.simx_headeroffset_version) == (1, 11)


class RecordingClient:
    """A client that records requests, and has no answers."""

    def __init__(self) -> None:
        self.requests: list[tuple[int, bytes, bytes]] = []

    def execute(self, request: Request[object], _mode: int) -> tuple[int, None]:
        self.requests.append((request.command, request.key, request.data))
        return simx.simx_return_ok, None


@pytest.mark.parametrize(
    "function, arguments, request_, value",
    [
        (simx.simxGetObjectHandle, ("v0\0v1",), (0x3001, b"v0\0", b""), 0),
        (simx.simxGetObjectPosition, (7, -1), (0x200E, struct.pack("<2i", 7, -1), b""), [0.0] * 3),
        (
            simx.simxSetObjectPosition,
            (7, -1, (1, 2, 3)),
            (0x101B, struct.pack("<i", 7), struct.pack("<i3f", -1, 1, 2, 3)),
            None,
        ),
        (simx.simxSetObjectParent, (7, 5, 2), (0x101C, struct.pack("<i", 7), struct.pack("<iB", 5, 1)), None),
        (simx.simxGetObjects, (5,), (0x102A, struct.pack("<i", 5), b""), []),
        (simx.simxGetBoolParam, (25,), (0x101F, struct.pack("<i", 25), b""), False),
        (simx.simxSetBoolParam, (25, 7), (0x1020, struct.pack("<i", 25), struct.pack("<i", 1)), None),
        (simx.simxSetFloatParam, (1, 0.5), (0x1024, struct.pack("<i", 1), struct.pack("<f", 0.5)), None),
        (simx.simxGetStringParam, (13,), (0x1025, struct.pack("<i", 13), b""), ""),
        (simx.simxGetInt32Signal, ("s",), (0x3011, b"s\0", b""), 0),
        (simx.simxSetStringSignal, ("s", "a\0b"), (0x3015, b"s\0", b"a\0b"), None),
        (simx.simxCloseScene, (), (0x0005, b"", b""), None),
    ],
    ids=lambda value: value.__name__ if callable(value) else "",
)
def test_function_sends_its_command_and_returns_zero_without_an_answer(
    function: Callable[..., object],
    arguments: tuple[object, ...],
    request_: tuple[int, bytes, bytes],
    value: object,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    client = RecordingClient()
    monkeypatch.setattr(CLIENTS, "get", lambda _number: client)
    names = list(inspect.signature(function).parameters)
    expected = 0 if value is None else (0, value)
    assert function(0, *arguments, WAIT) == expected
    assert function(**dict(zip(names, (0, *arguments, WAIT), strict=True))) == expected
    assert client.requests == [request_] * 2


def test_function_has_a_name_a_signature_and_a_docstring() -> None:
    function = simx.simxSetIntegerSignal
    assert function is simx.simxSetInt32Signal
    assert (function.__name__, function.__doc__) == (
        "simxSetInt32Signal",
        "Send the command, and return the return code.",
    )
    assert str(inspect.signature(function)) == (
        "(clientID: int, signalName: str | bytes, signalValue: int, operationMode: int) -> int"
    )
    assert inspect.signature(simx.simxGetObjectPosition).return_annotation == tuple[int, list[float]]


@pytest.mark.parametrize("arguments", [(0, 17), (0, 17, WAIT, 1)], ids=["too few", "too many"])
def test_wrong_number_of_arguments_is_an_error_with_the_parameters(
    arguments: tuple[int, ...], check_text: CheckText
) -> None:
    with pytest.raises(TypeError) as caught:
        simx.simxGetJointPosition(*arguments)
    check_text(caught.value)


def test_packed_numbers_are_unpacked() -> None:
    assert simx.simxUnpackInts(simx.simxPackInts([1, -2])) == [1, -2]
    assert simx.simxUnpackFloats(simx.simxPackFloats([0.5, -2.0])) == [0.5, -2.0]


def test_missing_function_is_an_error_with_an_alternative(check_text: CheckText) -> None:
    with pytest.raises(AttributeError) as caught:
        simx.simxLoadUI  # noqa: B018
    check_text(caught.value)
    assert not hasattr(simx, "loadUI")
