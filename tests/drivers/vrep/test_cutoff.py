"""Tests of the cutoff of simulated wheels, and of its reports if it cannot stop them."""

from __future__ import annotations

import threading

import pytest

from drivers.vrep.connection import Connection
from drivers.vrep.cutoff import RETRY_FOR_S, SHORT_S, StopJoints
from robotcore.safety.guardian.process import STOPPING_S
from tests.doubles.coppeliasim.legacy.faults import DropConnection
from tests.doubles.coppeliasim.legacy.server import LegacyServer
from tests.doubles.coppeliasim.scene import Simulator
from tests.doubles.coppeliasim.scene.objects import Joint
from tests.texts import CheckText

LEFT, RIGHT = 182, 184
HOST = "127.0.0.1"


@pytest.fixture
def cutoff(server: LegacyServer) -> StopJoints:
    return StopJoints(HOST, server.port, [LEFT, RIGHT])


@pytest.fixture
def wheels(simulator: Simulator) -> list[Joint]:
    """Return the joints of both wheels, which turn."""
    joints = [joint for joint in map(simulator.graph.__getitem__, (LEFT, RIGHT)) if isinstance(joint, Joint)]
    for joint in joints:
        joint.target_velocity = 3.0
    return joints


def test_wheels_are_stopped(cutoff: StopJoints, wheels: list[Joint]) -> None:
    assert cutoff.stop() is None
    assert [wheel.target_velocity for wheel in wheels] == [0.0, 0.0]


@pytest.mark.slow
def test_report_if_the_simulator_does_nothing(
    cutoff: StopJoints, wheels: list[Joint], monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    monkeypatch.setattr("tests.doubles.coppeliasim.legacy.client.Client.turn", lambda _: None)
    check_text(cutoff.stop())
    assert [wheel.target_velocity for wheel in wheels] == [3.0, 3.0]


def test_report_if_the_server_still_serves_the_app(
    cutoff: StopJoints, server: LegacyServer, check_text: CheckText
) -> None:
    with Connection.open(HOST, server.port):
        check_text(cutoff.stop(), hide=[server.port])


def test_server_that_closes_connections_at_first_is_tried_again(
    cutoff: StopJoints, wheels: list[Joint], server: LegacyServer
) -> None:
    server.service.fail(DropConnection())
    threading.Timer(0.2, lambda: server.service.fail(None)).start()
    assert cutoff.stop() is None
    assert [wheel.target_velocity for wheel in wheels] == [0.0, 0.0]


@pytest.mark.slow
def test_report_if_the_server_has_ended(cutoff: StopJoints, server: LegacyServer, check_text: CheckText) -> None:
    port = server.port
    server.close()
    check_text(cutoff.stop(), hide=[port])
    assert RETRY_FOR_S + SHORT_S <= STOPPING_S
