"""The backend `virtualpi`: the drivers on virtual pins, the replaced devices, opening and closing."""

from __future__ import annotations

import gc
import json
import threading
import weakref
from dataclasses import replace
from typing import Any

import pytest

from drivers.kinematic.backend import KinematicBackend
from drivers.raspberrypi.encoders import PinEncoder
from drivers.raspberrypi.motors.boards import HBridge
from drivers.raspberrypi.ranging.ultrasonic_driver import Sonar, Ultrasonic
from drivers.raspberrypi.virtual.backend import VirtualPiBackend
from drivers.raspberrypi.virtual.models import MODELLED, SIMULATED, VirtualPins
from robotcore import RunRequest
from robotcore.cli.main import execute
from robotcore.description import (
    RangeSensorDescription,
    RobotDescription,
    WorldDescription,
    load_robot,
)
from robotcore.errors import (
    DeviceClosedError,
    DeviceError,
    UsageError,
)
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.devices import RangeSensor
from robotcore.hal.robot import Robot
from robotcore.hardware.motor_model import DutyMotor
from robotcore.plugins import DEVICES, device_driver_names, load_registered
from robotcore.runtime.plan import Plan
from robotcore.testing import worlds
from tests.drivers.raspberrypi import foreign
from tests.texts import Raises

ROVER = load_robot("rover")
NOSE = next(device for device in ROVER.devices if isinstance(device, RangeSensorDescription))


def build_setup(*devices: str, world: WorldDescription | None = None, **options: Any) -> Setup:
    chosen = devices or tuple(device.name for device in ROVER.devices)
    return Setup(ROVER, world or worlds.empty(), frozenset(chosen), options=options)


def _rewire(device: str, **changed: Any) -> RobotDescription:
    """Return the rover with other settings of a device's driver."""
    section = ROVER.backends["raspberrypi"]
    wiring = section | {device: section[device] | changed}
    return ROVER.model_copy(update={"backends": {"raspberrypi": wiring}})


def measure_distances(setup: Setup, seconds: float = 3.0) -> list[float]:
    """Return the distance of each new sample."""
    samples: dict[int, float] = {}
    with VirtualPiBackend().open(setup) as robot:
        for tick in range(round(seconds * 20)):
            sample = robot.range.read()
            samples[sample.sequence] = sample.distance
            robot.clock.sleep_until((tick + 1) / 20)
    return list(samples.values())


def test_devices_on_pins_use_the_drivers_of_a_real_pi_and_others_are_the_simulator_s_own() -> None:
    with KinematicBackend().open(build_setup()) as simulated, VirtualPiBackend().open(build_setup()) as robot:
        assert isinstance(robot["left_motor"], DutyMotor)
        assert isinstance(robot["right_encoder"], PinEncoder)
        assert isinstance(robot["nose"], Sonar)
        assert {name: type(robot[name]) for name in ("eye", "screen")} == {
            name: type(simulated[name]) for name in ("eye", "screen")
        }


def test_no_thread_and_no_guardian_is_started() -> None:
    before = threading.enumerate()
    with VirtualPiBackend().open(build_setup()) as robot:
        robot.clock.sleep_until(1.0)
        assert threading.enumerate() == before
        assert robot.cutoffs == ()


def test_wheel_turns_at_the_duty_that_is_sent_in_whole_percent() -> None:
    assert _measure_rotation(build_setup(), 5.03) == pytest.approx(14 * (0.42 - 0.10) / 0.90, abs=0.003)


@pytest.mark.parametrize("board", [{"pwm": 13}, {"enable": 12}])
def test_a_board_with_a_line_more_turns_the_wheel_as_commanded(board: dict[str, int]) -> None:
    setup = replace(build_setup(), robot=_rewire("left_motor", **board))
    assert _measure_rotation(setup, -7.0) == pytest.approx(-7.0, abs=0.01)


def test_control_by_the_encoder_corrects_the_rounding_to_whole_percent() -> None:
    setup = replace(build_setup(), robot=_rewire("left_motor", control={}))
    assert _measure_rotation(setup, 5.03) == pytest.approx(5.03, abs=0.02)


def _measure_rotation(setup: Setup, rad_s: float) -> float:
    """Return the rotation of the left wheel in a second, at a constant velocity. The encoder resolves 0.0016 rad."""
    with VirtualPiBackend().open(setup) as robot:
        motor, encoder = robot["left_motor"], robot["left_encoder"]
        assert isinstance(motor, DutyMotor)
        assert isinstance(encoder, PinEncoder)
        motor.set_velocity(rad_s)
        robot.clock.sleep_until(2.0)
        before = encoder.read().angle
        robot.clock.sleep_until(3.0)
        return encoder.read().angle - before


@pytest.mark.parametrize("share, most", [(0.0, 51), (0.5, 35), (1.0, 0)])
def test_lost_echoes_give_no_samples(share: float, most: int) -> None:
    world = worlds.wall(NOSE.mount, 0.7)
    samples = [
        distance for distance in measure_distances(build_setup("nose", world=world, lost_echoes=share)) if distance < 2
    ]
    assert samples == pytest.approx([0.7] * len(samples), abs=0.001)
    assert most - 20 < len(samples) <= most


