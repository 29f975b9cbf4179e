"""Backends of boards open the batteries of their file's sections. Simulators open none."""

from __future__ import annotations

from pathlib import Path

import pytest

from drivers.raspberrypi.backend import RaspberryPiBackend
from robotcore.description import load_robot, load_world
from robotcore.hal.backend import Setup, load_backend
from robotcore.hal.check_finding import Finding
from tests.doubles.battery_backend import load_battery_rover

SECTIONS = "".join(f'\n[{section}.cells]\ndriver = "of-tomorrow"\n' for section in ("raspberrypi", "serial"))


@pytest.mark.parametrize(
    "backend, batteries",
    [("serial", {"cells"}), ("raspberrypi", {"cells"}), ("virtualpi", set()), ("kinematic", set()), ("mock", set())],
)
def test_backend_opens_the_batteries_in_its_section(tmp_path: Path, backend: str, batteries: set[str]) -> None:
    rover = load_battery_rover(tmp_path)
    file = Path(str(rover.file))
    assert load_backend(backend).batteries(rover, {}) == set()
    file.write_text(file.read_text() + SECTIONS)
    description = load_robot(str(file))
    assert load_backend(backend).batteries(description, {}) == batteries
    every_device = {device.name for device in description.devices}
    assert load_backend(backend).openable(description, {}) == every_device - {"cells"} | batteries


@pytest.mark.parametrize("backend", ["kinematic", "mujoco", "pybullet", "virtualpi", "mock"])
def test_simulator_opens_no_battery(tmp_path: Path, backend: str) -> None:
    opener = load_backend(backend)
    if not opener.is_installed:
        pytest.skip(opener.remedy)
    rover = load_battery_rover(tmp_path)
    every_device = frozenset(device.name for device in rover.devices)
    with opener.open(Setup(rover, load_world("open"), every_device)) as robot:
        assert set(robot.devices) == every_device - {"cells"}


@pytest.mark.parametrize("is_native_host", [True, False])
def test_doctor_reads_batteries_only_on_a_raspberry_pi(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *, is_native_host: bool
) -> None:
    found = Finding.ok("cells", "7.40 V", kind="voltage")
    monkeypatch.setattr("robotcore.hardware.diagnosis.diagnose_batteries", lambda *_: [found])
    monkeypatch.setattr(RaspberryPiBackend, "is_native_host", is_native_host)
    assert (found in list(RaspberryPiBackend().examine(load_battery_rover(tmp_path)))) is is_native_host
