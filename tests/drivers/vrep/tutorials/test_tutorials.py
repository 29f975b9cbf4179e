"""Run the programs of the tutorials, which have one changed line."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from tests.doubles.coppeliasim.legacy.server import LegacyServer
from tests.doubles.coppeliasim.scene.objects import VisionSensor
from tests.doubles.coppeliasim.scene.poses import Transform
from tests.doubles.coppeliasim.scenes import bubblerob_scene, relay_scene
from tests.drivers.vrep.tutorials import bubblerob_reflex, camera_relay
from tests.texts import CheckText


@pytest.mark.slow
def test_bubblerob_backs_up_after_a_detection_and_drives_on() -> None:
    simulator = bubblerob_scene()
    post = simulator.graph.find("/post0")
    assert post
    simulator.graph.put(post, Transform((0.7, 0.0, 0.2)))
    paths: list[float] = []
    advance = simulator.advance

    def advance_and_record() -> None:
        advance()
        paths.append(simulator.graph.pose(simulator.graph[body.handle]).position[0])

    body = next(node for node in simulator.graph if node.alias == "bubbleRob")
    simulator.advance = advance_and_record  # type: ignore[method-assign]
    with LegacyServer(simulator) as server:
        seen = bubblerob_reflex.main(server.port, duration_s=8.0)
    (first_s, distance_m), *_ = seen
    first, after = (round(when / simulator.time_step) for when in (first_s, first_s + bubblerob_reflex.BACK_UP_S))
    assert 0.1 < distance_m < bubblerob_reflex.NEAR_M
    assert paths[0] < paths[first] < 0.6 - 0.1
    assert paths[after] < paths[first] - 0.03
    assert paths[-1] > paths[after]
    assert all(later - earlier >= bubblerob_reflex.BACK_UP_S for (earlier, _), (later, _) in pairwise(seen))


def test_ball_is_marked_on_the_second_sensor() -> None:
    simulator = relay_scene()
    screen = next(node for node in simulator.graph.all_of(VisionSensor) if node.alias == "v1")
    shown: list[np.ndarray] = []
    show = simulator.show

    def show_and_record(sensor: VisionSensor, picture: np.ndarray) -> None:
        assert sensor is screen
        shown.append(picture.copy())
        show(sensor, picture)

    simulator.show = show_and_record  # type: ignore[method-assign]
    with LegacyServer(simulator) as server:
        marks = camera_relay.main(server.port, frames=3)
    left, top, width, height = marks[-1]
    upright = shown[-1][::-1]
    assert left + width / 2 < 128 < top + height / 2
    assert width == pytest.approx(height, abs=4)
    assert (upright[top, left : left + width] == camera_relay.YELLOW_RGB).all()
    assert (upright[top + height // 2, left + width // 2] * [1, 0, 1] < 60).all()


@pytest.mark.parametrize("program", [bubblerob_reflex, camera_relay])
def test_program_ends_without_a_simulator(program: object, unused_port: int, check_text: CheckText) -> None:
    with pytest.raises(SystemExit) as caught:
        program.main(unused_port, 1, patience_ms=100)  # type: ignore[attr-defined]
    check_text(caught.value)
