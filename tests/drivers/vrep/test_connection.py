"""Lockstep: the messages of a time step, and the values after it."""

from __future__ import annotations

import struct
import threading
from collections.abc import Iterator

import numpy as np
import pytest

from drivers.vrep.connection import LockstepConnection, PendingRequests
from drivers.vrep.wire import requests
from drivers.vrep.wire.codec import Header, Piece
from drivers.vrep.wire.errors import RefusedError, ServerTimeoutError, SimulationHaltedError
from drivers.vrep.wire.requests import Request
from tests.doubles.coppeliasim.legacy.server import LegacyServer
from tests.doubles.coppeliasim.scene.objects import Joint
from tests.doubles.coppeliasim.scene.simulator import Simulator
from tests.texts import Raises

BODY, LEFT, RIGHT, CAMERA = 181, 182, 184, 190
UNKNOWN = 99999


@pytest.fixture
def connection(server: LegacyServer) -> Iterator[LockstepConnection]:
    with LockstepConnection.open("127.0.0.1", server.port) as connection:
        yield connection


@pytest.fixture
def stepped(connection: LockstepConnection) -> LockstepConnection:
    connection.wait_for_triggers(wait=True)
    connection.start()
    return connection


def target_of(simulator: Simulator, handle: int) -> float:
    joint = simulator.graph[handle]
    assert isinstance(joint, Joint)
    return joint.target_velocity


def test_cycle_takes_three_round_trips(stepped: LockstepConnection) -> None:
    reads = requests.joint_position(LEFT), requests.colour_image(CAMERA), requests.object_position(BODY)
    before = stepped.round_trips
    for _ in range(10):
        stepped.post(requests.joint_target_velocity(LEFT, 3.0))
        stepped.post(requests.joint_target_velocity(RIGHT, 3.0))
        step = stepped.step(*reads)
    angle, image, (x, _, _) = step.values
    assert stepped.round_trips - before == 10 * 3
    assert step.time_s == pytest.approx(0.5)
    assert angle == pytest.approx(3.0 * 0.5)
    assert x == pytest.approx(3.0 * 0.5 * 0.0325)
    assert image.shape == (12, 16, 3)


def test_step_advances_one_time_step_and_reads_the_values_after_it(
    stepped: LockstepConnection, simulator: Simulator
) -> None:
    stepped.post(requests.joint_target_velocity(LEFT, 1.0))
    for count in range(1, 20):
        step = stepped.step(requests.joint_position(LEFT))
        assert simulator.steps == count
        assert step.time_s == pytest.approx(count * simulator.time_step)
        assert step.values == (pytest.approx(count * simulator.time_step, abs=1e-6),)


def test_time_does_not_advance_between_steps(stepped: LockstepConnection) -> None:
    stepped.step()
    assert [stepped.call(requests.CLOCK) and stepped.time_s for _ in range(20)] == [0.05] * 20


def test_step_without_reads_returns_after_the_time_step(stepped: LockstepConnection, simulator: Simulator) -> None:
    assert stepped.step().values == ()
    assert simulator.steps == 1


def test_value_can_be_read_twice_in_a_step(stepped: LockstepConnection) -> None:
    first, second = stepped.step(requests.joint_position(LEFT), requests.joint_position(LEFT)).values
    assert first == second


def test_later_command_replaces_an_earlier_one(stepped: LockstepConnection, simulator: Simulator) -> None:
    for velocity in (5.0, 1.0):
        stepped.post(requests.joint_target_velocity(LEFT, velocity))
    stepped.step()
    assert target_of(simulator, LEFT) == 1.0


def test_queued_command_is_done_before_disconnecting(server: LegacyServer, simulator: Simulator) -> None:
    with LockstepConnection.open("127.0.0.1", server.port) as connection:
        connection.call(requests.joint_target_velocity(LEFT, 3.0))
        connection.post(requests.joint_target_velocity(LEFT, 0.0))
    assert target_of(simulator, LEFT) == 0.0


def test_port_is_free_after_closing(server: LegacyServer) -> None:
    for _ in range(3):
        with LockstepConnection.open("127.0.0.1", server.port) as connection:
            assert connection.call(requests.object_handle("/rover")) == BODY


@pytest.mark.parametrize("number", [np.float32(2.5), np.float64(2.5), np.array(2.5)])
def test_numbers_of_numpy_are_accepted(number: float, connection: LockstepConnection, simulator: Simulator) -> None:
    connection.call(requests.joint_target_velocity(np.int64(LEFT), number))  # type: ignore[arg-type]
    assert target_of(simulator, LEFT) == 2.5


def test_refused_command_raises_in_the_call_that_receives_the_answer(
    stepped: LockstepConnection, raises: Raises
) -> None:
    with raises(RefusedError, action=f"drive joint {UNKNOWN}"):
        stepped.call(requests.joint_target_velocity(UNKNOWN, 1.0))
    with raises(RefusedError, action=f"read the position of joint {UNKNOWN}"):
        stepped.step(requests.joint_position(LEFT), requests.joint_position(UNKNOWN))
    stepped.post(requests.joint_target_velocity(UNKNOWN, 1.0))
    with raises(RefusedError, action=f"drive joint {UNKNOWN}"):
        stepped.step()
    assert stepped.step(requests.joint_position(LEFT)).time_s > 0
    assert stepped.call(requests.LAST_ERRORS)[0] == "object does not exist. (simSetJointTargetVelocity)"


