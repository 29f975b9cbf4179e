"""The header, its GPIOs, and the notes of drivers for connecting a device."""

from __future__ import annotations

from typing import Any

import pytest
from gpiozero import PiBoardInfo
from pydantic import ValidationError

from drivers.raspberrypi.encoders import Pulses, Quadrature
from drivers.raspberrypi.header import HEADER, Gpio, gpio, pads_of, wiring_of
from drivers.raspberrypi.motors.boards import HBridge, PhaseEnable
from drivers.raspberrypi.ranging.ultrasonic import Ultrasonic
from robotcore.description import StrictModel
from robotcore.hal.wiring import PadKind, Wire
from robotcore.hardware import Connection, DeviceDriver
from tests.drivers.raspberrypi.doctor.trees import Fed, fitting

PI_4 = 0xC03111


def test_the_header_is_the_one_that_gpiozero_knows() -> None:
    theirs = PiBoardInfo.from_revision(PI_4).headers["J8"]
    assert len(HEADER) == len(theirs.pins) == 40
    plain = {"3V3": "3.3 V", "5V": "5 V", "GND": "ground", "GPIO0": "ID_SD", "GPIO1": "ID_SC"}
    for pad in HEADER:
        name = theirs.pins[pad.number].name
        assert pad.name == plain.get(name, name.replace("GPIO", "GPIO "))


def test_pads_of_power_and_ground_are_known_by_their_kind() -> None:
    assert pads_of("3.3 V") == (1, 17)
    assert pads_of("5 V") == (2, 4)
    assert [pad.number for pad in HEADER if pad.kind is PadKind.GROUND] == [6, 9, 14, 20, 25, 30, 34, 39]
    assert [pad.name for pad in HEADER if pad.kind is PadKind.RESERVED] == ["ID_SD", "ID_SC"]


def test_signals_go_to_the_pads_of_their_gpios() -> None:
    wiring = wiring_of([fitting("nose", gpio("trigger", 16), gpio("echo", 26))])
    assert [(wire.signal, wire.where, wire.pads) for wire in wiring.wires] == [
        ("trigger", "GPIO 16", (36,)),
        ("echo", "GPIO 26", (37,)),
    ]


def test_a_plug_and_an_address_have_no_pad() -> None:
    laser = fitting("nose", gpio("SDA", 2, is_shared=True), Connection("address", "I2C", "0x29 on bus 1"))
    camera = fitting("eye", Connection("camera", "CSI", "0"))
    assert [wire.pads for wire in wiring_of([laser, camera]).wires] == [(3,), (), ()]


def test_a_serial_port_on_the_header_takes_two_pins_and_another_none() -> None:
    header, usb = (
        fitting("left_motor", Connection("port", "serial", f"/dev/{name}")) for name in ("serial0", "ttyUSB0")
    )
    wiring = wiring_of([header, usb])
    assert [(wire.signal, wire.pads) for wire in wiring.wires] == [
        ("port", ()),
        ("sends", (8,)),
        ("hears", (10,)),
        ("port", ()),
    ]
    assert [note.split(",")[0] for _, note in wiring.notes] == [
        "The port sends on GPIO 14",
        "GPIO 14 and 15 are the serial console's where it is switched on",
    ]


def test_a_reserved_gpio_has_a_pad_all_the_same() -> None:
    (wire,) = wiring_of([fitting("nose", gpio("trigger", 0))]).wires
    assert (wire.where, wire.pads) == ("GPIO 0", (27,))


def test_what_feeds_a_device_is_shown_on_the_nearest_pads_that_are_free() -> None:
    first = fitting("left_encoder", gpio("a", 5), kind=Fed)
    second = fitting("right_encoder", gpio("a", 6), kind=Fed)
    wires = wiring_of([first, second]).wires
    assert wires[1] == Wire("left_encoder", "encoder, plugged", "supply", "3.3 V", (17, 1))
    assert wires[2].pads[0] == 30
    assert [wire.pads[0] for wire in wires if wire.signal == "supply"] == [17, 1]
    assert sorted(wires[2].pads) == list(pads_of("ground"))
    assert wires[5].pads[0] != 30


def test_notes_go_with_their_device() -> None:
    wiring = wiring_of([fitting("nose", notes=("mind the voltage", "hold it level")), fitting("eye")])
    assert wiring.notes == (("nose", "mind the voltage"), ("nose", "hold it level"))


