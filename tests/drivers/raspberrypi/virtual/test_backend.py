"""The backend `virtualpi`: the drivers on virtual pins, the replaced devices, opening and closing."""

from __future__ import annotations

import json
import threading
from dataclasses import replace
from typing import Any
from unittest.mock import Mock

import pytest

from drivers.kinematic.backend import KinematicBackend
from drivers.raspberrypi.encoders import PinEncoder
from drivers.raspberrypi.motors.boards import HBridge
from drivers.raspberrypi.ranging.ultrasonic_driver import Sonar, Ultrasonic
from drivers.raspberrypi.virtual.backend import VirtualPiBackend
from drivers.raspberrypi.virtual.models import MODELLED_DRIVERS, SIMULATED_DRIVERS
from robotcore import RunRequest, run
from robotcore.cli.main import execute
from robotcore.description import WorldDescription, load_robot
from robotcore.errors import (
    DeviceClosedError,
    DeviceError,
    UnknownNameError,
    UsageError,
)
from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from robotcore.hardware.motor_model import DutyMotor
from robotcore.kinds.range_sensor import RangeSensorDescription
from robotcore.plugins import DEVICES, device_driver_names, load_registered
from robotcore.recording.replay.verification import replay
from robotcore.runtime.plan import Plan
from robotcore.testing import worlds
from tests.drivers.raspberrypi import third_party_driver
from tests.robotcore.recording.replay.memory import record_run
from tests.texts import Raises

ROVER = load_robot("rover")
NOSE = next(device for device in ROVER.devices if isinstance(device, RangeSensorDescription))


def build_setup(*devices: str, world: WorldDescription | None = None, **options: Any) -> Setup:
    chosen = devices or tuple(device.name for device in ROVER.devices)
    return Setup(ROVER, world or worlds.empty(), frozenset(chosen), options=options)


def test_devices_on_pins_use_the_drivers_of_a_real_pi_and_others_are_the_simulators_own() -> None:
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


def test_the_option_of_the_cameras_goes_to_the_simulator(raises: Raises) -> None:
    with raises(UnknownNameError, "unknown-option"):
        VirtualPiBackend().open(build_setup(camera="painted"))


def test_the_notes_of_the_simulator_are_notes_of_the_robot(monkeypatch: pytest.MonkeyPatch) -> None:
    open_simulated = KinematicBackend.open

    def open_with_note(backend: KinematicBackend, setup: Setup) -> Robot:
        robot = open_simulated(backend, setup)
        robot.notes = ("the pictures are painted",)
        return robot

    monkeypatch.setattr(KinematicBackend, "open", open_with_note)
    with VirtualPiBackend().open(build_setup()) as robot:
        assert robot.notes == ("the pictures are painted",)


@pytest.mark.parametrize(
    "changed, rad_s, turned",
    [
        ({}, 5.03, 14 * (0.42 - 0.10) / 0.90),  # the duty is sent in whole percent
        ({"pwm": 13}, -7.0, -7.0),
        ({"enable": 12}, -7.0, -7.0),
        ({"control": {}}, 5.03, 5.03),
    ],
)
def test_a_wheel_turns_at_the_duty_that_its_board_receives(
    changed: dict[str, Any], rad_s: float, turned: float
) -> None:
    section = ROVER.backends["raspberrypi"]
    wiring = section | {"left_motor": section["left_motor"] | changed}
    robot_description = ROVER.model_copy(update={"backends": {"raspberrypi": wiring}})
    with VirtualPiBackend().open(replace(build_setup(), robot=robot_description)) as robot:
        motor, encoder = robot["left_motor"], robot["left_encoder"]
        assert isinstance(motor, DutyMotor)
        assert isinstance(encoder, PinEncoder)
        motor.set_velocity(rad_s)
        robot.clock.sleep_until(2.0)
        before = encoder.read().angle
        robot.clock.sleep_until(3.0)
        assert encoder.read().angle - before == pytest.approx(turned, abs=0.02)


def measure(share: float, seed: int = 1) -> dict[float, float]:
    """Return the distance of each sample of a run in front of a wall, by its time."""
    setup = build_setup("nose", world=worlds.wall(NOSE.mount, 0.7), lost_echoes=share)
    with VirtualPiBackend().open(replace(setup, seed=seed)) as robot:
        samples = []
        for tick in range(1, 61):
            samples.append(robot.range.read())
            robot.clock.sleep_until(tick / 20)
    return {sample.time: sample.distance for sample in samples}


