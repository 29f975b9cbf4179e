"""Which answers are of after a step: servers answer in between as well, and late."""

from __future__ import annotations

import pytest

from drivers.vrep.answers import Answers
from drivers.vrep.wire import requests
from drivers.vrep.wire.errors import SimulationHaltedError
from drivers.vrep.wire.messages import Header, Piece
from drivers.vrep.wire.request import Request

RUNNING, PAUSED = 1, 3
JOINT = requests.joint_position(7)
TRIGGER = 5


@pytest.fixture
def answers() -> Answers:
    return Answers([JOINT], TRIGGER)


def server(message: int, state: int = RUNNING) -> Header:
    return Header(11, message, 0, 0, 0, state)


def piece(request: Request[object], time_ms: int, *, failed: bool = False) -> Piece:
    return Piece(request.command, request.key, 0, time_ms, failed, memoryview(bytes(4)), 0, 4)


def test_what_is_read_together_with_the_trigger_is_of_before_and_asked_for_again(answers: Answers) -> None:
    assert answers.to_ask(6) == [JOINT]
    answers.take(server(6), [piece(requests.TRIGGER, 100), piece(JOINT, 100)])
    assert not answers.are_complete
    assert answers.to_ask(7) == [JOINT]
    answers.take(server(7), [piece(JOINT, 150)])
    assert answers.are_complete
    assert answers[JOINT].time_ms == 150


def test_what_was_asked_is_not_asked_again_while_its_answer_is_due(answers: Answers) -> None:
    assert [answers.to_ask(6), answers.to_ask(7)] == [[JOINT], []]


def test_an_answer_to_an_earlier_question_is_not_taken(answers: Answers) -> None:
    answers.to_ask(6)
    answers.take(server(5), [piece(requests.TRIGGER, 100), piece(JOINT, 150)])
    assert not answers.are_complete
    answers.take(server(6), [piece(JOINT, 150)])
    assert answers.are_complete


def test_a_trigger_of_an_earlier_step_begins_none(answers: Answers) -> None:
    answers.to_ask(6)
    answers.take(server(4), [piece(requests.TRIGGER, 50, failed=True)])
    answers.take(server(6), [piece(JOINT, 150)])
    assert not answers.are_complete


def test_a_trigger_that_is_refused_is_told(answers: Answers) -> None:
    with pytest.raises(SimulationHaltedError, match="takes no step"):
        answers.take(server(5), [piece(requests.TRIGGER, 0, failed=True)])


def test_without_a_trigger_the_first_answer_counts() -> None:
    answers = Answers([JOINT])
    answers.to_ask(0)
    answers.take(server(0, state=0), [piece(JOINT, 0)])
    assert answers.are_complete


@pytest.mark.parametrize("state, told", [(0, "was stopped"), (PAUSED, "is paused")])
def test_a_simulation_that_halts_before_the_step_is_told(state: int, told: str, answers: Answers) -> None:
    answers.take(server(5), [piece(requests.TRIGGER, 100)])
    with pytest.raises(SimulationHaltedError, match=told):
        answers.take(server(6, state), [])
