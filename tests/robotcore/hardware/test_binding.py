from __future__ import annotations

from pathlib import Path

import pytest

from robotcore.description import RobotDescription, load_robot
from robotcore.errors import BackendMissingError, DescriptionError
from robotcore.hardware import bind_devices
from tests.robotcore.hardware.device_drivers import EYE, NECK, PlugBoard, register, robot_file
from tests.texts import CheckText, Raises

CELLS = '[plugboard.cells]\ndriver = "plug"\npin = 4\n'


@pytest.fixture(autouse=True)
def _installed(monkeypatch: pytest.MonkeyPatch) -> None:
    register(monkeypatch)


@pytest.fixture
def post(tmp_path: Path) -> Path:
    return tmp_path / "post.toml"


def described(file: Path, section: str) -> RobotDescription:
    file.write_text(robot_file(section))
    return load_robot(str(file))


def mistakes_of(file: Path, section: str) -> list[DescriptionError]:
    with pytest.raises(DescriptionError) as caught:
        bind_devices(described(file, section), "plugboard")
    mistakes = [caught.value, *caught.value.others]
    assert {mistake.file for mistake in mistakes} == {str(file)}
    return mistakes


def keys_of(file: Path, section: str) -> list[str]:
    return [mistake.key for mistake in mistakes_of(file, section)]


def test_devices_are_bound_in_the_order_of_the_file(post: Path) -> None:
    neck, eye = bind_devices(described(post, EYE + NECK), "plugboard")
    assert [(each.name, each.driver.name) for each in (neck, eye)] == [("neck", "motor-plug"), ("eye", "plug")]
    assert [str(wire) for wire in neck.driver.connections()] == ["hole 1"]
    assert neck.notes == ("Push it in all the way.",)


def test_a_file_with_another_section_is_reported_with_its_backend(post: Path, check_text: CheckText) -> None:
    (error,) = mistakes_of(post, '[serial.neck]\ndriver = "any"\n')
    check_text(error.remedy)


def test_only_the_requested_devices_need_a_section(post: Path) -> None:
    (neck,) = bind_devices(described(post, NECK), "plugboard", {"neck"})
    assert neck.name == "neck"


def test_the_section_of_a_device_that_is_not_requested_is_checked_too(post: Path, raises: Raises) -> None:
    with raises(DescriptionError, "out-of-bounds", key="plugboard.eye.pin"):
        bind_devices(described(post, NECK + EYE.replace("2", "10")), "plugboard", {"neck"})


def test_a_display_needs_no_wires_but_may_have_some(post: Path) -> None:
    screen = EYE.replace("eye", "screen").replace("2", "3")
    assert [each.name for each in bind_devices(described(post, NECK + EYE + screen), "plugboard")] == [
        "neck",
        "eye",
        "screen",
    ]


def test_a_battery_is_bound_only_if_the_section_has_it(post: Path) -> None:
    cells = '[[devices]]\nkind = "battery"\nname = "cells"\n'
    for section, batteries in ((cells + EYE + NECK, set()), (cells + CELLS + EYE + NECK, {"cells"})):
        robot = described(post, section)
        assert PlugBoard().openable(robot, {}) == {"neck", "eye", "screen", *batteries}
        assert {each.name for each in bind_devices(robot, "plugboard")} == {"neck", "eye", *batteries}


def test_a_file_without_the_section_is_reported_once(post: Path, check_text: CheckText) -> None:
    (mistake,) = mistakes_of(post, "")
    assert mistake.key == "plugboard"
    check_text(mistake)


def test_a_display_alone_needs_no_section(post: Path) -> None:
    assert bind_devices(described(post, ""), "plugboard", {"screen"}) == ()


@pytest.mark.parametrize(
    "right, wrong, key",
    [
        pytest.param(EYE, "", "eye", id="no-table"),
        pytest.param(EYE, "[plugboard]\neye = 3\n", "eye", id="a-number"),
        pytest.param('driver = "plug"', "", "eye.driver", id="no-driver"),
        pytest.param('"plug"', '"plugg"', "eye.driver", id="one-letter-too-many"),
        pytest.param('"plug"', '"Jack 42B"', "eye.driver", id="alias"),
        pytest.param('"plug"', '"bana"', "eye.driver", id="begin-of-an-alias"),
        pytest.param('"plug"', '"a"', "eye.driver", id="a-letter"),
        pytest.param('"plug"', '"motor-plgu"', "eye.driver", id="near-another-kind"),
        pytest.param('"plug"', "4", "eye.driver", id="driver-a-number"),
        pytest.param('"plug"', '["plug"]', "eye.driver", id="driver-a-list"),
        pytest.param('"plug"', '"motor-plug"', "eye.driver", id="another-kind"),
        pytest.param("pin = 2", "", "eye.pin", id="no-pin"),
        pytest.param("pin", "pni", "eye.pni", id="unknown-key"),
        pytest.param("2", '"2"', "eye.pin", id="pin-in-quotes"),
        pytest.param("2", "9", "eye", id="refused-by-the-driver"),
        pytest.param("2", "1", "eye.pin", id="pin-of-another-device"),
        pytest.param("2", "2\nspare = 2", "eye.spare", id="pin-twice"),
    ],
)
def test_each_mistake_is_reported_with_its_key_and_remedy(
    post: Path, right: str, wrong: str, key: str, check_text: CheckText
) -> None:
    (mistake,) = mistakes_of(post, NECK + EYE.replace(right, wrong))
    assert mistake.key == f"plugboard.{key}"
    check_text(mistake)


@pytest.mark.parametrize("name", ["screm", "eyes", "whiskers"])
def test_an_unknown_device_is_reported_with_the_nearest_name_that_has_no_section(
    post: Path, name: str, check_text: CheckText
) -> None:
    other = EYE.replace("eye", name).replace("2", "3")
    (mistake,) = mistakes_of(post, NECK + EYE + other)
    assert mistake.key == f"plugboard.{name}"
    check_text(mistake)


def test_a_device_with_a_misspelt_section_is_not_reported_as_missing(post: Path, check_text: CheckText) -> None:
    (mistake,) = mistakes_of(post, NECK + EYE.replace("eye", "eey"))
    assert mistake.key == "plugboard.eey"
    check_text(mistake)


def test_all_mistakes_are_reported_at_once(post: Path) -> None:
    section = NECK.replace("pin = 1", "pin = 0") + EYE.replace("driver", "drive")
    assert keys_of(post, section) == ["plugboard.neck.pin", "plugboard.eye.driver"]


def test_several_devices_may_use_a_shared_connection(post: Path) -> None:
    bind_devices(described(post, NECK + "bus = 1\n" + EYE + "bus = 1\n"), "plugboard")


def test_a_driver_that_cannot_be_loaded_is_reported_and_never_suggested(
    post: Path, monkeypatch: pytest.MonkeyPatch, raises: Raises, check_text: CheckText
) -> None:
    register(monkeypatch, broken="no_such_package:Thing")
    with raises(BackendMissingError):
        bind_devices(described(post, NECK + EYE.replace('"plug"', '"broken"')), "plugboard")
    (mistake,) = mistakes_of(post, NECK)
    check_text(mistake)
