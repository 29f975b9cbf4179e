from __future__ import annotations

import threading
import time
from pathlib import Path

import pytest

from robotcore import Role, run
from robotcore.errors import DeviceError
from robotcore.hal.robot import Robot
from robotcore.kinds.range_sensor import Range
from robotcore.runtime.behaviour import Behaviour, Status
from robotcore.runtime.layers import assemble
from robotcore.runtime.profiler import DeviceTap, DeviceTimes, Profiler
from robotcore.runtime.session import RunRequest
from tests.robotcore.fakes import Rig, picture


def _wait(seconds: float) -> None:
    time.sleep(seconds)


def test_a_line_that_calls_a_library_names_the_innermost_function() -> None:
    profiler = Profiler()
    run(RunRequest(Caller), [profiler], [profiler.layer])
    slowest, _ = max(profiler.line_s.items(), key=lambda item: item[1])
    assert slowest.number == Caller.step.__code__.co_firstlineno + 1
    assert slowest.call.endswith("wait")


def test_the_program_that_calls_the_run_is_no_line_of_the_app() -> None:
    profiler = Profiler()
    run(RunRequest(Caller), [profiler], [profiler.layer])
    lines = {line.number for line in profiler.line_s}
    assert lines <= {Caller.step.__code__.co_firstlineno + 1, Caller.step.__code__.co_firstlineno + 2}


class Caller(Behaviour):
    def step(self, robot: Robot) -> Status:
        threading.Event().wait(0.2)
        return Status.SUCCESS


class Waiter(Behaviour):
    needs = frozenset({Role.RANGE})

    def step(self, robot: Robot) -> Status:
        robot.range.read()
        _wait(0.2)
        time.sleep(0.02)
        return Status.SUCCESS


def test_the_line_of_the_app_that_waits_is_named_with_its_time() -> None:
    profiler = Profiler()
    run(RunRequest(Waiter), [profiler], [profiler.layer])
    slowest, seconds = max(profiler.line_s.items(), key=lambda item: item[1])
    assert Path(slowest.file) == Path(__file__)
    assert slowest.call == "_wait"
    assert slowest.number == _wait.__code__.co_firstlineno + 1
    assert seconds > sum(profiler.line_s.values()) / 2
    assert {Path(line.file) for line in profiler.line_s} == {Path(__file__)}
    assert "profiler" not in {thread.name for thread in threading.enumerate()}


def test_each_call_of_a_device_is_timed_also_one_that_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr("robotcore.runtime.profiler.read_timer", lambda: now[0])
    rig, tap = Rig(), DeviceTap()

    waits, newest = [0.5, 3.0], rig.nose._newest

    def read_slowly() -> Range:
        now[0] += waits.pop(0)
        if not waits:
            raise DeviceError("nose", "failed")
        return newest()

    monkeypatch.setattr(rig.nose, "_newest", read_slowly)
    assembled = assemble(rig.raw, rig.description, rig.rate_hz, taps=[tap])
    assembled.robot.range.read()
    assembled.clock.sleep_until(0.05)
    with pytest.raises(DeviceError):
        assembled.robot.range.read()
    assembled.robot.display.show(picture())
    assert tap.times["nose"] == DeviceTimes(2, 3.5, 3.0)
    assert tap.times["screen"].calls == 1


def test_a_motor_is_timed_when_its_command_is_sent(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr("robotcore.runtime.profiler.read_timer", lambda: now[0])
    rig, tap = Rig(), DeviceTap()

    def take_a_second(_: float) -> None:
        now[0] += 1.0

    rig.left.on_command = take_a_second
    assembled = assemble(rig.raw, rig.description, rig.rate_hz, taps=[tap])
    assembled.robot.drive.set_wheels(2.0, 2.0)
    assert "left_motor" not in tap.times
    assert assembled.command_filter
    assembled.command_filter.commit()
    assert tap.times["left_motor"] == DeviceTimes(1, 1.0, 1.0)
