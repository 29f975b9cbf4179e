"""Lockstep with a simulator: what a step sends, and what is read after it."""

from __future__ import annotations

import struct
import threading
from collections.abc import Iterator

import numpy as np
import pytest

from drivers.vrep.connection import Connection, PendingRequests
from drivers.vrep.wire import requests
from drivers.vrep.wire.codec import Header, Piece
from drivers.vrep.wire.errors import RefusedError, ServerHangsError, SimulationHaltedError
from drivers.vrep.wire.requests import Request
from tests.doubles.coppeliasim.legacy.server import LegacyServer
from tests.doubles.coppeliasim.scene.objects import Joint
from tests.doubles.coppeliasim.scene.simulator import Simulator

BODY, LEFT, RIGHT, CAMERA = 181, 182, 184, 190
NOBODY = 99999


@pytest.fixture
def connection(server: LegacyServer) -> Iterator[Connection]:
    with Connection.to("127.0.0.1", server.port) as connection:
        yield connection


@pytest.fixture
def stepped(connection: Connection) -> Connection:
    connection.wait_for_triggers(wait=True)
    connection.start()
    return connection


def target_of(simulator: Simulator, handle: int) -> float:
    joint = simulator.graph[handle]
    assert isinstance(joint, Joint)
    return joint.target_velocity


def test_a_cycle_of_two_motors_a_joint_a_camera_a_pose_and_a_step_takes_three_round_trips(stepped: Connection) -> None:
    reads = requests.joint_position(LEFT), requests.colour_image(CAMERA), requests.object_position(BODY)
    before = stepped.round_trips
    for _ in range(10):
        stepped.set(requests.joint_target_velocity(LEFT, 3.0))
        stepped.set(requests.joint_target_velocity(RIGHT, 3.0))
        step = stepped.step(*reads)
    angle, image, (x, _, _) = step.values
    assert stepped.round_trips - before == 10 * 3
    assert step.time_s == pytest.approx(0.5)
    assert angle == pytest.approx(3.0 * 0.5)
    assert x == pytest.approx(3.0 * 0.5 * 0.0325)
    assert image.shape == (12, 16, 3)


def test_each_step_is_one_step_and_what_is_read_is_of_after_it(stepped: Connection, simulator: Simulator) -> None:
    stepped.set(requests.joint_target_velocity(LEFT, 1.0))
    for count in range(1, 20):
        step = stepped.step(requests.joint_position(LEFT))
        assert simulator.steps == count
        assert step.time_s == pytest.approx(count * simulator.time_step)
        assert step.values == (pytest.approx(count * simulator.time_step, abs=1e-6),)


def test_time_stands_between_steps(stepped: Connection) -> None:
    stepped.step()
    assert [stepped.call(requests.CLOCK) and stepped.time_s for _ in range(20)] == [0.05] * 20


def test_a_step_without_reads_returns_when_it_has_been_taken(stepped: Connection, simulator: Simulator) -> None:
    assert stepped.step().values == ()
    assert simulator.steps == 1


def test_the_same_may_be_read_twice(stepped: Connection) -> None:
    first, second = stepped.step(requests.joint_position(LEFT), requests.joint_position(LEFT)).values
    assert first == second


def test_of_two_commands_for_one_joint_the_later_is_sent(stepped: Connection, simulator: Simulator) -> None:
    for velocity in (5.0, 1.0):
        stepped.set(requests.joint_target_velocity(LEFT, velocity))
    stepped.step()
    assert target_of(simulator, LEFT) == 1.0


def test_what_waits_is_done_before_it_hangs_up(server: LegacyServer, simulator: Simulator) -> None:
    with Connection.to("127.0.0.1", server.port) as connection:
        connection.call(requests.joint_target_velocity(LEFT, 3.0))
        connection.set(requests.joint_target_velocity(LEFT, 0.0))
    assert target_of(simulator, LEFT) == 0.0


def test_a_connection_that_was_closed_leaves_its_port_to_the_next(server: LegacyServer) -> None:
    for _ in range(3):
        with Connection.to("127.0.0.1", server.port) as connection:
            assert connection.call(requests.object_handle("/rover")) == BODY


@pytest.mark.parametrize("number", [np.float32(2.5), np.float64(2.5), np.array(2.5)])
def test_numbers_of_numpy_go_as_plain_ones(number: float, connection: Connection, simulator: Simulator) -> None:
    connection.call(requests.joint_target_velocity(np.int64(LEFT), number))  # type: ignore[arg-type]
    assert target_of(simulator, LEFT) == 2.5


