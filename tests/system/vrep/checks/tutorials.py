"""Run both programs of the tutorials in their scenes."""

from __future__ import annotations

from functools import partial
from typing import Any

import pytest

from drivers.vrep import simx
from tests.drivers.vrep.tutorials import bubblerob_reflex, camera_relay
from tests.system.vrep import scenes
from tests.system.vrep.server import WAIT, find_handle, is_running, require_address, start_client


@pytest.fixture(autouse=True)
def _use_server_address(monkeypatch: pytest.MonkeyPatch) -> None:
    start = simx.simxStart
    monkeypatch.setattr(simx, "simxStart", lambda _, *rest: start(require_address().host, *rest))


def require_stopped() -> None:
    with start_client() as number:
        assert not is_running(number)


def test_bubblerob_drives_to_the_wall_and_backs_up_if_its_nose_works(monkeypatch: pytest.MonkeyPatch) -> None:
    places: list[Any] = []
    stop = simx.simxStopSimulation

    def note_and_stop(number: int, mode: int) -> int:
        places.append(simx.simxGetObjectPosition(number, find_handle(number, "bubbleRob_leftMotor"), -1, WAIT)[1])
        return stop(number, mode)

    monkeypatch.setattr(simx, "simxStopSimulation", note_and_stop)
    with scenes.bubblerob() as is_nose_working:
        seen = bubblerob_reflex.main(require_address().port, duration_s=4.0)
        require_stopped()
    if is_nose_working:
        assert 0.1 < seen[0][1] < bubblerob_reflex.NEAR_M
    else:
        assert seen == []
        assert places[0][0] == pytest.approx(scenes.WALL_M, abs=0.1)


def test_camera_relay_marks_the_ball_on_the_second_sensor() -> None:
    with scenes.relay():
        left, top, width, height = camera_relay.main(require_address().port, frames=3)[-1]
        require_stopped()
    middle = scenes.SIGHT_PX // 2
    assert left + width < middle < top
    assert width == pytest.approx(height, abs=4)


def test_programs_end_without_a_server(unused_port: int) -> None:
    for program in (bubblerob_reflex, camera_relay):
        run = partial(program.main, unused_port, 1, patience_ms=100)
        with pytest.raises(SystemExit):
            run()
