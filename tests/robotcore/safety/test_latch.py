from __future__ import annotations

import threading

import pytest

from robotcore.errors import BackendError, DeviceError, EmergencyStopError, InvalidCommandError, SafetyStop
from robotcore.geometry import Wheels
from robotcore.safety.latch import EmergencyStop, Latch
from robotcore.safety.velocity_limits import STOPPED
from tests.robotcore.fakes import Rig
from tests.texts import Raises


def test_keeps_the_first_error_of_several() -> None:
    latch, first = Latch(), EmergencyStopError("first")
    latch.set(first)
    with pytest.raises(EmergencyStopError) as raised:
        latch.trip(InvalidCommandError("second"))
    assert raised.value is first
    with pytest.raises(EmergencyStopError) as raised:
        latch.check()
    assert raised.value is first


def test_calls_every_stop_once_even_if_one_fails() -> None:
    latch, calls = Latch(), []

    def fail() -> None:
        calls.append("fails")
        raise DeviceError("left_motor", "no current")

    latch.add_stop(fail)
    latch.add_stop(lambda: calls.append("stops"))
    latch.set(EmergencyStopError("now"))
    latch.set(EmergencyStopError("again"))
    assert calls == ["fails", "stops"]


@pytest.mark.parametrize(
    "error, cause",
    [
        (EmergencyStopError("pressed"), "e-stop"),
        (InvalidCommandError("NaN"), "invalid command"),
        (SafetyStop("so"), "safety stop"),
        (BackendError("hung"), "watchdog"),
    ],
)
def test_intervention_has_the_cause_of_the_latch(error: SafetyStop, cause: str) -> None:
    latch = Latch()
    latch.set(error)
    (intervention,) = latch.interventions(1.5)
    assert (intervention.time, intervention.cause, intervention.sent) == (1.5, cause, STOPPED)


class TestEmergencyStop:
    def test_stops_the_motors_from_any_thread_before_it_returns(self) -> None:
        rig = Rig()
        rig.robot.drive.set_wheels(2.0, 2.0)
        rig.commit()
        assert rig.wheels == (2.0, 2.0)
        thread = threading.Thread(target=EmergencyStop(rig.assembled.latch).press, args=("the button",))
        thread.start()
        thread.join()
        assert rig.wheels == (0.0, 0.0)
        assert rig.assembled.latch.last_velocities == Wheels(2.0, 2.0)

    def test_no_command_passes_after_an_emergency_stop(self, raises: Raises) -> None:
        rig = Rig()
        EmergencyStop(rig.assembled.latch).press("the button")
        for command in (lambda: rig.robot.drive.set_wheels(1.0, 1.0), rig.commit):
            with raises(EmergencyStopError):
                command()
        assert rig.wheels == (0.0, 0.0)

    def test_press_during_a_commit_stops_the_motors(self) -> None:
        rig = Rig()
        stop = EmergencyStop(rig.assembled.latch)
        rig.robot.drive.set_wheels(2.0, 2.0)

        def press(rad_s: float) -> None:
            if rad_s:
                thread = threading.Thread(target=stop.press, args=("the button",))
                thread.start()
                thread.join(10)

        rig.left.on_command = press
        rig.commit()
        assert rig.wheels == (0.0, 0.0)


def test_call_that_runs_out_of_memory_twice_is_made_by_the_next_set() -> None:
    latch, tries, first = Latch(), [], EmergencyStopError("first")

    def stop() -> None:
        tries.append(1)
        if len(tries) < 3:
            raise MemoryError

    latch.add_stop(stop)
    latch.set(first)
    assert len(tries) == 2
    latch.set(EmergencyStopError("second"))
    latch.set(EmergencyStopError("third"))
    assert len(tries) == 3
    assert latch.error is first