def test_two_devices_more_than_there_are_pads_share_them() -> None:
    names = ("left_motor", "right_motor", "left_encoder", "right_encoder")
    wires = wiring_of([fitting(name, kind=Fed) for name in names]).wires
    taken = [wire.pads[0] for wire in wires if wire.signal == "supply"]
    assert sorted(taken) == sorted(2 * pads_of("3.3 V"))


@pytest.mark.parametrize("number, text", [(0, "HAT"), (1, "HAT"), (14, "serial console"), (15, "serial console")])
def test_a_gpio_that_the_pi_has_a_use_for_itself_is_noted_with_any_device(number: int, text: str) -> None:
    ((name, note),) = wiring_of([fitting("nose", gpio("trigger", number))]).notes
    assert name == "nose"
    assert text in note


def test_a_gpio_that_is_free_is_not_noted() -> None:
    assert wiring_of([fitting("nose", gpio("trigger", 16), Connection("address", "I2C", "0"))]).notes == ()


class Settings(StrictModel):
    echo: Gpio


@pytest.mark.parametrize("number", [0, 27])
def test_numbers_are_those_of_the_chip(number: int) -> None:
    assert Settings(echo=number).echo == number


@pytest.mark.parametrize(
    "number, text",
    [
        (40, "there is no GPIO 40 on the header; pad 40 of the header is GPIO 21; take 0 to 27"),
        (34, "pad 34 of the header is ground; take"),
        (41, "there is no GPIO 41 on the header; take"),
        (-1, "there is no GPIO -1 on the header; take"),
    ],
)
def test_the_number_of_a_pad_is_reported_from_that_of_a_gpio(number: int, text: str) -> None:
    with pytest.raises(ValidationError, match=text):
        Settings(echo=number)


MODEL = {"dead_band": 0.1, "forward_rad_s": 14.0, "backward_rad_s": 14.0}


def notes(driver: DeviceDriver[Any, Any], **settings: object) -> str:
    return " ".join(driver.notes(None, driver.settings.model_validate(settings)))


def test_the_echo_of_an_ultrasonic_module_is_too_high_for_its_own_gpio() -> None:
    text = notes(Ultrasonic(), trigger=16, echo=26)
    assert "5 V" in text
    assert "1 kΩ from the echo to GPIO 26, and 2 kΩ from there to ground" in text


@pytest.mark.parametrize(
    "driver, lines",
    [(HBridge(), {"forward": 17, "backward": 27}), (PhaseEnable(), {"phase": 17, "enable": 27})],
)
def test_motors_are_never_fed_from_the_header(driver: DeviceDriver[Any, Any], lines: dict[str, int]) -> None:
    assert driver.supply == ("ground",)
    assert "a battery of their own" in notes(driver, model=MODEL, **lines)


def test_a_standby_line_is_pulled_down_and_one_that_is_missing_is_recommended() -> None:
    settings = {"forward": 17, "backward": 27, "model": MODEL}
    assert "10 kΩ from GPIO 22 (standby) to ground" in notes(HBridge(), **settings, standby=22)
    without = notes(HBridge(), **settings)
    assert "10 kΩ" not in without
    assert "There is no standby line" in without
    assert "an L298N's ENA and ENB joined" in without


def test_the_inputs_of_the_usual_boards_are_named_by_their_names() -> None:
    text = notes(HBridge(), forward=17, backward=27, model=MODEL)
    for inputs in ("TB6612: forward AIN1", "PWMB to 3.3 V", "standby nSLEEP", "L298N: forward IN1 and IN3"):
        assert inputs in text
    assert "AIN1" not in notes(PhaseEnable(), phase=17, enable=27, model=MODEL)


@pytest.mark.parametrize("driver, lines", [(Quadrature(), {"a": 5, "b": 6}), (Pulses(), {"gpio": 5})])
def test_encoders_are_fed_with_the_voltage_of_the_pins(driver: DeviceDriver[Any, Any], lines: dict[str, int]) -> None:
    assert driver.supply == ("3.3 V", "ground")
    assert "divider" in notes(driver, **lines)


@pytest.mark.parametrize("driver", [HBridge(), PhaseEnable(), Ultrasonic(), Quadrature(), Pulses()])
def test_what_feeds_a_device_is_on_the_header(driver: DeviceDriver[Any, Any]) -> None:
    assert all(pads_of(name) for name in driver.supply)