@pytest.mark.parametrize("share, most", [(0.0, 51), (0.5, 35), (1.0, 0)])
def test_lost_echoes_give_no_samples(share: float, most: int) -> None:
    samples = [distance for distance in measure(share).values() if distance < 2]
    assert samples == pytest.approx([0.7] * len(samples), abs=0.001)
    assert most - 20 < len(samples) <= most


def test_the_seed_decides_which_echoes_are_lost() -> None:
    assert measure(0.5).keys() == measure(0.5).keys() != measure(0.5, seed=2).keys()


@pytest.mark.parametrize("name", ["virtualpi", "replay"])
def test_a_backend_that_does_not_simulate_in_lockstep_is_refused(name: str, raises: Raises) -> None:
    with raises(UsageError, "no-lockstep-simulator"):
        VirtualPiBackend().open(build_setup(simulator=name))


def test_an_invalid_share_of_lost_echoes_is_refused(raises: Raises) -> None:
    with raises(UsageError, "invalid-option", option="lost_echoes"):
        VirtualPiBackend().open(build_setup(lost_echoes="1.1"))


@pytest.mark.parametrize(
    "driver, method, failure, closed",
    [
        (Ultrasonic, "open", DeviceError("nose", "broken"), 2),
        (HBridge, "cutoffs", KeyboardInterrupt(), 2),
    ],
    ids=["driver", "interruption"],
)
def test_an_opening_that_fails_leaves_nothing_open(
    driver: type[Any], method: str, failure: BaseException, closed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    simulated: list[Robot] = []
    released: list[str] = []
    open_simulated = KinematicBackend.open

    def record_robot(backend: KinematicBackend, setup: Setup) -> Robot:
        simulated.append(open_simulated(backend, setup))
        return simulated[-1]

    monkeypatch.setattr(KinematicBackend, "open", record_robot)
    monkeypatch.setattr(DutyMotor, "_release", lambda motor: released.append(motor.name))
    monkeypatch.setattr(driver, method, Mock(side_effect=failure))
    with pytest.raises(type(failure)):
        VirtualPiBackend().open(build_setup())
    assert len(released) == closed
    with pytest.raises(DeviceClosedError):
        simulated[0].range.read()


IR = {"driver": "ir-switch", "out": 16}
NOTE = "nose: its driver 'ir-switch' does not run on virtualpi; the simulator's own range sensor stands in"


def test_every_driver_has_a_model_or_is_replaced_by_the_simulator() -> None:
    ours = [load_registered("device driver", DEVICES, name) for name in device_driver_names()]
    kinds = {driver.name: driver for driver in ours if driver.__module__.startswith("drivers.raspberrypi.")}
    assert len(kinds) >= 9
    simulated = MODELLED_DRIVERS + SIMULATED_DRIVERS
    assert [name for name, driver in kinds.items() if not issubclass(driver, simulated)] == []


@pytest.mark.slow
def test_the_app_finds_the_ball_by_the_same_milestones_as_in_the_simulator() -> None:
    virtual, simulated = (run(RunRequest("green-search", name, seed=7)) for name in ("virtualpi", "kinematic"))
    assert virtual.verified
    assert list(virtual.milestones) == list(simulated.milestones)
    assert virtual.contacts == 0


@pytest.mark.slow
def test_a_recorded_run_replays_to_the_bit() -> None:
    assert replay(record_run(backend="virtualpi", seed=7)).is_equal


def test_a_run_has_the_note_in_its_result_and_on_standard_error(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    third_party_driver.install(monkeypatch)
    monkeypatch.setattr("robotcore.hal.backend.load_robot", lambda _: third_party_driver.rover(nose=IR))
    assert Plan.resolve(RunRequest("avoid-obstacles", "virtualpi")).notes == (NOTE,)
    assert execute(["run", "avoid-obstacles", "--backend", "virtualpi", "--set", "duration_s=0.5", "--json"]) == 0
    output = capfd.readouterr()
    assert output.err == f"note: {NOTE}\n"
    payload: dict[str, Any] = json.loads(output.out)
    assert payload["notes"] == [NOTE]


def test_the_doctor_lists_the_devices_that_the_simulator_replaces(monkeypatch: pytest.MonkeyPatch) -> None:
    third_party_driver.install(monkeypatch)
    (found,) = VirtualPiBackend().examine(third_party_driver.rover(nose=IR))
    assert (found.kind, found.message) == (
        "stand-ins",
        "the simulator's own device stands in for nose (ir-switch), eye (picamera2)",
    )
    assert list(VirtualPiBackend().examine(None)) == []