def test_the_seed_decides_which_echoes_are_lost() -> None:
    first, same, other = (_list_sample_times(seed) for seed in (1, 1, 2))
    assert first == same != other


def _list_sample_times(seed: int) -> list[float]:
    """Return the times of the samples of a run in which half of the echoes are lost."""
    setup = build_setup("nose", world=worlds.wall(NOSE.mount, 0.7), lost_echoes="0.5")
    times = []
    with VirtualPiBackend().open(replace(setup, seed=seed)) as robot:
        for tick in range(1, 41):
            robot.clock.sleep_until(tick / 20)
            times.append(robot.range.read().time)
    return times


@pytest.mark.parametrize("name", ["virtualpi", "replay"])
def test_a_backend_that_does_not_simulate_in_lockstep_is_refused(name: str, raises: Raises) -> None:
    with raises(UsageError, "no-lockstep-simulator"):
        VirtualPiBackend().open(build_setup(simulator=name))


def test_an_invalid_share_of_lost_echoes_is_refused(raises: Raises) -> None:
    with raises(UsageError, "invalid-option", option="lost_echoes"):
        VirtualPiBackend().open(build_setup(lost_echoes="1.1"))


def test_driver_that_fails_leaves_no_simulator_open(monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    def fail(*_: object) -> RangeSensor:
        raise DeviceError("nose", "broken")

    monkeypatch.setattr(Ultrasonic, "open", fail)
    simulated = _recorded_robots(monkeypatch)
    with raises(DeviceError):
        VirtualPiBackend().open(build_setup())
    _require_closed(simulated)


def test_an_interruption_when_all_are_open_leaves_nothing_open(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> list[object]:
        raise KeyboardInterrupt

    closed: list[str] = []
    monkeypatch.setattr(DutyMotor, "_release", lambda motor: closed.append(motor.name))
    monkeypatch.setattr(HBridge, "cutoffs", fail)
    simulated = _recorded_robots(monkeypatch)
    with pytest.raises(KeyboardInterrupt):
        VirtualPiBackend().open(build_setup())
    assert closed == ["right_motor", "left_motor"]
    _require_closed(simulated)


def _recorded_robots(monkeypatch: pytest.MonkeyPatch) -> list[Robot]:
    """Return the list of all simulated robots that were opened."""
    kept: list[Robot] = []
    plain = KinematicBackend.open

    def record_robot(backend: Backend, setup: Setup) -> Robot:
        kept.append(plain(backend, setup))  # type: ignore[arg-type]  # it is a kinematic one
        return kept[-1]

    monkeypatch.setattr(KinematicBackend, "open", record_robot)
    return kept


def _require_closed(simulated: list[Robot]) -> None:
    (robot,) = simulated
    with pytest.raises(DeviceClosedError):
        robot.range.read()


@pytest.mark.slow
def test_a_closed_robot_leaves_nothing_open(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[weakref.ref[VirtualPins]] = []
    plain = VirtualPins.__init__

    def note_pins(pins: VirtualPins, clock: Any) -> None:
        plain(pins, clock)
        made.append(weakref.ref(pins))

    monkeypatch.setattr(VirtualPins, "__init__", note_pins)
    for _ in range(3):
        with VirtualPiBackend().open(build_setup()) as robot:
            robot.clock.sleep_until(0.2)
    del robot  # the last reference
    gc.collect()
    assert [ref() for ref in made] == [None, None, None]


IR = {"driver": "ir-switch", "out": 16}
NOTE = "nose: its driver 'ir-switch' does not run on virtualpi; the simulator's own range sensor stands in"


@pytest.fixture
def _install_drivers(monkeypatch: pytest.MonkeyPatch) -> None:
    foreign.install(monkeypatch)


def test_every_driver_has_a_model_or_is_replaced_by_the_simulator() -> None:
    ours = [load_registered("device driver", DEVICES, name) for name in device_driver_names()]
    kinds = {driver.name: driver.settings for driver in ours if driver.__module__.startswith("drivers.raspberrypi.")}
    assert len(kinds) >= 9
    assert [name for name, settings in kinds.items() if not issubclass(settings, MODELLED + SIMULATED)] == []


@pytest.mark.usefixtures("_install_drivers")
def test_a_run_has_the_note_in_its_result_and_on_standard_error(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("robotcore.hal.backend.load_robot", lambda _: foreign.rover(nose=IR))
    assert Plan.of(RunRequest("avoid-obstacles", "virtualpi")).notes == (NOTE,)
    assert execute(["run", "avoid-obstacles", "--backend", "virtualpi", "--set", "duration_s=0.5", "--json"]) == 0
    output = capfd.readouterr()
    assert output.err == f"note: {NOTE}\n"
    payload: dict[str, Any] = json.loads(output.out)
    assert payload["notes"] == [NOTE]


@pytest.mark.usefixtures("_install_drivers")
def test_the_doctor_lists_the_devices_that_the_simulator_replaces() -> None:
    (found,) = VirtualPiBackend().examine(foreign.rover(nose=IR))
    assert (found.kind, found.message) == (
        "stand-ins",
        "the simulator's own device stands in for nose (ir-switch), eye (picamera2)",
    )
    assert list(VirtualPiBackend().examine(None)) == []
