"""The header, its GPIOs, and the notes of drivers for connecting a device."""

from __future__ import annotations

from typing import Any

import pytest
from gpiozero import PiBoardInfo
from pydantic import ValidationError

from drivers.raspberrypi.encoders import Pulses, Quadrature
from drivers.raspberrypi.header import HEADER, Gpio, build_wiring, find_pads, gpio
from drivers.raspberrypi.motors.boards import HBridge, PhaseEnable
from drivers.raspberrypi.ranging.time_of_flight_driver import VL53L0X
from drivers.raspberrypi.ranging.ultrasonic_driver import Ultrasonic
from robotcore.description import StrictModel
from robotcore.hal.wiring import Wire
from robotcore.hardware import Connection, DeviceDriver
from tests.drivers.raspberrypi.doctor.trees import SuppliedDriver, binding
from tests.texts import CheckText

PI_4 = 0xC03111


def test_the_header_equals_gpiozeros() -> None:
    theirs = PiBoardInfo.from_revision(PI_4).headers["J8"]
    assert len(HEADER) == len(theirs.pins) == 40
    plain = {"3V3": "3.3 V", "5V": "5 V", "GND": "ground", "GPIO0": "ID_SD", "GPIO1": "ID_SC"}
    for pad in HEADER:
        name = theirs.pins[pad.number].name
        assert pad.name == plain.get(name, name.replace("GPIO", "GPIO "))


def test_a_plug_and_an_address_have_no_pad() -> None:
    laser = binding("nose", gpio("SDA", 2, is_shared=True), Connection("address", "I2C", "0x29 on bus 1"))
    camera = binding("eye", Connection("camera", "CSI", "0"))
    assert [wire.pads for wire in build_wiring([laser, camera]).wires] == [(3,), (), ()]


def test_a_serial_port_on_the_header_uses_two_pins_and_one_ground_and_another_port_none(check_text: CheckText) -> None:
    header, usb = (
        binding("left_motor", Connection("port", "serial", f"/dev/{name}")) for name in ("serial0", "ttyUSB0")
    )
    wiring = build_wiring([header, header, usb])
    assert [(wire.signal, wire.pads[:1]) for wire in wiring.wires] == [
        ("port", ()),
        ("sends", (8,)),
        ("receives", (10,)),
        ("ground", (9,)),
        ("port", ()),
        ("sends", (8,)),
        ("receives", (10,)),
        ("port", ()),
    ]
    check_text("\n".join(f"{name}: {note}" for name, note in wiring.notes))


def test_supply_wires_go_to_the_nearest_free_pads() -> None:
    first = binding("left_encoder", gpio("a", 5), kind=SuppliedDriver)
    second = binding("right_encoder", gpio("a", 6), kind=SuppliedDriver)
    wires = build_wiring([first, second]).wires
    assert wires[1] == Wire("left_encoder", "encoder, plugged", "supply", "3.3 V", (17, 1))
    assert wires[2].pads[0] == 30
    assert [wire.pads[0] for wire in wires if wire.signal == "supply"] == [17, 1]
    assert sorted(wires[2].pads) == list(find_pads("ground"))
    assert wires[5].pads[0] != 30


@pytest.mark.parametrize("number, pad", [(0, 27), (15, 10)])
def test_a_gpio_that_the_pi_itself_uses_has_a_pad_and_a_note(number: int, pad: int, check_text: CheckText) -> None:
    wiring = build_wiring([binding("nose", gpio("trigger", number), notes=("hold it level",))])
    assert [wire.pads for wire in wiring.wires] == [(pad,)]
    own, (name, note) = wiring.notes
    assert (own, name) == (("nose", "hold it level"), "nose")
    check_text(note)


class Settings(StrictModel):
    echo: Gpio


@pytest.mark.parametrize("number", [40, -1])
def test_the_number_of_a_pad_in_place_of_a_gpio_is_explained(number: int, check_text: CheckText) -> None:
    with pytest.raises(ValidationError) as raised:
        Settings(echo=number)
    check_text(raised.value.errors()[0]["msg"])


MODEL = {"dead_band": 0.1, "forward_rad_s": 14.0, "backward_rad_s": 14.0}


@pytest.mark.parametrize(
    "driver, supply, settings",
    [
        (Ultrasonic, ("5 V", "ground"), {"trigger": 16, "echo": 26}),
        (HBridge, ("ground",), {"forward": 17, "backward": 27, "model": MODEL, "standby": 22}),
        (HBridge, ("ground",), {"forward": 17, "backward": 27, "model": MODEL}),
        (HBridge, ("ground",), {"forward": 17, "backward": 27, "model": MODEL, "enable": 12}),
        (PhaseEnable, ("ground",), {"phase": 17, "enable": 27, "model": MODEL}),
        (Quadrature, ("3.3 V", "ground"), {"a": 5, "b": 6}),
        (Pulses, ("3.3 V", "ground"), {"gpio": 5}),
        (VL53L0X, ("3.3 V", "ground"), {}),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_the_notes_and_the_supply_of_a_driver_protect_the_gpios(
    driver: type[DeviceDriver], supply: tuple[str, ...], settings: dict[str, Any], check_text: CheckText
) -> None:
    assert driver.supply == supply
    assert all(find_pads(name) for name in driver.supply)
    check_text(" ".join(driver(**settings).notes(None)))