def test_what_the_simulator_refuses_is_reported_by_the_call_that_learns_of_it(stepped: Connection) -> None:
    with pytest.raises(RefusedError, match=f"drive joint {NOBODY}"):
        stepped.call(requests.joint_target_velocity(NOBODY, 1.0))
    with pytest.raises(RefusedError, match=f"tell the position of joint {NOBODY}"):
        stepped.step(requests.joint_position(LEFT), requests.joint_position(NOBODY))
    stepped.set(requests.joint_target_velocity(NOBODY, 1.0))
    with pytest.raises(RefusedError, match=f"drive joint {NOBODY}"):
        stepped.step()
    assert stepped.step(requests.joint_position(LEFT)).time_s > 0
    assert stepped.call(requests.LAST_ERRORS)[0] == "object does not exist. (simSetJointTargetVelocity)"


def test_a_simulation_that_does_not_run_takes_no_step(connection: Connection) -> None:
    connection.wait_for_triggers(wait=True)
    with pytest.raises(SimulationHaltedError, match="does not run"):
        connection.step()


def test_a_simulation_that_somebody_stops_ends_the_stepping(stepped: Connection, simulator: Simulator) -> None:
    stepped.step()
    with simulator.lock:
        simulator.stop()
    with pytest.raises(SimulationHaltedError):
        stepped.step()


def test_stop_returns_when_it_has_stopped_and_start_when_it_runs_again(stepped: Connection) -> None:
    stepped.step()
    stepped.stop()
    assert not stepped.server.is_running
    assert stepped.time_s == 0.0
    stepped.wait_for_triggers(wait=True)
    stepped.start()
    assert stepped.step().time_s == pytest.approx(0.05)


def test_a_simulator_that_answers_and_does_nothing_is_reported_in_time(
    server: LegacyServer, simulator: Simulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Connection.to("127.0.0.1", server.port, 0.5) as connection:
        monkeypatch.setattr("tests.doubles.coppeliasim.legacy.client.Client.turn", lambda _: None)
        with pytest.raises(ServerHangsError, match=r"has not done what it was asked for within 0\.5 s"):
            connection.call(requests.CLOCK)


def test_calls_from_several_threads_do_not_mix(connection: Connection) -> None:
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


def test_an_image_is_as_the_sensor_has_it_and_read_only(stepped: Connection) -> None:
    pixels = np.arange(12 * 16 * 3, dtype=np.uint8)
    image = stepped.step(requests.colour_image(CAMERA)).values[0]
    grey = stepped.call(requests.grey_image(CAMERA))
    assert image.size == pixels.size
    assert (grey == (image.astype(int).sum(axis=2) // 3)).all()
    assert not image.flags.writeable


def test_a_message_of_the_wrong_size_is_no_image(stepped: Connection) -> None:
    with pytest.raises(RefusedError, match="show an image"):
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


def test_what_is_read_together_with_the_trigger_is_of_before_and_asked_for_again(answers: PendingRequests) -> None:
    assert answers.to_ask(6) == [JOINT]
    answers.take(server(6), [piece(requests.TRIGGER, 100), piece(JOINT, 100)])
    assert not answers.are_complete
    assert answers.to_ask(7) == [JOINT]
    answers.take(server(7), [piece(JOINT, 150)])
    assert answers.are_complete
    assert answers[JOINT].time_ms == 150


def test_what_was_asked_is_not_asked_again_while_its_answer_is_due(answers: PendingRequests) -> None:
    assert [answers.to_ask(6), answers.to_ask(7)] == [[JOINT], []]


def test_an_answer_to_an_earlier_question_is_not_taken(answers: PendingRequests) -> None:
    answers.to_ask(6)
    answers.take(server(5), [piece(requests.TRIGGER, 100), piece(JOINT, 150)])
    assert not answers.are_complete
    answers.take(server(6), [piece(JOINT, 150)])
    assert answers.are_complete


def test_a_trigger_of_an_earlier_step_begins_none(answers: PendingRequests) -> None:
    answers.to_ask(6)
    answers.take(server(4), [piece(requests.TRIGGER, 50, failed=True)])
    answers.take(server(6), [piece(JOINT, 150)])
    assert not answers.are_complete


def test_a_trigger_that_is_refused_is_reported(answers: PendingRequests) -> None:
    with pytest.raises(SimulationHaltedError, match="takes no step"):
        answers.take(server(5), [piece(requests.TRIGGER, 0, failed=True)])


def test_without_a_trigger_the_first_answer_counts() -> None:
    answers = PendingRequests([JOINT])
    answers.to_ask(0)
    answers.take(server(0, state=0), [piece(JOINT, 0)])
    assert answers.are_complete


@pytest.mark.parametrize("state, words", [(0, "was stopped"), (PAUSED, "is paused")])
def test_a_simulation_that_halts_before_the_step_is_reported(state: int, words: str, answers: PendingRequests) -> None:
    answers.take(server(5), [piece(requests.TRIGGER, 100)])
    with pytest.raises(SimulationHaltedError, match=words):
        answers.take(server(6, state), [])
