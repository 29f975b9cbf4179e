"""test_settings."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any

import pytest
from pydantic import Field

from robotcore.errors import BehaviourError, UnknownNameError, UsageError
from robotcore.hal.robot import Robot
from robotcore.runtime.behaviour import Behaviour, Status
from robotcore.runtime.settings import configure, settings_of


@dataclass
class App(Behaviour):
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

    def step(self, robot: Robot) -> Status:
        return Status.SUCCESS


@dataclass
class Misspelt(Behaviour):
    speed_m_s: Annotated[flaot, Field(gt=0)] = 0.25  # type: ignore[name-defined]  # noqa: F821

    def step(self, robot: Robot) -> Status:
        return Status.SUCCESS


@dataclass
class Dividing(Behaviour):
    ratio: float = field(default_factory=lambda: 1 / 0)

    def step(self, robot: Robot) -> Status:
        return Status.SUCCESS


@dataclass
class Demanding(Behaviour):
    goal: str

    def step(self, robot: Robot) -> Status:
        return Status.SUCCESS


class Plain(Behaviour):
    def step(self, robot: Robot) -> Status:
        return Status.SUCCESS


def test_settings_are_the_fields_that_can_be_given() -> None:
    defaults = {name: setting.default for name, setting in settings_of(App).items()}
    assert defaults == {"speed_m_s": 0.25, "hue": "green", "laps": 3, "is_loud": False, "hues": ["green"]}


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
def test_values_become_what_the_field_says(name: str, given: Any, value: Any) -> None:
    got = getattr(configure(App, {name: given}), name)
    assert got == value
    assert type(got) is type(value)


def test_what_is_not_given_keeps_its_default() -> None:
    assert configure(App, {"laps": 5}) == App(laps=5)


@pytest.mark.parametrize(
    "name, given, fault",
    [
        ("speed_m_s", "fast", "setting speed_m_s: .*number.*; the default is 0.25"),
        ("speed_m_s", "0", "greater than 0.*; the default is 0.25"),
        ("speed_m_s", "nan", "greater than 0"),
        ("laps", "2.5", "setting laps: .*integer.*; the default is 3"),
        ("is_loud", "maybe", "setting is_loud: .*; the default is False"),
    ],
)
def test_a_value_that_does_not_fit_is_refused_with_the_default(name: str, given: str, fault: str) -> None:
    with pytest.raises(UsageError, match=fault):
        configure(App, {name: given})


def test_an_unknown_setting_offers_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match=r"unknown setting 'sped_m_s'. Did you mean 'speed_m_s'\?"):
        configure(App, {"sped_m_s": "1"})


def test_what_is_no_setting_cannot_be_set() -> None:
    with pytest.raises(UnknownNameError):
        configure(App, {"turned": "1"})
    with pytest.raises(UsageError, match=r"Plain is no dataclass. Put @dataclass above it"):
        configure(Plain, {"state": "end"})


def test_a_setting_without_a_default_must_be_given() -> None:
    with pytest.raises(UsageError, match="the app needs the setting goal; give it: --set goal=VALUE"):
        configure(Demanding, {})
    assert configure(Demanding, {"goal": "red"}) == Demanding("red")


def test_an_app_may_refuse_its_settings() -> None:
    with pytest.raises(UsageError, match=r"^no hue$"):
        configure(App, {"hue": "none"})


def test_an_app_that_raises_while_it_is_made_is_to_blame() -> None:
    with pytest.raises(BehaviourError, match="App raised ZeroDivisionError") as raised:
        configure(App, {"laps": 7})
    assert isinstance(raised.value.__cause__, ZeroDivisionError)


@pytest.mark.parametrize("app, fault", [(Misspelt, "NameError: name 'flaot'"), (Dividing, "ZeroDivisionError")])
def test_settings_that_cannot_be_reported_are_the_fault_of_the_app(app: type[Behaviour], fault: str) -> None:
    with pytest.raises(BehaviourError, match=f"^{app.__name__} raised {fault}"):
        settings_of(app)
