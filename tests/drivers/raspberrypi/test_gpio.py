from __future__ import annotations

import pytest
from pydantic import ValidationError

from drivers.raspberrypi.gpio import Gpio
from robotcore.description import StrictModel


class Settings(StrictModel):
    echo: Gpio


@pytest.mark.parametrize("number", [0, 27])
def test_numbers_are_those_of_the_chip(number: int) -> None:
    assert Settings(echo=number).echo == number


@pytest.mark.parametrize(
    "number, told",
    [
        (40, "there is no GPIO 40 on the header; pad 40 of the header is GPIO 21; take 0 to 27"),
        (34, "pad 34 of the header is ground; take"),
        (41, "there is no GPIO 41 on the header; take"),
        (-1, "there is no GPIO -1 on the header; take"),
    ],
)
def test_the_number_of_a_pad_is_told_from_that_of_a_gpio(number: int, told: str) -> None:
    with pytest.raises(ValidationError, match=told):
        Settings(echo=number)
