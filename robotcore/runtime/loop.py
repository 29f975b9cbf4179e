"""The loop of a run. In each tick it calls the app once and sends one filtered command.

It reads a sensor when the app first asks for its sample in a tick. After the tick it sleeps until the next one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from robotcore.errors import DeviceError, DeviceLostError, Interrupted, RobotcoreError
from robotcore.hal.device import Sensor
from robotcore.hal.drive import DifferentialDrive
from robotcore.kinds.motor import Motor
from robotcore.runtime.app_calls import AppCalls
from robotcore.runtime.behaviour import Behaviour, Status, find_defined_method
from robotcore.runtime.device_losses import DeviceLossTracker
from robotcore.runtime.hand_driving import HandDriving
from robotcore.runtime.intervention_timer import InterventionTimer
from robotcore.runtime.layers import AssembledRobot
from robotcore.runtime.layers.devices import AppSensor
from robotcore.runtime.pace import PaceControl
from robotcore.runtime.result import Outcome
from robotcore.runtime.sensor_monitor import SensorMonitor
from robotcore.runtime.trace import TickRecord, Trace
from robotcore.runtime.wait_monitor import WaitMonitor
from robotcore.safety.command_filter import LOST, TickCommands
from robotcore.safety.velocity_limits import Intervention
from robotcore.safety.watchdog import TimeLimit

TickObserver = Callable[[TickRecord], None]

_IDLE = TickCommands(None, None, ())


class Loop:
    """Runs a behaviour on a robot until the behaviour ends, or for ``timeout`` seconds of the robot's time.

    assembled: the robot with its layers.
    rate_hz: the number of ticks in a second.
    observers: functions that are called with the record of each tick.
    build_step_limit, observer_limit: the watchdog's time limits for the app's step and for the observers.
    outage: the longest time for which a device may be lost, in seconds. The robot stands still while a device is lost.
    waits: the monitor of the app's steps, in a simulation.
    hand_driving: lets a person drive in place of the app, in a run with an operator.
    pace: the pace of simulated time. None: time passes as the clock lets it.
    check_signals: a function that raises the exception of a signal. It is called after each tick, and in a pause.
    """

    def __init__(
        self,
        assembled: AssembledRobot,
        behaviour: Behaviour,
        rate_hz: float,
        timeout: float,
        observers: Sequence[TickObserver] = (),
        build_step_limit: TimeLimit | None = None,
        observer_limit: TimeLimit | None = None,
        outage: float = 0.0,
        waits: WaitMonitor | None = None,
        hand_driving: HandDriving | None = None,
        pace: PaceControl | None = None,
        check_signals: Callable[[], object] = lambda: None,
    ) -> None:
        self.robot, self._clock = assembled.robot, assembled.clock
        self._latch, self._filter, self._activity = assembled.latch, assembled.command_filter, assembled.activity
        self._reserve = assembled.motor_stops.reserve
        self._step_limit, self._observer_limit = build_step_limit, observer_limit
        self._stop, self._taps = assembled.suspend, assembled.taps
        self.losses = DeviceLossTracker(outage)
        self._drive = assembled.robot.drive if assembled.command_filter else None
        self.behaviour = behaviour
        self._app = AppCalls(behaviour, self.robot, self._clock, self._latch, self._reserve, waits)
        self.trace = Trace(behaviour.milestones)
        self.reason = ""
        """The reason of the app, after it has ended or its time is over."""
        self.overruns = 0
        self._period = 1 / rate_hz
        self._timeout = timeout
        self.intervention_timer = InterventionTimer()
        self._observers = (self.intervention_timer.add, *observers)
        self._deadline = self._clock.now()
        self._hand_driving, self._timer = hand_driving, assembled.timer
        self._pace, self._check_signals = pace, check_signals
        self._monitor = SensorMonitor(assembled.robot)
        self._warnings: tuple[str, ...] = ()
        self._is_latch_recorded = False
        self._last_tick = -1
        devices = assembled.robot.devices.values()
        can_wait = outage > 0 and find_defined_method(behaviour) == "run"
        self._sensors = [device for device in devices if can_wait and isinstance(device, AppSensor)]
        """The sensors of a routine that waits for lost devices. Empty in another run."""
        self._routine_sensors: Sequence[Sensor[Any]] = ()
        """Those of them that the routine has read in its last tick."""

    @property
    def time(self) -> float:
        """The robot's time at the last tick, in seconds."""
        return self._clock.now()

    @property
    def latched_error(self) -> RobotcoreError | None:
        """The error that has tripped the latch. None if it has not tripped."""
        return self._latch.error

    @property
    def unreported_interventions(self) -> Sequence[Intervention]:
        """The interventions of a tripped latch that no tick has recorded."""
        is_reported = self._latch.error is None or self._is_latch_recorded
        return () if is_reported else self._latch.interventions(self._clock.now())

    def run(self) -> Outcome:
        """Run ticks until the app ends or its time is over, then stop the wheels. Return the outcome.

        If the latch has tripped, its error is raised in place of any other exception, because it is the cause.
        """
        try:
            return self._run()
        except BaseException as error:
            if self._latch.error:
                self._reserve.release_memory()
            self._close_routine_after(error)
            if self._latch.error and not self._is_latch_recorded:
                self._record(_IDLE)
            self._latch.check()
            raise

    def _run(self) -> Outcome:
        self._begin_timing()
        if self._pace:
            self._pace.restart(self._clock.now())
            self._hold(self._pace)
        while (status := self._tick_or_wait()) is Status.RUNNING and self._clock.now() < self._timeout:
            self._let_time_pass()
        self.end()
        return Outcome.TIMEOUT if status is Status.RUNNING else Outcome(status.value)

    def pause(self) -> None:
        """Stop all motors between two ticks. No time limit holds until `resume`. Sensors may be read meanwhile.

        The next routine waits only for the devices that it uses itself, and again for the whole time of an outage.
        """
        try:
            if not self._latch.error:  # a latch that trips stops all motors
                self._stop("pause")
        finally:
            for tap in self._taps:
                tap.end_ticks()
            self.losses.end(self._clock.now())
            self._routine_sensors = ()
            self._activity.begin(None)
            self._clock.renewal_age = self._period

    def resume(self) -> None:
        """Begin a new tick at the present time."""
        for tap in self._taps:
            tap.resume_ticks()
        self._clock.renewal_age = None
        self._clock.begin_tick()
        self._deadline = self._clock.now()

    def end(self) -> None:
        """Stop the wheels, and read the app's reason."""
        if self._filter:
            self._filter.stop()
        self.reason = self._app.read_text("reason")

    def _close_routine(self) -> None:
        self._activity.begin(self._step_limit)
        self._app.close_routine()

    def _close_routine_after(self, error: BaseException) -> None:
        if not self.behaviour.has_open_routine:
            return
        for tap in self._taps:
            tap.end_ticks()
        try:
            self._close_routine()
        except RobotcoreError as failure:
            if failure is not self._latch.error and not isinstance(error, Interrupted):
                self.trace.warnings.append(f"the clean-up of the app failed too: {failure}")

    def _tick_or_wait(self) -> Status:
        try:
            status = self.tick()
        except DeviceLostError as lost:
            if self.behaviour.has_failed_routine or not self.losses.tolerate(lost, self._clock.now()):
                raise
            self._stop(LOST)
            return Status.RUNNING
        self.losses.end(self._clock.now())
        return status

    def tick(self) -> Status:
        """Call the app's step, send the command, and record the tick. A tick with an exception is recorded too."""
        timer = self._timer
        self._latch.check()
        self._activity.ticks += 1
        if self._drive:
            self._update_odometry(self._drive)
        self._warnings += self._monitor.read(self._clock.now())
        commit, lost = _IDLE, None
        if timer:
            timer.begin_decision()
        try:
            self._probe_lost_devices()
            self._read_for_routine()
            counts = [sensor.read_count for sensor in self._sensors]
            self._activity.begin(self._step_limit)
            is_driven_by_hand = self._hand_driving is not None and self._hand_driving.drive()
            status = Status.RUNNING if is_driven_by_hand else self._app.decide()
            if status is not Status.RUNNING or self._clock.now() >= self._timeout:
                self._close_routine()  # its clean-up is a part of the last tick
            if not is_driven_by_hand:
                pairs = zip(self._sensors, counts, strict=True)
                self._routine_sensors = [sensor for sensor, count in pairs if sensor.read_count > count]
            self._latch.check()
            if timer:
                timer.begin_commit()
            if self._filter:
                commit = self._filter.commit()
        except DeviceLostError as error:
            lost = error.device
            raise
        finally:
            self._record(commit, lost)
        return status

    def _probe_lost_devices(self) -> None:
        """Read each lost sensor and stop each lost motor. Raises DeviceLostError if one is still lost.

        A lost actuator other than a motor is not checked, because a check would change its state.
        """
        for name in self.losses.lost:
            match self.robot.devices.get(name):
                case Sensor() as sensor:
                    sensor.read()
                case Motor() as motor:
                    motor.stop()

    def _read_for_routine(self) -> None:
        """Read the sensors that the routine has read in the last tick. Raises DeviceLostError if one is lost.

        A generator cannot continue after an exception. So the loop does not call it while one of them is lost.
        """
        for sensor in self._routine_sensors:
            sensor.read()

    @staticmethod
    def _update_odometry(drive: DifferentialDrive) -> None:
        # A DeviceError is ignored here, because the app gets it when it drives or reads the pose.
        try:  # noqa: SIM105  each tick runs this, and `suppress` takes ten times as long
            drive.track()
        except DeviceError:
            pass

    def _record(self, commit: TickCommands, lost: str | None = None) -> None:
        # A latch that trips between two ticks gets a tick of its own.
        self._activity.begin(self._observer_limit)
        if self._timer:
            self._timer.begin_record()
        if self._latch.error and not self._is_latch_recorded:
            latched, self._is_latch_recorded = self.unreported_interventions, True
            commit = commit._replace(interventions=(*commit.interventions, *latched))
        tick = self._clock.tick + (self._clock.tick == self._last_tick)
        self._last_tick = tick
        warnings, self._warnings = self._warnings, ()
        record = TickRecord(
            tick,
            self._clock.now(),
            self._app.read_text("state"),
            *commit,
            lost,
            self._monitor.values,
            warnings,
            self.robot.value_log.take(),
            self._app.prints.take(),
        )
        self.trace.add(record)
        for observe in self._observers:
            observe(record)
        self._check_signals()

    def _let_time_pass(self) -> None:
        if self._timer:
            self._timer.begin_sleep()
        self._activity.begin(None)  # the clock has a time limit of its own
        self._deadline += self._period
        is_late: bool | None = None
        while is_late is None:
            try:
                is_late = not self._clock.sleep_until(self._deadline)
            except DeviceLostError:  # noqa: PERF203  the deadman raises it for each lost motor that does not stop
                if not self.losses.is_enabled:
                    raise
                self._stop(LOST)
        if self._pace and not self._pace.keep_speed(self._clock.now(), self._check_end):
            is_late = True
        if is_late:
            self.overruns += 1
            self._deadline = self._clock.now()
        if self._timer:
            self._timer.end_tick()
        if self._pace:
            self._hold(self._pace)

    def _hold(self, pace: PaceControl) -> None:
        if pace.is_paused:
            pace.hold(self._clock.now(), self._check_end)
            self._begin_timing()

    def _begin_timing(self) -> None:
        if self._timer:
            self._timer.begin_tick()

    def _check_end(self) -> None:
        self._latch.check()
        self._check_signals()
