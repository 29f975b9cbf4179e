from __future__ import annotations

from pathlib import Path

import pytest

from drivers.raspberrypi.backend import RaspberryPiBackend
from robotcore.description import StrictModel, load_robot, load_world
from robotcore.errors import BackendMissingError, DeviceError, UnknownNameError, UsageError
from robotcore.hal.backend import Backend, Setup, load_backend
from robotcore.hal.check_finding import Finding
from robotcore.hal.robot import Robot
from tests.doubles import foreign_kinds
from tests.doubles.battery_backend import load_battery_rover
from tests.doubles.foreign_kinds import ThermometerDescription, rover_with
from tests.robotcore.fakes import ROVER, RigBackend
from tests.texts import Raises


class Options(StrictModel):
    port: int = 23000
    host: str = "localhost"


class Missing(Backend):
    name = "missing"
    modules = ("no_such_simulator", "json")

    def open(self, setup: Setup) -> Robot:
        raise NotImplementedError


def options(**given: object) -> Setup:
    return Setup(ROVER, None, frozenset(), options=given)


def test_options_become_the_backends_own_model() -> None:
    assert options(port="5").options_as(Options) == Options(port=5)


def test_unknown_option_suggests_the_nearest(raises: Raises) -> None:
    with raises(UnknownNameError, "unknown-option"):
        options(prt=1).options_as(Options)


def test_option_of_the_wrong_type_is_refused_by_name(raises: Raises) -> None:
    with raises(UsageError, "invalid-option", option="port"):
        options(port="high").options_as(Options)


def test_chosen_devices_are_in_the_order_of_the_file() -> None:
    setup = Setup(ROVER, None, frozenset({"eye", "right_motor", "nose"}))
    assert [device.name for device in setup.chosen_devices] == ["right_motor", "nose", "eye"]


def test_backend_that_is_not_installed_has_a_remedy(raises: Raises) -> None:
    backend = Missing()
    assert not backend.is_installed
    with raises(BackendMissingError):
        backend.require_installed()


def test_a_backend_that_needs_no_library_is_installed() -> None:
    RigBackend().require_installed()


SECTIONS = "".join(f'\n[{section}.cells]\ndriver = "of-tomorrow"\n' for section in ("raspberrypi", "serial"))


@pytest.mark.parametrize(
    "backend, batteries",
    [("serial", {"cells"}), ("raspberrypi", {"cells"}), ("virtualpi", set()), ("kinematic", set()), ("mock", set())],
)
def test_backend_opens_the_batteries_in_its_section(tmp_path: Path, backend: str, batteries: set[str]) -> None:
    rover = load_battery_rover(tmp_path)
    file = Path(str(rover.file))
    file.write_text(file.read_text() + SECTIONS)
    description = load_robot(str(file))
    every_device = {device.name for device in description.devices}
    assert load_backend(backend).openable(description, {}) == every_device - {"cells"} | batteries


@pytest.mark.parametrize("backend", ["kinematic", "mujoco", "pybullet", "virtualpi"])
def test_simulator_opens_no_battery(tmp_path: Path, backend: str) -> None:
    opener = load_backend(backend)
    if not opener.is_installed:
        pytest.skip(opener.remedy)
    rover = load_battery_rover(tmp_path)
    assert opener.openable(rover, {}) == frozenset(device.name for device in rover.devices) - {"cells"}
    with pytest.raises(DeviceError) as caught:
        opener.open(Setup(rover, load_world("open"), frozenset({"cells"})))
    (failure,) = getattr(caught.value, "failures", [caught.value])
    assert (failure.device, failure.kind) == ("cells", "not-simulated")


def test_simulator_opens_no_sensor_whose_kind_has_no_simulation(monkeypatch: pytest.MonkeyPatch) -> None:
    foreign_kinds.install(monkeypatch)
    rover = rover_with(ThermometerDescription(name="engine"))
    assert "engine" not in load_backend("kinematic").openable(rover, {})


@pytest.mark.parametrize("is_native_host", [True, False])
def test_doctor_reads_batteries_only_on_a_raspberry_pi(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *, is_native_host: bool
) -> None:
    found = Finding.ok("cells", "7.40 V", kind="voltage")
    monkeypatch.setattr("robotcore.hardware.diagnosis.diagnose_monitored", lambda *_: [found])
    monkeypatch.setattr(RaspberryPiBackend, "is_native_host", is_native_host)
    assert (found in list(RaspberryPiBackend().examine(load_battery_rover(tmp_path)))) is is_native_host
