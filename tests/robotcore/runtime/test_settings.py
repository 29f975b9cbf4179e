"""Settings of apps: `list_settings` and `configure`."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any

import pytest
from pydantic import Field

from robotcore.errors import BehaviourError, UnknownNameError, UsageError
from robotcore.hal.robot import Robot
from robotcore.runtime.behaviour import Behaviour, Status
from robotcore.runtime.settings import configure, list_changes, list_settings
from tests.texts import Raises


class PlainApp(Behaviour):
    def step(self, robot: Robot) -> Status:
        return Status.SUCCESS


@dataclass
class App(PlainApp):
    speed_m_s: Annotated[float, Field(gt=0)] = 0.25
    hue: str = "green"
    laps: int = 3
    is_loud: bool = False
    hues: list[str] = field(default_factory=lambda: ["green"])
    turned: float = field(default=0.0, init=False)

    def __post_init__(self) -> None:
        if self.hue == "none":
            raise UsageError("no hue")
        self.inverse = 1 / (self.laps - 7)


@dataclass
class InvalidAnnotationApp(PlainApp):
    speed_m_s: Annotated[flaot, Field(gt=0)] = 0.25  # type: ignore[name-defined]  # noqa: F821


@dataclass
class FailingDefaultApp(PlainApp):
    ratio: float = field(default_factory=lambda: 1 / 0)


@dataclass
class RequiredSettingApp(PlainApp):
    goal: str


@dataclass
class TwoSettingsApp(PlainApp):
    laps: int
    status: Status = Status.SUCCESS


def test_settings_are_the_fields_of_the_constructor() -> None:
    defaults = {name: setting.default for name, setting in list_settings(App).items()}
    assert defaults == {"speed_m_s": 0.25, "hue": "green", "laps": 3, "is_loud": False, "hues": ["green"]}


def test_message_has_the_default_as_a_user_writes_it(raises: Raises) -> None:
    for name in ("laps", "status"):
        with raises(UsageError, "setting-invalid", setting=name):
            configure(TwoSettingsApp, {name: "up"})


def test_changes_are_the_settings_of_an_instance_that_differ_from_the_defaults() -> None:
    assert list_changes(App(speed_m_s=0.5, hues=["red"])) == {"speed_m_s": 0.5, "hues": ["red"]}
    assert list_changes(PlainApp()) == {}


@pytest.mark.parametrize(
    "name, given, value",
    [
        ("speed_m_s", "0.5", 0.5),
        ("speed_m_s", 1, 1.0),
        ("laps", "12", 12),
        ("is_loud", "true", True),
        ("is_loud", "no", False),
        ("hue", "12", "12"),
        ("hues", ["red", "blue"], ["red", "blue"]),
    ],
)
def test_values_are_converted_to_the_type_of_the_field(name: str, given: Any, value: Any) -> None:
    got = getattr(configure(App, {name: given}), name)
    assert got == value
    assert type(got) is type(value)


@pytest.mark.parametrize(
    "name, given",
    [("speed_m_s", "fast"), ("speed_m_s", "0"), ("speed_m_s", "nan"), ("laps", "2.5"), ("is_loud", "maybe")],
)
def test_value_of_another_type_is_refused(name: str, given: str, raises: Raises) -> None:
    with raises(UsageError, "setting-invalid", setting=name):
        configure(App, {name: given})


def test_error_for_an_unknown_setting_offers_the_nearest(raises: Raises) -> None:
    with raises(UnknownNameError, "unknown-setting", name="sped_m_s"):
        configure(App, {"sped_m_s": "1"})


def test_other_attributes_cannot_be_set(raises: Raises) -> None:
    with pytest.raises(UnknownNameError):
        configure(App, {"turned": "1"})
    with raises(UsageError, "not-a-dataclass"):
        configure(PlainApp, {"state": "end"})


def test_attribute_without_a_type_is_no_setting(raises: Raises) -> None:
    class Square(PlainApp):
        side = 0.5

    with raises(UsageError, "not-a-dataclass"):
        configure(Square, {"side": "1"})
    with raises(UsageError, "setting-without-type", setting="side"):
        configure(dataclass(Square), {"side": "1"})


def test_setting_without_a_default_is_required(raises: Raises) -> None:
    with raises(UsageError, "setting-missing", setting="goal"):
        configure(RequiredSettingApp, {})
    assert configure(RequiredSettingApp, {"goal": "red"}) == RequiredSettingApp("red")


def test_exception_in_the_apps_constructor_is_a_behaviour_error(raises: Raises) -> None:
    with raises(BehaviourError) as raised:
        configure(App, {"laps": 7})
    assert isinstance(raised.value.__cause__, ZeroDivisionError)


@pytest.mark.parametrize("app, cause", [(InvalidAnnotationApp, NameError), (FailingDefaultApp, ZeroDivisionError)])
def test_exception_in_a_type_or_default_is_a_behaviour_error(
    app: type[Behaviour], cause: type[Exception], raises: Raises
) -> None:
    with raises(BehaviourError) as raised:
        list_settings(app)
    assert isinstance(raised.value.__cause__, cause)