def test_step_of_a_stopped_simulation_is_an_error(connection: LockstepConnection, raises: Raises) -> None:
    connection.wait_for_triggers(wait=True)
    with raises(SimulationHaltedError, "trigger-refused"):
        connection.step()


def test_step_fails_after_the_user_has_stopped_the_simulation(
    stepped: LockstepConnection, simulator: Simulator
) -> None:
    stepped.step()
    with simulator.lock:
        simulator.stop()
    with pytest.raises(SimulationHaltedError):
        stepped.step()


def test_stop_and_start_wait_for_the_state(stepped: LockstepConnection) -> None:
    stepped.step()
    stepped.stop()
    assert not stepped.server.is_running
    assert stepped.time_s == 0.0
    stepped.wait_for_triggers(wait=True)
    stepped.start()
    assert stepped.step().time_s == pytest.approx(0.05)


def test_simulator_that_does_nothing_times_out(
    server: LegacyServer, simulator: Simulator, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    with LockstepConnection.open("127.0.0.1", server.port, 0.5) as connection:
        monkeypatch.setattr("tests.doubles.coppeliasim.legacy.client.Client.turn", lambda _: None)
        with raises(ServerTimeoutError, "simulator-busy", timeout_s=0.5):
            connection.call(requests.CLOCK)


def test_calls_from_several_threads_get_their_own_answers(connection: LockstepConnection) -> None:
    names = {"/rover": BODY, "/rover/leftMotor": LEFT, "/rover/rightMotor": RIGHT, "/rover/camera": CAMERA}
    wrong: list[str] = []

    def ask(name: str) -> None:
        answers = (connection.call(requests.object_handle(name)) for _ in range(20))
        wrong.extend(name for answer in answers if answer != names[name])

    threads = [threading.Thread(target=ask, args=(name,)) for name in names]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []


def test_image_has_the_pixels_of_the_sensor_and_is_read_only(stepped: LockstepConnection) -> None:
    pixels = np.arange(12 * 16 * 3, dtype=np.uint8)
    image = stepped.step(requests.colour_image(CAMERA)).values[0]
    grey = stepped.call(requests.grey_image(CAMERA))
    assert image.size == pixels.size
    assert (grey == (image.astype(int).sum(axis=2) // 3)).all()
    assert not image.flags.writeable


def test_image_of_the_wrong_size_is_refused(stepped: LockstepConnection, raises: Raises) -> None:
    with raises(RefusedError, action=f"show an image on vision sensor {CAMERA}"):
        stepped.call(requests.set_colour_image(CAMERA, struct.pack("3B", 1, 2, 3)))


RUNNING, PAUSED = 1, 3
JOINT = requests.joint_position(7)
TRIGGER = 5


@pytest.fixture
def answers() -> PendingRequests:
    return PendingRequests([JOINT], TRIGGER)


def server(message: int, state: int = RUNNING) -> Header:
    return Header(11, message, 0, 0, 0, state)


def piece(request: Request[object], time_ms: int, *, failed: bool = False) -> Piece:
    return Piece(request.command, request.key, 0, time_ms, failed, memoryview(bytes(4)), 0, 4)


def test_value_from_before_the_step_is_requested_again(answers: PendingRequests) -> None:
    assert answers.take_unsent(6) == [JOINT]
    answers.receive(server(6), [piece(requests.TRIGGER, 100), piece(JOINT, 100)])
    assert not answers.is_complete
    assert answers.take_unsent(7) == [JOINT]
    answers.receive(server(7), [piece(JOINT, 150)])
    assert answers.is_complete
    assert answers[JOINT].time_ms == 150


def test_pending_request_is_not_sent_again(answers: PendingRequests) -> None:
    assert [answers.take_unsent(6), answers.take_unsent(7)] == [[JOINT], []]


def test_answer_to_an_earlier_request_is_ignored(answers: PendingRequests) -> None:
    answers.take_unsent(6)
    answers.receive(server(5), [piece(requests.TRIGGER, 100), piece(JOINT, 150)])
    assert not answers.is_complete
    answers.receive(server(6), [piece(JOINT, 150)])
    assert answers.is_complete


def test_trigger_of_an_earlier_step_is_ignored(answers: PendingRequests) -> None:
    answers.take_unsent(6)
    answers.receive(server(4), [piece(requests.TRIGGER, 50, failed=True)])
    answers.receive(server(6), [piece(JOINT, 150)])
    assert not answers.is_complete


def test_refused_trigger_is_an_error(answers: PendingRequests, raises: Raises) -> None:
    with raises(SimulationHaltedError, "trigger-refused"):
        answers.receive(server(5), [piece(requests.TRIGGER, 0, failed=True)])


def test_first_answer_counts_without_a_trigger() -> None:
    answers = PendingRequests([JOINT])
    answers.take_unsent(0)
    answers.receive(server(0, state=0), [piece(JOINT, 0)])
    assert answers.is_complete


@pytest.mark.parametrize("state, kind", [(0, "simulation-stopped"), (PAUSED, "simulation-paused")])
def test_halt_before_the_step_is_an_error(state: int, kind: str, answers: PendingRequests, raises: Raises) -> None:
    answers.receive(server(5), [piece(requests.TRIGGER, 100)])
    with raises(SimulationHaltedError, kind):
        answers.receive(server(6, state), [])
