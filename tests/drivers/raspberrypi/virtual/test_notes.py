"""What is told of devices whose drivers do not run on virtual pins."""

from __future__ import annotations

import json
from typing import Any

import pytest

from drivers.raspberrypi.virtual.backend import VirtualPiBackend
from drivers.raspberrypi.virtual.bench import MODELLED, SIMULATED
from robotcore import RunRequest
from robotcore.cli.main import execute
from robotcore.description import DisplayDescription, RobotDescription, load_robot
from robotcore.hal.backend import Setup
from robotcore.plugins import DEVICES, device_driver_names, load_registered
from robotcore.runtime.plan import Plan
from tests.drivers.raspberrypi import foreign

IR = {"driver": "ir-switch", "out": 16}
NOTE = "nose: its driver 'ir-switch' does not run on virtualpi; the simulator's own range sensor stands in"


@pytest.fixture
def _installed(monkeypatch: pytest.MonkeyPatch) -> None:
    foreign.install(monkeypatch)


def notes(robot: RobotDescription, *devices: str) -> list[str]:
    chosen = devices or [device.name for device in robot.devices if not isinstance(device, DisplayDescription)]
    return VirtualPiBackend().notes(Setup(robot, None, frozenset(chosen)))


def test_every_driver_for_a_pi_alone_is_modelled_or_means_to_be_the_simulator_s() -> None:
    ours = [load_registered("device driver", DEVICES, name) for name in device_driver_names()]
    kinds = {driver.name: driver.settings for driver in ours if driver.__module__.startswith("drivers.raspberrypi.")}
    assert len(kinds) >= 9
    assert [name for name, settings in kinds.items() if not issubclass(settings, MODELLED + SIMULATED)] == []


def test_the_shipped_rover_needs_no_note() -> None:
    assert notes(load_robot("rover")) == []


@pytest.mark.usefixtures("_installed")
def test_a_driver_of_another_package_is_told_where_its_device_is_opened() -> None:
    assert notes(foreign.rover(nose=IR)) == [NOTE]
    assert notes(foreign.rover(nose=IR), "eye") == []


@pytest.mark.usefixtures("_installed")
def test_a_run_has_the_note_in_its_result_and_on_standard_error(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("robotcore.hal.backend.load_robot", lambda _: foreign.rover(nose=IR))
    assert Plan.of(RunRequest("avoid-obstacles", "virtualpi")).notes == (NOTE,)
    assert execute(["run", "avoid-obstacles", "--backend", "virtualpi", "--set", "duration_s=0.5", "--json"]) == 0
    said = capfd.readouterr()
    assert said.err == f"note: {NOTE}\n"
    told: dict[str, Any] = json.loads(said.out)
    assert told["notes"] == [NOTE]


@pytest.mark.usefixtures("_installed")
def test_the_doctor_tells_for_which_devices_of_a_robot_the_simulator_stands_in() -> None:
    (found,) = VirtualPiBackend().examine(foreign.rover(nose=IR))
    assert (found.kind, found.said) == (
        "stand-ins",
        "the simulator's own device stands in for nose (ir-switch), eye (picamera2)",
    )
    assert list(VirtualPiBackend().examine(None)) == []
