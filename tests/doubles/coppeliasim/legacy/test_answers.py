"""Answers to single commands, compared byte by byte."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator

import numpy as np
import pytest

from tests.doubles.coppeliasim.legacy.codec import Code, Command, Mode
from tests.doubles.coppeliasim.legacy.comparison import RawClient, floats, ints, name
from tests.doubles.coppeliasim.legacy.functions import ALL
from tests.doubles.coppeliasim.legacy.recorded import AHEAD, later_scene
from tests.doubles.coppeliasim.legacy.server import LegacyServer
from tests.doubles.coppeliasim.scene.objects import ProximitySensor, Shape, Type, VisionSensor
from tests.doubles.coppeliasim.scene.poses import Transform
from tests.doubles.coppeliasim.scene.simulator import Simulator

BODY, LEFT, CAMERA, BOX, NOSE, SCREEN = 181, 182, 190, 191, 192, 193
ROWS, COLUMNS = 12, 16
WHEEL_RADIUS_M, TRACK_M = 0.0325, 0.16


@pytest.fixture
def simulator() -> Simulator:
    simulator = later_scene(180)
    graph = simulator.graph
    box = graph.add(Shape("box", size=(0.2, 0.2, 0.4)))
    graph.put(box, Transform((0.6, 0.0, 0.2)))
    nose = graph.add(ProximitySensor("nose", reach=2.0), graph[BODY])
    graph.put(nose, Transform((0.1, 0.0, 0.06), AHEAD))
    graph.add(VisionSensor("v1", width=COLUMNS, height=ROWS, takes_external_pictures=True))
    graph[LEFT].flat_name = "bubbleRob_leftMotor"
    return simulator


@pytest.fixture
def client(simulator: Simulator) -> Iterator[RawClient]:
    with LegacyServer(simulator) as server, RawClient(server.port) as talker:
        yield talker


@pytest.mark.parametrize("path", ["/rover/leftMotor", "/leftMotor", "leftMotor", "bubbleRob_leftMotor"])
def test_object_is_found_by_path_alias_and_old_name(client: RawClient, path: str) -> None:
    reply = client.execute(Code.GET_OBJECT_HANDLE, name(path))
    assert (reply.data, reply.status) == (ints(LEFT), 0)


def test_missing_object_is_an_error_with_a_text(client: RawClient) -> None:
    reply = client.execute(Code.GET_OBJECT_HANDLE, name("/nope"))
    assert (reply.data, reply.status) == (ints(-1), 1)
    client.execute(Code.SET_JOINT_TARGET_VELOCITY, ints(BODY), floats(1.0))
    errors = client.execute(Code.GET_LAST_ERRORS).data
    assert errors[:4] == ints(2)
    assert errors.endswith(b"object is not a joint. (simSetJointTargetVelocity)\0")
    assert client.execute(Code.GET_LAST_ERRORS).data == ints(0)


def test_layout_of_a_detection(client: RawClient) -> None:
    reply = client.execute(Code.READ_PROXIMITY_SENSOR, ints(NOSE))
    seen, *numbers = struct.unpack("<b3fi3f", reply.data)
    point, handle, normal = numbers[:3], numbers[3], numbers[4:]
    assert (reply.status, seen, handle) == (0, 1, BOX)
    assert np.linalg.norm(point) == pytest.approx(0.4, abs=1e-6)
    assert normal == pytest.approx([0, 0, -1], abs=1e-6)


def test_without_a_detection_only_the_first_byte_is_valid(client: RawClient, simulator: Simulator) -> None:
    with simulator.lock:
        simulator.graph.put(simulator.graph[BOX], Transform((-3.0, 0.0, 0.2)))
    reply = client.execute(Code.READ_PROXIMITY_SENSOR, ints(NOSE))
    assert (reply.status, reply.data[0], len(reply.data)) == (0, 0, 29)
    assert any(reply.data)


def test_shown_picture_is_read_back_in_colour_and_grey(client: RawClient) -> None:
    pixels = np.random.default_rng(1).integers(0, 256, (ROWS, COLUMNS, 3), np.uint8)
    assert client.execute(Code.SET_VISION_SENSOR_IMAGE_RGB, ints(SCREEN), pixels.tobytes()).status == 0
    colour = client.execute(Code.GET_VISION_SENSOR_IMAGE_RGB, ints(SCREEN)).data
    grey = client.execute(Code.GET_VISION_SENSOR_IMAGE_BW, ints(SCREEN)).data
    assert colour == ints(COLUMNS, ROWS) + pixels.tobytes()
    assert grey == ints(COLUMNS, ROWS) + (pixels.astype(int).sum(axis=2) // 3).astype(np.uint8).tobytes()


def test_grey_picture_is_shown_in_all_colours(client: RawClient) -> None:
    pixels = bytes(range(ROWS * COLUMNS))
    assert client.execute(Code.SET_VISION_SENSOR_IMAGE_BW, ints(SCREEN), pixels).status == 0
    colour = client.execute(Code.GET_VISION_SENSOR_IMAGE_RGB, ints(SCREEN)).data[8:]
    assert (colour[::3], colour[1::3], colour[2::3]) == (pixels, pixels, pixels)


def test_picture_of_another_size_is_refused(client: RawClient) -> None:
    assert client.execute(Code.SET_VISION_SENSOR_IMAGE_RGB, ints(SCREEN), bytes(ROWS * COLUMNS)).status == 1


def test_position_and_orientation_are_set(client: RawClient) -> None:
    client.execute(Code.SET_OBJECT_POSITION, ints(BOX), ints(BODY) + floats(0.5, 0.25, 0.0))
    client.execute(Code.SET_OBJECT_ORIENTATION, ints(BOX), ints(-1) + floats(0.0, 0.0, 0.5))
    position = client.execute(Code.GET_OBJECT_POSITION, ints(BOX, -1)).data
    orientation = client.execute(Code.GET_OBJECT_ORIENTATION, ints(BOX, -1)).data
    assert struct.unpack("<3f", position) == pytest.approx((0.5, 0.25, 0.06))
    assert struct.unpack("<3f", orientation) == pytest.approx((0.0, 0.0, 0.5))


def test_velocity_is_linear_then_angular_in_the_world(client: RawClient, simulator: Simulator) -> None:
    client.execute(Code.SYNCHRONOUS_ENABLE)
    client.execute(Code.START_PAUSE_STOP_SIMULATION, ints(0))
    for joint, speed in ((LEFT, 1.0), (LEFT + 2, 3.0)):
        client.execute(Code.SET_JOINT_TARGET_VELOCITY, ints(joint), floats(speed))
    client.execute(Code.SYNCHRONOUS_NEXT)
    velocity = struct.unpack("<6f", client.execute(Code.GET_OBJECT_VELOCITY, ints(BODY)).data)
    turn = 2 * WHEEL_RADIUS_M / TRACK_M
    heading = turn * simulator.time_step
    ahead = (2 * WHEEL_RADIUS_M * math.cos(heading), 2 * WHEEL_RADIUS_M * math.sin(heading))
    assert velocity == pytest.approx((*ahead, 0.0, 0.0, 0.0, turn), abs=1e-6)
    assert client.execute(Code.GET_OBJECT_VELOCITY, ints(BOX)).data == bytes(24)


def test_signal_is_stored_until_it_is_cleared(client: RawClient) -> None:
    client.execute(Code.SET_FLOAT_SIGNAL, name("speed"), floats(1.5))
    assert client.execute(Code.GET_FLOAT_SIGNAL, name("speed")).data == floats(1.5)
    client.execute(Code.CLEAR_FLOAT_SIGNAL, name("speed"))
    assert client.execute(Code.GET_FLOAT_SIGNAL, name("speed")).status == 1


def test_parent_is_minus_one_without_one(client: RawClient) -> None:
    assert client.execute(Code.GET_OBJECT_PARENT, ints(LEFT)).data == ints(BODY)
    assert client.execute(Code.GET_OBJECT_PARENT, ints(BODY)).data == ints(-1)


def test_children_by_index_end_with_minus_one(client: RawClient) -> None:
    children = [client.execute(Code.GET_OBJECT_CHILD, ints(LEFT, index)).data for index in (0, 1)]
    assert children == [ints(LEFT + 1), ints(-1)]


def test_objects_of_a_type_are_counted_and_listed(client: RawClient) -> None:
    assert client.execute(Code.GET_OBJECTS, ints(Type.VISION_SENSOR)).data == ints(2, CAMERA, SCREEN)
    assert client.execute(Code.GET_OBJECTS, ints(ALL)).data[:4] == ints(14)


@pytest.mark.parametrize("said", [b"", b"\0", b"\xff" * 9])
def test_invalid_commands_are_answered(client: RawClient, said: bytes) -> None:
    codes = sorted(set(Code) - {Code.KILL_CONNECTION})
    assert [client.execute(code, said, said).code for code in codes] == codes


def test_command_without_data_is_refused(client: RawClient) -> None:
    assert client.execute(Code.SET_JOINT_TARGET_VELOCITY, ints(LEFT), b"\0\0").status == 1
    assert client.execute(Code.GET_JOINT_POSITION, b"\0\0").status == 1


def test_unknown_command_is_an_error_and_returned(client: RawClient) -> None:
    client.exchange(Command(0x3401, Mode.BLOCKING, b"name\0", b"data"))
    _, (reply,) = client.exchange()
    assert (reply.identity, reply.data, reply.status) == (b"name\0", b"data", 1)
