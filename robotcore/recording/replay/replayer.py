"""What holds an app to a recording: over the devices that serve its samples, and at each tick."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

from robotcore.errors import RobotcoreError
from robotcore.geometry import Wheels
from robotcore.hal.devices import Battery, Motor, SampleT, Sensor, Voltage
from robotcore.recording import Recording
from robotcore.recording.replay.likeness import Likeness
from robotcore.recording.replay.motor import ReplayedMotor, require_all
from robotcore.recording.replay.script import Script
from robotcore.recording.replay.stage import ReplayedStage, again
from robotcore.runtime.layers.layer import Layer
from robotcore.runtime.layers.readers import Reader
from robotcore.runtime.outcome import RunResult
from robotcore.runtime.session import Run
from robotcore.runtime.trace import TickRecord
from robotcore.safety import Latch, Stage


class Replayer(Layer):
    """A tap and an observer in one. It ends the replay at the first tick that differs, with DeviationError.

    Samples come from the devices below; what the safety stage answered, and the angles of the wheels, come from here.
    """

    def __init__(self, recording: Recording, likeness: Likeness) -> None:
        self.script = Script(recording)
        self._likeness = likeness
        self._latch = Latch()
        self._stage: ReplayedStage | None = None

    def latch(self, latch: Latch) -> None:
        self._latch = latch

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        """Return what reads the sensor where the recorded run has read it too, as its app did."""

        def reader() -> SampleT:
            self.script.check()
            self._press()
            if not self.script.cues.was_read(sensor.name):
                self.script.lack(f"what is read of {sensor.name}", "not read in this tick", "read")
            for _ in range(self.script.cues.failed_others(sensor.name)):
                with suppress(RobotcoreError):
                    read()
            return read()

        return reader

    def battery(self, battery: Battery, read: Reader[Voltage]) -> Reader[Voltage]:
        """Return what reads the battery, held to nothing: it is read beside the app, at whatever pace."""
        return read

    def stage(self, stage: Stage) -> Stage:
        self._stage = ReplayedStage(self.script, self._likeness, self._latch)
        return self._stage

    def lone_motor(self, motor: Motor) -> Motor:
        return ReplayedMotor(motor, self.script, self._likeness, self._latch)

    def angles(self, read: Callable[[], Wheels]) -> Callable[[], Wheels]:
        """Return what reads the recorded angles."""

        def reader() -> Wheels:
            if self._stage:
                self._stage.begin_tick()
            self._press()
            turned = self.script.cues.next_turned()
            if turned and turned.error:
                again(turned.error, self._latch)
            return turned.angles if turned and turned.angles else read()

        return reader

    def begin(self, run: Run) -> None:
        """Nothing is compared before the first tick."""

    def tick(self, record: TickRecord) -> None:
        """Hold a tick to the recorded one. Where the app has just raised something new, `ending` tells."""
        script, tick = self.script, self.script.cues.tick
        if self._stage:
            self._stage.end_tick()
        script.check()
        if script.cues.is_cut_short:
            script.end()
        if self._stage and not self._stage.is_committed:
            if tick.error is None:
                return
            self._stage.require_all()
        require_all(script)
        if record.state != tick.state:
            script.deviate("the state", repr(tick.state), repr(record.state))
        script.go_on(record)
        if error := script.cues.ended_before:
            self._latch.set(error)

    def _press(self) -> None:
        """Press the e-stop where it was pressed."""
        if error := self.script.cues.pressed:
            self._latch.set(error)

    def end(self, result: RunResult) -> None:
        """Leave the end to `ending`."""
