"""The boards that the firmware is for: one processor, three ways to get a program into it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Board:
    """A board as the Arduino tools know it.

    ``fqbn`` names it to arduino-cli, ``variant`` its pins in the Arduino core; its bootloader takes ``flash_bytes``
    at ``upload_baud``. The figures are those of the Arduino core's boards.txt.
    """

    name: str
    fqbn: str
    variant: str
    macro: str
    upload_baud: int
    flash_bytes: int


BOARDS = {
    board.name: board
    for board in (
        Board("uno", "arduino:avr:uno", "standard", "ARDUINO_AVR_UNO", 115200, 32256),
        Board("nano", "arduino:avr:nano", "eightanaloginputs", "ARDUINO_AVR_NANO", 115200, 30720),
        Board("nano-old", "arduino:avr:nano:cpu=atmega328old", "eightanaloginputs", "ARDUINO_AVR_NANO", 57600, 30720),
    )
}
