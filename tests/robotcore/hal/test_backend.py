from __future__ import annotations

from robotcore.description import StrictModel
from robotcore.errors import BackendMissingError, UnknownNameError, UsageError
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.robot import Robot
from tests.robotcore.fakes import ROVER, RigBackend
from tests.texts import Raises


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


def test_unknown_option_suggests_the_nearest(raises: Raises) -> None:
    with raises(UnknownNameError, "unknown-option"):
        options(prt=1).options_as(Options)


def test_option_of_the_wrong_type_is_refused_by_name(raises: Raises) -> None:
    with raises(UsageError, "invalid-option", option="port"):
        options(port="high").options_as(Options)


def test_chosen_devices_are_in_the_order_of_the_file() -> None:
    setup = Setup(ROVER, None, frozenset({"eye", "right_motor", "nose"}))
    assert [device.name for device in setup.chosen_devices] == ["right_motor", "nose", "eye"]


def test_backend_that_is_not_installed_has_a_remedy(raises: Raises) -> None:
    backend = Missing()
    assert not backend.is_installed
    with raises(BackendMissingError):
        backend.require_installed()


def test_a_backend_that_needs_no_library_is_installed() -> None:
    RigBackend().require_installed()
