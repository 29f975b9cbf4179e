"""test_backend."""

from __future__ import annotations

import pytest

from robotcore.description import StrictModel
from robotcore.errors import BackendMissingError, UnknownNameError, UsageError
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.robot import Robot
from tests.robotcore.fakes import ROVER, RigBackend


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


def test_an_unknown_option_offers_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match=r"unknown option 'prt'. Did you mean 'port'\?"):
        options(prt=1).options_as(Options)


def test_an_option_that_does_not_fit_is_refused_by_name() -> None:
    with pytest.raises(UsageError, match=r"option port: .*integer.*'high'"):
        options(port="high").options_as(Options)


def test_chosen_devices_come_in_the_order_of_the_file() -> None:
    setup = Setup(ROVER, None, frozenset({"eye", "right_motor", "nose"}))
    assert [device.name for device in setup.chosen] == ["right_motor", "nose", "eye"]


def test_a_backend_that_is_not_installed_says_how_to_get_it() -> None:
    backend = Missing()
    assert not backend.is_installed
    with pytest.raises(BackendMissingError, match=r"'missing' is not installed. pip install no_such_simulator json"):
        backend.require_installed()


def test_a_backend_that_needs_no_library_is_installed() -> None:
    RigBackend().require_installed()
