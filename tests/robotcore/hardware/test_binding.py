from __future__ import annotations

from pathlib import Path

import pytest

from robotcore.description import RobotDescription, load_robot
from robotcore.errors import BackendMissingError, DescriptionError
from robotcore.hardware import batteries_in, bind_devices
from tests.robotcore.hardware.device_drivers import EYE, NECK, register, robot_file

CELLS = '[plugboard.cells]\ndriver = "plug"\npin = 4\n'

UNBOUND = (
    "is missing. Say how it is connected, first of all its driver: plug; or, where the robot has none, take 'eye' out "
    "of its [[devices]]"
)


@pytest.fixture(autouse=True)
def _installed(monkeypatch: pytest.MonkeyPatch) -> None:
    register(monkeypatch)


@pytest.fixture
def post(tmp_path: Path) -> Path:
    return tmp_path / "post.toml"


def described(file: Path, section: str) -> RobotDescription:
    file.write_text(robot_file(section))
    return load_robot(str(file))


def mistakes_of(file: Path, section: str) -> list[str]:
    with pytest.raises(DescriptionError) as raised:
        bind_devices(described(file, section), "plugboard")
    faults = [line.partition(f"{file}: ") for line in str(raised.value).splitlines()]
    assert {before for before, *_ in faults} == {""}
    return [fault for *_, fault in faults]


def test_devices_are_fitted_in_the_order_of_the_file_whoever_brings_their_drivers(post: Path) -> None:
    neck, eye = bind_devices(described(post, EYE + NECK), "plugboard")
    assert [(each.name, each.driver.name) for each in (neck, eye)] == [("neck", "motor-plug"), ("eye", "plug")]
    assert [str(wire) for wire in neck.connections] == ["hole 1"]
    assert neck.notes == ("Push it in all the way.",)


def test_only_devices_that_are_asked_for_need_be_reported_of(post: Path) -> None:
    (neck,) = bind_devices(described(post, NECK), "plugboard", {"neck"})
    assert neck.name == "neck"


def test_what_is_reported_of_a_device_that_nobody_asks_for_must_be_right_too(post: Path) -> None:
    with pytest.raises(DescriptionError, match=r"plugboard.eye.pin: should be at most 9, got 10"):
        bind_devices(described(post, NECK + EYE.replace("2", "10")), "plugboard", {"neck"})


def test_a_display_needs_no_wires_but_may_have_some(post: Path) -> None:
    screen = EYE.replace("eye", "screen").replace("2", "3")
    assert [each.name for each in bind_devices(described(post, NECK + EYE + screen), "plugboard")] == [
        "neck",
        "eye",
        "screen",
    ]


def test_a_battery_is_there_only_where_the_section_tells_of_it(post: Path) -> None:
    cells = '[[devices]]\nkind = "battery"\nname = "cells"\n'
    for section, batteries in ((cells + EYE + NECK, set()), (cells + CELLS + EYE + NECK, {"cells"})):
        robot = described(post, section)
        assert batteries_in(robot, "plugboard") == batteries
        assert {each.name for each in bind_devices(robot, "plugboard")} == {"neck", "eye", *batteries}


def test_a_file_without_the_section_is_reported_once(post: Path) -> None:
    assert mistakes_of(post, "") == [
        "plugboard: is missing. Say how each device is connected, from [plugboard.neck] on"
    ]


def test_a_display_alone_needs_no_section(post: Path) -> None:
    assert bind_devices(described(post, ""), "plugboard", {"screen"}) == ()


@pytest.mark.parametrize(
    "right, wrong, expected",
    [
        (EYE, "", f"eye: {UNBOUND}"),
        (EYE, "[plugboard]\neye = 3\n", "eye: should be a table, got 3. Name its driver: plug"),
        ('driver = "plug"', "", "eye.driver: is missing. Add it: plug"),
        ('"plug"', '"plugg"', "eye.driver: unknown device driver 'plugg'. Did you mean 'plug'?"),
        ('"plug"', '"Jack 42B"', "eye.driver: unknown device driver 'Jack 42B'. Did you mean 'plug'?"),
        ('"plug"', '"bana"', "eye.driver: unknown device driver 'bana'. Did you mean 'plug'?"),
        ('"plug"', '"a"', "eye.driver: unknown device driver 'a'. There are: plug."),
        ('"plug"', '"motor-plgu"', "eye.driver: unknown device driver 'motor-plgu'. There are: plug."),
        ('"plug"', "4", "eye.driver: should be a name in quotes, got 4. Name one: plug"),
        ('"plug"', '"motor-plug"', "eye.driver: 'motor-plug' opens no camera. Name one: plug"),
        ("pin = 2", "", "eye.pin: is missing. Add it: the number of a hole, 1 to 9"),
        ("pin", "pni", "eye.pni: is unknown. Correct it or take it out. Did you mean 'pin'?"),
        ("2", '"2"', "eye.pin: should be the number of a hole, 1 to 9, got '2'. Correct it"),
        ("2", "9", "eye: hole 9 is stopped up. Take another one"),
        ("2", "1", "eye.pin: hole 1 is already plugboard.neck.pin. Connect one of them elsewhere"),
        ("2", "2\nspare = 2", "eye.spare: hole 2 is already plugboard.eye.pin. Connect one of them elsewhere"),
    ],
)
def test_each_fault_is_reported_in_a_line_with_its_key_and_remedy(
    post: Path, right: str, wrong: str, expected: str
) -> None:
    assert mistakes_of(post, NECK + EYE.replace(right, wrong)) == [f"plugboard.{expected}"]


@pytest.mark.parametrize(
    "name, remedy",
    [
        ("screm", "Did you mean 'screen'?"),
        ("eyes", "Take the section out, or add [[devices]] of that name"),
        ("whiskers", "Take the section out, or add [[devices]] of that name"),
    ],
)
def test_a_device_that_the_robot_has_not_is_reported_with_the_nearest_that_has_no_section(
    post: Path, name: str, remedy: str
) -> None:
    other = EYE.replace("eye", name).replace("2", "3")
    assert mistakes_of(post, NECK + EYE + other) == [f"plugboard.{name}: no device has this name. {remedy}"]


def test_a_device_whose_section_is_misspelt_is_not_said_to_be_missing_too(post: Path) -> None:
    misspelt = EYE.replace("eye", "eey")
    assert mistakes_of(post, NECK + misspelt) == ["plugboard.eey: no device has this name. Did you mean 'eye'?"]


def test_all_faults_are_sent_at_once(post: Path) -> None:
    section = NECK.replace("pin = 1", "pin = 0") + EYE.replace("driver", "drive")
    assert [line.partition(":")[0] for line in mistakes_of(post, section)] == [
        "plugboard.neck.pin",
        "plugboard.eye.driver",
    ]


def test_what_may_be_shared_may_have_several_and_what_may_not_has_one(post: Path) -> None:
    bind_devices(described(post, NECK + "bus = 1\n" + EYE + "bus = 1\n"), "plugboard")


def test_a_driver_that_cannot_be_loaded_is_reported_as_such_and_offered_to_nobody(
    post: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    register(monkeypatch, broken="no_such_package:Thing")
    with pytest.raises(BackendMissingError, match=r"the device driver 'broken' .* cannot be loaded"):
        bind_devices(described(post, NECK + EYE.replace('"plug"', '"broken"')), "plugboard")
    assert mistakes_of(post, NECK) == [f"plugboard.eye: {UNBOUND}"]
