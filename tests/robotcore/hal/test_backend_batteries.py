"""Which backends tell of a battery: a board whose section of the file does, and no simulator."""

from __future__ import annotations

from pathlib import Path

import pytest

from drivers.raspberrypi.backend import RaspberryPiBackend
from robotcore.description import load_robot, load_world
from robotcore.hal.backend import Setup, load_backend
from robotcore.hal.check_finding import Finding
from tests.doubles.powered import powered_rover

SECTIONS = "".join(f'\n[{section}.cells]\ndriver = "of-tomorrow"\n' for section in ("raspberrypi", "serial"))


@pytest.mark.parametrize(
    "backend, batteries",
    [("serial", {"cells"}), ("raspberrypi", {"cells"}), ("virtualpi", set()), ("kinematic", set()), ("mock", set())],
)
def test_a_board_tells_of_it_where_the_file_does(tmp_path: Path, backend: str, batteries: set[str]) -> None:
    rover = powered_rover(tmp_path)
    file = Path(str(rover.file))
    assert load_backend(backend).batteries(rover, {}) == set()
    file.write_text(file.read_text() + SECTIONS)
    answer = load_robot(str(file))
    assert load_backend(backend).batteries(answer, {}) == batteries
    everything = {device.name for device in answer.devices}
    assert load_backend(backend).openable(answer, {}) == everything - {"cells"} | batteries


@pytest.mark.parametrize("backend", ["kinematic", "mujoco", "pybullet", "virtualpi", "mock"])
def test_a_simulator_that_is_asked_for_it_leaves_it_out(tmp_path: Path, backend: str) -> None:
    opener = load_backend(backend)
    if not opener.is_installed:
        pytest.skip(opener.remedy)
    rover = powered_rover(tmp_path)
    everything = frozenset(device.name for device in rover.devices)
    with opener.open(Setup(rover, load_world("open"), everything)) as robot:
        assert set(robot.devices) == everything - {"cells"}


@pytest.mark.parametrize("is_native_host", [True, False])
def test_the_doctor_reads_a_battery_on_the_pi_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *, is_native_host: bool
) -> None:
    found = Finding.ok("cells", "7.40 V", kind="voltage")
    monkeypatch.setattr("robotcore.hardware.diagnosis.diagnose_batteries", lambda *_: [found])
    monkeypatch.setattr(RaspberryPiBackend, "is_native_host", is_native_host)
    assert (found in list(RaspberryPiBackend().examine(powered_rover(tmp_path)))) is is_native_host
