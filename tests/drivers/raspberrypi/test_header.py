"""The header, its GPIOs, and the notes of drivers for connecting a device."""

from __future__ import annotations

from typing import Any

import pytest
from gpiozero import PiBoardInfo
from pydantic import ValidationError

from drivers.raspberrypi.encoders import Pulses, Quadrature
from drivers.raspberrypi.header import HEADER, Gpio, build_wiring, find_pads, gpio
from drivers.raspberrypi.motors.boards import HBridge, PhaseEnable
from drivers.raspberrypi.ranging.ultrasonic_driver import Ultrasonic
from robotcore.description import StrictModel
from robotcore.hal.wiring import PadKind, Wire
from robotcore.hardware import Connection, DeviceDriver
from tests.drivers.raspberrypi.doctor.trees import SuppliedDriver, binding
from tests.texts import CheckText

PI_4 = 0xC03111


def test_the_header_equals_gpiozero_s() -> None:
    theirs = PiBoardInfo.from_revision(PI_4).headers["J8"]
    assert len(HEADER) == len(theirs.pins) == 40
    plain = {"3V3": "3.3 V", "5V": "5 V", "GND": "ground", "GPIO0": "ID_SD", "GPIO1": "ID_SC"}
    for pad in HEADER:
        name = theirs.pins[pad.number].name
        assert pad.name == plain.get(name, name.replace("GPIO", "GPIO "))


def test_pads_of_power_and_ground_have_their_kinds() -> None:
    assert find_pads("3.3 V") == (1, 17)
    assert find_pads("5 V") == (2, 4)
    assert [pad.number for pad in HEADER if pad.kind is PadKind.GROUND] == [6, 9, 14, 20, 25, 30, 34, 39]
    assert [pad.name for pad in HEADER if pad.kind is PadKind.RESERVED] == ["ID_SD", "ID_SC"]


def test_signals_go_to_the_pads_of_their_gpios() -> None:
    wiring = build_wiring([binding("nose", gpio("trigger", 16), gpio("echo", 26))])
    assert [(wire.signal, wire.where, wire.pads) for wire in wiring.wires] == [
        ("trigger", "GPIO 16", (36,)),
        ("echo", "GPIO 26", (37,)),
    ]


def test_a_plug_and_an_address_have_no_pad() -> None:
    laser = binding("nose", gpio("SDA", 2, is_shared=True), Connection("address", "I2C", "0x29 on bus 1"))
    camera = binding("eye", Connection("camera", "CSI", "0"))
    assert [wire.pads for wire in build_wiring([laser, camera]).wires] == [(3,), (), ()]


def test_a_serial_port_on_the_header_uses_two_pins_and_another_port_none(check_text: CheckText) -> None:
    header, usb = (
        binding("left_motor", Connection("port", "serial", f"/dev/{name}")) for name in ("serial0", "ttyUSB0")
    )
    wiring = build_wiring([header, usb])
    assert [(wire.signal, wire.pads) for wire in wiring.wires] == [
        ("port", ()),
        ("sends", (8,)),
        ("receives", (10,)),
        ("port", ()),
    ]
    check_text("\n".join(f"{name}: {note}" for name, note in wiring.notes))


def test_a_reserved_gpio_has_a_pad() -> None:
    (wire,) = build_wiring([binding("nose", gpio("trigger", 0))]).wires
    assert (wire.where, wire.pads) == ("GPIO 0", (27,))


def test_supply_wires_go_to_the_nearest_free_pads() -> None:
    first = binding("left_encoder", gpio("a", 5), kind=SuppliedDriver)
    second = binding("right_encoder", gpio("a", 6), kind=SuppliedDriver)
    wires = build_wiring([first, second]).wires
    assert wires[1] == Wire("left_encoder", "encoder, plugged", "supply", "3.3 V", (17, 1))
    assert wires[2].pads[0] == 30
    assert [wire.pads[0] for wire in wires if wire.signal == "supply"] == [17, 1]
    assert sorted(wires[2].pads) == list(find_pads("ground"))
    assert wires[5].pads[0] != 30


def test_notes_go_with_their_device() -> None:
    wiring = build_wiring([binding("nose", notes=("mind the voltage", "hold it level")), binding("eye")])
    assert wiring.notes == (("nose", "mind the voltage"), ("nose", "hold it level"))


def test_more_devices_than_pads_share_them() -> None:
    names = ("left_motor", "right_motor", "left_encoder", "right_encoder")
    wires = build_wiring([binding(name, kind=SuppliedDriver) for name in names]).wires
    taken = [wire.pads[0] for wire in wires if wire.signal == "supply"]
    assert sorted(taken) == sorted(2 * find_pads("3.3 V"))


@pytest.mark.parametrize("number", [0, 1, 14, 15])
def test_a_gpio_that_the_pi_itself_uses_has_a_note(number: int, check_text: CheckText) -> None:
    ((name, note),) = build_wiring([binding("nose", gpio("trigger", number))]).notes
    assert name == "nose"
    check_text(note)


def test_an_ordinary_gpio_has_no_note() -> None:
    assert build_wiring([binding("nose", gpio("trigger", 16), Connection("address", "I2C", "0"))]).notes == ()


class Settings(StrictModel):
    echo: Gpio


@pytest.mark.parametrize("number", [0, 27])
def test_numbers_are_those_of_the_chip(number: int) -> None:
    assert Settings(echo=number).echo == number


@pytest.mark.parametrize("number", [40, 34, 41, -1])
def test_the_number_of_a_pad_in_place_of_a_gpio_is_explained(number: int, check_text: CheckText) -> None:
    with pytest.raises(ValidationError) as raised:
        Settings(echo=number)
    check_text(raised.value.errors()[0]["msg"])


MODEL = {"dead_band": 0.1, "forward_rad_s": 14.0, "backward_rad_s": 14.0}


def notes(driver: DeviceDriver[Any, Any], **settings: object) -> str:
    return " ".join(driver.notes(None, driver.settings.model_validate(settings)))


def test_the_note_of_an_ultrasonic_module_protects_the_gpio_of_its_echo(check_text: CheckText) -> None:
    check_text(notes(Ultrasonic(), trigger=16, echo=26))


@pytest.mark.parametrize(
    "driver, lines",
    [(HBridge(), {"forward": 17, "backward": 27}), (PhaseEnable(), {"phase": 17, "enable": 27})],
)
def test_motors_are_never_supplied_by_the_header(
    driver: DeviceDriver[Any, Any], lines: dict[str, int], check_text: CheckText
) -> None:
    assert driver.supply == ("ground",)
    check_text(notes(driver, model=MODEL, **lines))


def test_a_standby_line_needs_a_pull_down(check_text: CheckText) -> None:
    check_text(notes(HBridge(), forward=17, backward=27, model=MODEL, standby=22))


@pytest.mark.parametrize("driver, lines", [(Quadrature(), {"a": 5, "b": 6}), (Pulses(), {"gpio": 5})])
def test_encoders_are_supplied_with_the_voltage_of_the_pins(
    driver: DeviceDriver[Any, Any], lines: dict[str, int], check_text: CheckText
) -> None:
    assert driver.supply == ("3.3 V", "ground")
    check_text(notes(driver, **lines))


@pytest.mark.parametrize("driver", [HBridge(), PhaseEnable(), Ultrasonic(), Quadrature(), Pulses()])
def test_every_supply_is_on_the_header(driver: DeviceDriver[Any, Any]) -> None:
    assert all(find_pads(name) for name in driver.supply)
