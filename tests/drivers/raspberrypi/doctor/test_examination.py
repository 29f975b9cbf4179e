from __future__ import annotations

import sys
from importlib import resources
from pathlib import Path
from unittest.mock import Mock

import pytest

from drivers.raspberrypi.backend import RaspberryPiBackend
from drivers.raspberrypi.doctor import examine
from robotcore.description import load_robot
from robotcore.errors import DescriptionError, Mistake
from robotcore.hal.check_finding import Finding, Level
from tests.drivers.raspberrypi.doctor.conftest import CheckFindings
from tests.drivers.raspberrypi.doctor.test_devices import EYE, NOSE

BACKEND = RaspberryPiBackend()


@pytest.fixture(autouse=True)
def _replace_programs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Replace the programs and libraries of a Pi, which a tree of files does not have."""
    place = "drivers.raspberrypi.doctor"
    for name in ("library", "power"):
        monkeypatch.setattr(f"{place}.check_{name}", lambda *_, name=name: [Finding.ok(name, "right", kind=name)])
    about = {"PRETTY_NAME": "Debian GNU/Linux 13 (trixie)", "VERSION_CODENAME": "trixie"}
    monkeypatch.setattr("platform.freedesktop_os_release", lambda: about)
    monkeypatch.setattr(f"{place}.check_pins", lambda bindings: [Finding.ok("pins", "free", kind="pins-free")])


def levels(found: list[Finding]) -> dict[str, Level]:
    return {each.subject: each.level for each in found}


def test_on_a_laptop_the_only_finding_is_that_it_is_no_pi(tmp_path: Path, check_findings: CheckFindings) -> None:
    check_findings(examine(BACKEND, None, tmp_path), "no-raspberry-pi")


def test_a_robots_file_is_checked_on_a_laptop_too(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    shipped = resources.files("robotcore.description").joinpath("robots/rover.toml").read_text(encoding="utf-8")
    file.write_text(shipped, encoding="utf-8")
    _, found = examine(BACKEND, load_robot(str(file)), tmp_path)
    assert (found.level, found.kind) == (Level.OK, "description-ok")
    file.write_text(shipped.replace("trigger = 16", "trigger = 40").replace('"picamera2"', '"csi"'), encoding="utf-8")
    _, *wrong = examine(BACKEND, load_robot(str(file)), tmp_path)
    assert [each.message.partition(":")[0] for each in wrong] == ["raspberrypi.nose.trigger", "raspberrypi.eye.driver"]
    assert {each.level for each in wrong} == {Level.ERROR}
    file.write_text(shipped.partition("# On a Raspberry Pi")[0], encoding="utf-8")
    assert len(list(examine(BACKEND, load_robot(str(file)), tmp_path))) == 1


def test_a_good_pi_has_only_ok_findings(pi_4: Path, pi_5: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(BACKEND, "bind", lambda *_: (NOSE, EYE))
    for pi in (pi_4, pi_5):
        found = list(examine(BACKEND, load_robot("rover"), pi))
        assert set(levels(found).values()) == {Level.OK}
        subjects = {"board", "system", "killed runs", "permissions", "robot", "pins", "camera", "clock"}
        assert subjects <= set(levels(found))


def test_a_check_that_fails_is_not_ok_and_the_others_run(pi_4: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("platform.freedesktop_os_release", Mock(side_effect=OSError("unable to read the file")))
    found = levels(list(examine(BACKEND, None, pi_4)))
    assert (found["board"], found["system"], found["clock"]) == (Level.OK, Level.WARNING, Level.OK)


def test_without_a_robot_a_finding_says_that_devices_are_not_checked(pi_4: Path) -> None:
    found = list(examine(BACKEND, None, pi_4))
    assert [each.kind for each in found if each.subject == "robot"] == ["no-robot"]
    assert "pins" not in levels(found)


def test_a_mistake_in_a_robots_section_is_an_error_and_devices_are_not_checked(
    pi_4: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mistakes = DescriptionError.of_all("robot rover", [Mistake("is missing", "Add it", key="raspberrypi.nose")])
    monkeypatch.setattr(BACKEND, "bind", Mock(side_effect=mistakes))
    found = levels(list(examine(BACKEND, load_robot("rover"), pi_4)))
    assert found["robot"] is Level.ERROR
    assert "camera" not in found


def test_picamera2_is_checked_if_a_device_needs_it(pi_4: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "picamera2", None)
    found = list(examine(BACKEND, load_robot("rover"), pi_4))
    assert [each.kind for each in found if each.subject == "picamera2"] == ["picamera2-missing"]
