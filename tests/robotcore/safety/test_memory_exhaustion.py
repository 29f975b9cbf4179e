"""Stops in which one memory allocation fails. Each test repeats the stop for each allocation."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator

import pytest

from robotcore.errors import DeviceError, EmergencyStopError
from robotcore.geometry import Wheels
from robotcore.hal.clock import SteppedClock, TickClock
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.runtime.layers.base import MotorOutput
from robotcore.runtime.layers.standalone_motor import StandaloneGuard
from robotcore.safety.command_filter import SafetyFilter
from robotcore.safety.deadman import Deadman
from robotcore.safety.latch import Latch
from robotcore.safety.motor_stop import StopGroup
from robotcore.safety.thread_reserve import Reserve
from robotcore.safety.wheel_output import SideMotors
from robotcore.threads import is_out_of_memory
from tests.robotcore.fakes import NullMotor

pytestmark = pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
"""The allocation may be one of an iterator or a context that Python cleans up."""

testcapi = pytest.importorskip("_testcapi", reason="this Python has no module that can refuse an allocation")

POINTS = 100
"""The number of repetitions. In each, a later allocation fails. A stop makes fewer allocations."""

LEASE_S = 0.125


class Robot:
    """A drive and a gripper that turn, with all the stops of a run."""

    def __init__(self) -> None:
        self.clock = SteppedClock(20, lambda _: None)
        ticks = TickClock(self.clock)
        self.reserve = Reserve(MonotonicClock())
        self.reserve.hold(threads=4)
        self.motors = [NullMotor("left_motor"), NullMotor("right_motor"), NullMotor("gripper")]
        left, right, gripper = self.motors
        self.latch = Latch(self.reserve)
        self.motor_stops = StopGroup.create(*self.motors, reserve=self.reserve)
        self.latch.add_stop(self.motor_stops.apply_apart)
        self.filter = SafetyFilter(
            ticks,
            SideMotors([left], [right]),
            [],
            LEASE_S,
            self.latch,
            motor_stops=self.motor_stops.select(left, right),
        )
        self.gripper = StandaloneGuard(
            MotorOutput.from_motor(gripper), 12.0, ticks, LEASE_S, self.latch, self.motor_stops.select(gripper)
        )
        self.filter.ask(Wheels(2.0, 2.0))
        self.filter.commit()
        self.gripper.set_velocity(2.0)
        for motor in self.motors:
            assert motor.sent == [2.0]

    @property
    def turning(self) -> list[str]:
        return [motor.name for motor in self.motors if motor.sent[-1]]

    def close(self) -> None:
        self.reserve.close()


@pytest.fixture(autouse=True)
def _untraced() -> Iterator[None]:
    """Suspend tracing, such as that of coverage. A tracer allocates memory too, so the wrong allocation would fail."""
    trace, thread_trace = sys.gettrace(), threading.gettrace()
    sys.settrace(None)
    threading.settrace(None)
    yield
    sys.settrace(trace)
    threading.settrace(thread_trace)


@pytest.fixture
def robots() -> Iterator[Callable[[], Robot]]:
    made: list[Robot] = []

    def make() -> Robot:
        made.append(Robot())
        return made[-1]

    yield make
    for robot in made:
        robot.close()


def refuse(point: int, function: Callable[[], object]) -> None:
    """Call a function in another thread, and let its allocation number ``point`` fail."""

    gate = threading.Lock()

    def call() -> None:
        with gate:
            try:
                testcapi.set_nomemory(point, point + 1)
                function()
            except Exception as error:
                is_slow = isinstance(error, DeviceError) and error.kind == "stop-timeout"  # on a busy machine
                if not (is_slow or is_out_of_memory(error)):
                    raise
            finally:
                testcapi.remove_mem_hooks()

    with gate:
        thread = threading.Thread(target=call)
        thread.start()
    deadline, is_alive = time.monotonic() + 10.0, True
    while is_alive and time.monotonic() < deadline:
        try:
            time.sleep(0.001)
            is_alive = thread.is_alive()
        except MemoryError:  # noqa: PERF203  the one allocation may be this thread's
            continue
    assert not is_alive, f"it hangs where allocation {point} is refused"


@pytest.mark.slow
def test_second_press_of_the_e_stop_stops_every_motor(robots: Callable[[], Robot]) -> None:
    for point in range(POINTS):
        robot, error = robots(), EmergencyStopError("pressed")
        refuse(point, lambda latch=robot.latch, error=error: latch.set(error))  # type: ignore[misc]
        if robot.turning:
            robot.latch.set(error)
        assert robot.turning == [], point
        assert robot.latch.error is error
        assert robot.latch.last_velocities == Wheels(2.0, 2.0), point


@pytest.mark.slow
def test_second_call_of_the_clock_stops_every_motor(robots: Callable[[], Robot]) -> None:
    for point in range(POINTS):
        robot = robots()
        for _, _, call in robot.clock._calls:
            refuse(point, call)
            if robot.turning:
                call()
        assert robot.turning == [], point


def test_renewal_without_memory_loses_no_lease() -> None:
    for point in range(POINTS):
        clock = SteppedClock(20, lambda _: None)
        cuts: list[float] = []
        deadman = Deadman(clock, LEASE_S, cuts.append, threading.RLock(), Reserve(clock))
        refuse(point, lambda deadman=deadman: deadman.renew(0.0))  # type: ignore[misc]
        deadman.renew(0.0)
        clock.sleep_until(1.0)
        assert cuts, point


def test_reserve_loses_no_thread_to_a_call_without_memory(robots: Callable[[], Robot]) -> None:
    robot = robots()
    for point in range(POINTS):
        refuse(point, lambda: robot.reserve.call(lambda: None))
    done = [robot.reserve.call(threading.Event().set) for _ in range(4)]
    assert all(call.is_done_within(10) for call in done)
    while len(robot.reserve._idle) < 4:  # each thread has made its call, and is about to wait
        pass
