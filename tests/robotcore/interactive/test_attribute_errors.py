"""A live robot names a similar attribute for one that it does not have, or its manoeuvres."""

from __future__ import annotations

from operator import attrgetter
from typing import Any

import pytest

import robotcore
from robotcore.interactive.attribute_errors import MANOEUVRES
from robotcore.interactive.live_drive import LiveDrive
from tests.texts import CheckText

UNKNOWN = ["robot.drive.forward", "robot.drive.strait", "robot.forward", "robot.straight", "robot.rnage", "robot.truth"]


@pytest.fixture(scope="module")
def robot() -> Any:
    with robotcore.open(world="open") as opened:
        yield opened


@pytest.mark.parametrize("call", UNKNOWN)
def test_unknown_attribute_is_an_error_with_a_remedy(robot: Any, check_text: CheckText, call: str) -> None:
    with pytest.raises(AttributeError) as caught:
        attrgetter(call.removeprefix("robot."))(robot)
    check_text(caught.value)


@pytest.mark.slow
def test_robot_without_a_drive_has_no_attribute_of_a_drive() -> None:
    robot: Any
    with robotcore.open("lookout") as robot, pytest.raises(AttributeError, match="no attribute 'straight'"):
        robot.straight(1.0)


def test_property_that_fails_keeps_its_error(robot: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(type(robot), "map", property(lambda _: [].nothing))  # type: ignore[attr-defined]
    with pytest.raises(AttributeError, match="'list' object has no attribute 'nothing'"):
        robot.map  # noqa: B018


def test_question_of_a_protocol_has_the_usual_error(robot: Any) -> None:
    assert not hasattr(robot, "_repr_html_")
    with pytest.raises(AttributeError, match="'LiveDrive' object has no attribute '_ipython_display_'"):
        robot.drive._ipython_display_()


def test_true_state_has_one_name(robot: Any) -> None:
    assert "ground_truth" in dir(robot)
    assert "truth" not in dir(robot)


def test_each_manoeuvre_is_a_method_of_the_drive() -> None:
    methods = {name for name, each in vars(LiveDrive).items() if "See `robotcore." in (each.__doc__ or "")}
    assert methods == set(MANOEUVRES)
