"""Device drivers of other packages on a Pi: checks before any device is opened."""

from __future__ import annotations

import pytest

from drivers.raspberrypi.backend import RaspberryPiBackend
from drivers.raspberrypi.virtual.backend import VirtualPiBackend
from robotcore.errors import DescriptionError
from robotcore.hal.backend import Backend
from tests.drivers.raspberrypi import foreign
from tests.drivers.raspberrypi.foreign import rover
from tests.texts import Raises


@pytest.fixture(autouse=True)
def _install_drivers(monkeypatch: pytest.MonkeyPatch) -> None:
    foreign.install(monkeypatch)


@pytest.mark.parametrize("backend", [RaspberryPiBackend(), VirtualPiBackend()])
def test_a_gpio_off_the_header_is_refused_also_for_drivers_of_other_packages(backend: Backend, raises: Raises) -> None:
    with raises(DescriptionError, key="raspberrypi.nose.out"):
        backend.check(rover(nose={"driver": "ir-switch", "out": 40}))
    assert backend.check(rover(nose={"driver": "ir-switch", "out": 16}))


def test_an_encoder_without_a_direction_needs_a_motor_that_reports_one(raises: Raises) -> None:
    pulses = {"driver": "pulses", "gpio": 5}
    assert RaspberryPiBackend().check(rover(left_encoder=pulses))
    assert RaspberryPiBackend().check(rover(left_motor={"driver": "hat"}))
    with raises(DescriptionError, key="raspberrypi.left_encoder"):
        RaspberryPiBackend().check(rover(left_encoder=pulses, left_motor={"driver": "hat"}))
