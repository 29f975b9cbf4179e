from __future__ import annotations

from collections.abc import Callable

import pytest

from robotcore.errors import DeviceError, DeviceLostError
from robotcore.hal.robot import Robot
from robotcore.runtime.behaviour import Status
from robotcore.runtime.loop import Loop
from tests.robotcore.fakes import FunctionApp, picture
from tests.robotcore.runtime.faults.rigs import TICK_S, build_rig
from tests.texts import Raises


class TestStall:
    def test_time_passes_without_ticks_during_a_stall(self) -> None:
        assert _tick_times("loop stall=0.3 after=0.1", 5) == pytest.approx([0.0, 0.05, 0.1, 0.4, 0.45])

    def test_stall_between_two_ticks_is_not_missed(self) -> None:
        assert _tick_times("loop stall=0.1 after=0.06", 4) == pytest.approx([0.0, 0.05, 0.1, 0.2])

    def test_deadman_stops_the_motors_at_its_expiry_during_a_stall(self) -> None:
        rig = build_rig("loop stall=0.3 after=0.05")
        cuts: list[float] = []
        rig.left.on_command = lambda rad_s: cuts.append(rig.clock.now()) if rad_s == 0.0 else None
        rig.robot.drive.set_wheels(4.0, 4.0)
        rig.commit()
        rig.robot.drive.set_wheels(4.0, 4.0)
        rig.commit()
        assert cuts == pytest.approx([0.05 + 0.125])
        assert rig.clock.now() == pytest.approx(0.35)


class TestLost:
    def test_every_device_raises_an_error_with_its_name_and_works_again(self, raises: Raises) -> None:
        rig = build_rig("connection lost=0.1 after=0.05")
        robot = rig.robot
        robot.camera.read()
        rig.sleep(TICK_S)
        uses: dict[str, Callable[[], object]] = {
            "eye": robot.camera.read,
            "nose": robot.range.read,
            "screen": lambda: robot.display.show(picture()),
        }
        for device, use in uses.items():
            with raises(DeviceLostError, "injected-loss", device=device, fault="connection lost=0.1 after=0.05"):
                use()
        robot.drive.set_velocity(-0.1, 0.0)
        with raises(DeviceLostError, "injected-loss", device="left_motor"):
            rig.commit()
        rig.sleep(0.1)
        assert robot.range.read().time == robot.camera.read().time == pytest.approx(0.15)
        robot.display.show(picture())
        assert rig.screen.picture is not None
        robot.drive.set_velocity(-0.1, 0.0)
        rig.commit()
        assert rig.wheels[0] < 0

    def test_stop_reaches_a_disconnected_motor(self) -> None:
        rig = build_rig("connection lost=1 after=0.05")
        rig.robot.drive.set_velocity(-0.1, 0.0)
        rig.commit()
        assert rig.wheels[0] < 0
        rig.robot.stop()
        assert rig.wheels == (0.0, 0.0)
        rig.robot.close()
        assert (rig.left.releases, rig.right.releases) == (1, 1)

    @pytest.mark.parametrize("lasts", [0.3, 0.4])
    def test_outage_repeats_until_lasts_is_over(self, lasts: float) -> None:
        rig = build_rig(f"connection lost=0.1 after=0.05 every=0.2 lasts={lasts}")
        lost = []
        for _ in range(12):
            try:
                rig.robot.range.read()
                lost.append(0)
            except DeviceError:
                lost.append(1)
            rig.sleep(TICK_S)
        assert lost == [0, 1, 1, 0, 0, 1, 1, 0, 0, 0, 0, 0]


def _tick_times(spec: str, ticks: int) -> list[float]:
    times: list[float] = []

    def note(robot: Robot) -> Status:
        times.append(robot.clock.now())
        return Status.RUNNING if len(times) < ticks else Status.SUCCESS

    Loop(build_rig(spec).assembled, FunctionApp(note), 20, 10.0).run()
    return times
