"""What the guardian does to the wheels of a simulation, and what it says of those that it could not reach."""

from __future__ import annotations

import threading

import pytest

from drivers.vrep.connection import Connection
from drivers.vrep.cutoff import DEAF_S, SHORT_S, StopJoints
from robotcore.safety.guardian.process import STOPPING_S
from tests.doubles.coppeliasim.legacy.faults import DropConnection
from tests.doubles.coppeliasim.legacy.server import LegacyServer
from tests.doubles.coppeliasim.scene.objects import Joint
from tests.doubles.coppeliasim.scene.simulator import Simulator

LEFT, RIGHT = 182, 184
HOST = "127.0.0.1"


@pytest.fixture
def cutoff(server: LegacyServer) -> StopJoints:
    return StopJoints(HOST, server.port, [LEFT, RIGHT])


@pytest.fixture
def wheels(simulator: Simulator) -> list[Joint]:
    """Both turn."""
    joints = [joint for joint in map(simulator.graph.__getitem__, (LEFT, RIGHT)) if isinstance(joint, Joint)]
    for joint in joints:
        joint.target_velocity = 3.0
    return joints


def test_wheels_stand_when_it_says_so(cutoff: StopJoints, wheels: list[Joint]) -> None:
    assert cutoff.stop() is None
    assert [wheel.target_velocity for wheel in wheels] == [0.0, 0.0]


def test_server_that_answers_and_does_nothing_has_stopped_nothing(
    cutoff: StopJoints, wheels: list[Joint], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tests.doubles.coppeliasim.legacy.client.Client.turn", lambda _: None)
    assert "simulated wheels may turn on" in str(cutoff.stop())
    assert [wheel.target_velocity for wheel in wheels] == [3.0, 3.0]


def test_server_that_still_has_the_app_is_reported(cutoff: StopJoints, server: LegacyServer) -> None:
    with Connection.to(HOST, server.port):
        assert "A port serves one program at a time" in str(cutoff.stop())


def test_server_that_hangs_up_at_first_on_who_comes_after_a_killed_app_is_tried_again(
    cutoff: StopJoints, wheels: list[Joint], server: LegacyServer
) -> None:
    server.service.fail(DropConnection())
    threading.Timer(0.2, lambda: server.service.fail(None)).start()
    assert cutoff.stop() is None
    assert [wheel.target_velocity for wheel in wheels] == [0.0, 0.0]


def test_server_that_is_gone_is_reported_before_the_guardian_gives_it_up(
    cutoff: StopJoints, server: LegacyServer
) -> None:
    server.close()
    assert "where the simulator is gone, nothing turns" in str(cutoff.stop())
    assert DEAF_S + SHORT_S <= STOPPING_S
