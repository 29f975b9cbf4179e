"""Device drivers of other packages on a Pi: what can be told of them before they are opened."""

from __future__ import annotations

import pytest

from drivers.raspberrypi.backend import RaspberryPiBackend
from drivers.raspberrypi.virtual.backend import VirtualPiBackend
from robotcore.errors import DescriptionError
from robotcore.hal.backend import Backend
from tests.drivers.raspberrypi import foreign
from tests.drivers.raspberrypi.foreign import rover


@pytest.fixture(autouse=True)
def _installed(monkeypatch: pytest.MonkeyPatch) -> None:
    foreign.install(monkeypatch)


@pytest.mark.parametrize("backend", [RaspberryPiBackend(), VirtualPiBackend()])
def test_a_gpio_that_is_not_on_the_header_is_refused_whoever_wrote_the_driver(backend: Backend) -> None:
    with pytest.raises(DescriptionError) as raised:
        backend.check(rover(nose={"driver": "ir-switch", "out": 40}))
    assert str(raised.value) == (
        "robot rover: raspberrypi.nose.out: there is no GPIO 40 on the header; pad 40 of the header is GPIO 21. "
        "Take 0 to 27, the numbers of the chip (BCM)"
    )
    assert backend.check(rover(nose={"driver": "ir-switch", "out": 16})).startswith("6 devices")


def test_an_encoder_without_a_direction_needs_a_motor_whose_driver_tells_one() -> None:
    pulses = {"driver": "pulses", "gpio": 5}
    assert RaspberryPiBackend().check(rover(left_encoder=pulses))
    assert RaspberryPiBackend().check(rover(left_motor={"driver": "hat"}))
    with pytest.raises(DescriptionError) as raised:
        RaspberryPiBackend().check(rover(left_encoder=pulses, left_motor={"driver": "hat"}))
    assert str(raised.value) == (
        "robot rover: raspberrypi.left_encoder: the driver of left_motor, 'hat', tells no direction, and left_encoder "
        "has none of its own. Take a quadrature encoder for that wheel"
    )
