from __future__ import annotations

from importlib import resources
from pathlib import Path

import pytest

from drivers.raspberrypi.doctor import examine
from robotcore.description import load_robot
from robotcore.errors import DescriptionError
from robotcore.hal.finding import Finding, Level
from tests.drivers.raspberrypi.doctor.conftest import CheckFindings
from tests.drivers.raspberrypi.doctor.test_ports import EYE, NOSE


@pytest.fixture(autouse=True)
def _as_on_a_board(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is asked of programs and libraries, which a tree of files cannot answer."""
    place = "drivers.raspberrypi.doctor.examination"
    for name in ("library", "power"):
        monkeypatch.setattr(f"{place}.check_{name}", lambda *_, name=name: [Finding.ok(name, "as it should be")])
    monkeypatch.setattr(f"{place}.check_pins", lambda fittings: [Finding.ok("pins", "free")])


def levels(found: list[Finding]) -> dict[str, Level]:
    return {each.what: each.level for each in found}


def bind_devices(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("drivers.raspberrypi.doctor.examination.bind_devices", lambda *_: (NOSE, EYE))


def test_a_laptop_is_reported_that_it_is_no_pi_and_nothing_else(tmp_path: Path, check_findings: CheckFindings) -> None:
    check_findings(examine(None, "raspberrypi", tmp_path), "no-raspberry-pi")


def test_at_the_desk_a_robot_s_file_is_looked_at_all_the_same(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    shipped = resources.files("robotcore.description").joinpath("robots/rover.toml").read_text(encoding="utf-8")
    file.write_text(shipped, encoding="utf-8")
    _, found = examine(load_robot(str(file)), "raspberrypi", tmp_path)
    assert found == Finding.ok("robot", f"{file} OK, 6 devices, 13 wires")
    file.write_text(shipped.replace("trigger = 16", "trigger = 40").replace('"picamera2"', '"csi"'), encoding="utf-8")
    _, *wrong = examine(load_robot(str(file)), "raspberrypi", tmp_path)
    assert [each.said.partition(":")[0] for each in wrong] == ["raspberrypi.nose.trigger", "raspberrypi.eye.driver"]
    assert {each.level for each in wrong} == {Level.ERROR}
    file.write_text(shipped.partition("# On a Raspberry Pi")[0], encoding="utf-8")
    assert len(list(examine(load_robot(str(file)), "raspberrypi", tmp_path))) == 1


def test_a_pi_on_which_all_is_well_has_nothing_but_ok(pi_4: Path, pi_5: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    bind_devices(monkeypatch)
    for pi in (pi_4, pi_5):
        found = list(examine(load_robot("rover"), "raspberrypi", pi))
        assert set(levels(found).values()) == {Level.OK}
        assert {"board", "system", "killed runs", "permissions", "robot", "pins", "camera", "clock"} <= set(
            levels(found)
        )


def test_a_broken_pi_is_reported_all_that_is_wrong_each_with_its_remedy(
    broken: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bind_devices(monkeypatch)
    found = list(examine(load_robot("rover"), "raspberrypi", broken))
    wrong = {each.what: each.level for each in found if each.level is not Level.OK}
    assert (
        wrong.items()
        >= {
            "board": Level.WARNING,
            "system": Level.WARNING,
            "killed runs": Level.WARNING,
            "camera": Level.ERROR,
            "clock": Level.WARNING,
        }.items()
    )


def test_what_cannot_be_checked_is_no_ok_and_keeps_nothing_else_from_being_checked(pi_4: Path) -> None:
    (pi_4 / "etc/os-release").unlink()
    (pi_4 / "proc/self/exe").unlink()
    found = levels(list(examine(None, "raspberrypi", pi_4)))
    assert (found["board"], found["system"], found["clock"]) == (Level.WARNING, Level.WARNING, Level.OK)


def test_without_a_robot_its_devices_are_said_not_to_be_looked_at(pi_4: Path) -> None:
    found = list(examine(None, "raspberrypi", pi_4))
    assert [each.kind for each in found if each.what == "robot"] == ["no-robot"]
    assert "pins" not in levels(found)


def test_each_fault_of_a_robots_section_is_an_error_and_its_devices_are_left_alone(
    pi_4: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def unfit(*_: object) -> None:
        raise DescriptionError.of_all("robot rover", [("raspberrypi.nose", "is missing", "Add it"), ("b", "c", "D")])

    monkeypatch.setattr("drivers.raspberrypi.doctor.examination.bind_devices", unfit)
    found = list(examine(load_robot("rover"), "raspberrypi", pi_4))
    findings = [(each.level, each.said, each.remedy) for each in found if each.what == "robot"]
    assert findings == [(Level.ERROR, "raspberrypi.nose: is missing", "Add it"), (Level.ERROR, "b: c", "D")]
    assert "camera" not in levels(found)


def test_what_may_do_harm_as_it_is_connected_is_a_warning(pi_4: Path) -> None:
    rover = load_robot("rover")
    section = rover.backends["raspberrypi"]
    left = {**section["left_motor"], "standby": 8}
    right = {**section["right_motor"], "standby": 8}
    wired = rover.model_copy(
        update={"backends": {"raspberrypi": {**section, "left_motor": left, "right_motor": right}}}
    )
    found = list(examine(wired, "raspberrypi", pi_4))
    findings = [each for each in found if each.what == "robot" and each.level is Level.WARNING]
    assert [each.said.partition(":")[0] for each in findings] == ["left_motor", "right_motor"]
    assert "GPIO 8 may turn this motor" in findings[0].said
    assert findings[0].remedy.startswith("Take GPIO 9 to 27")
