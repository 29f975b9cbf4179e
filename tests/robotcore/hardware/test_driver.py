"""`Shared` opens a resource once for all devices, and closes it after them."""

from __future__ import annotations

import pytest

from robotcore.hardware import Shared
from robotcore.hardware.binding import _suggest_driver
from tests.doubles.foreign_kinds import GripperDescription
from tests.texts import CheckText


class Port:
    def __init__(self, closed: list[Port]) -> None:
        self._closed = closed

    def close(self) -> None:
        self._closed.append(self)


class Board(Port):
    """A resource of another class, which may have the same path."""


def test_each_resource_is_opened_once_and_closed_in_reverse_order_even_if_one_fails() -> None:
    class Stuck(Port):
        def close(self) -> None:
            raise TimeoutError

    closed: list[Port] = []
    shared = Shared()
    usb0, again, usb1 = (shared.take(Port, path, lambda: Port(closed)) for path in ("usb0", "usb0", "usb1"))
    shared.take(Stuck, "usb2", lambda: Stuck(closed))
    board = shared.take(Board, "usb0", lambda: Board(closed))
    assert usb0 is again
    with pytest.raises(TimeoutError):
        shared.close()
    shared.close()
    assert closed == [board, usb1, usb0]


def test_a_resource_that_could_not_be_opened_is_opened_by_the_next_take() -> None:
    def refuse() -> Port:
        raise FileNotFoundError

    shared = Shared()
    with pytest.raises(FileNotFoundError):
        shared.take(Port, "usb0", refuse)
    assert shared.take(Port, "usb0", lambda: Port([]))


def test_driver_of_a_kind_without_drivers_may_be_in_a_package_to_install_again(check_text: CheckText) -> None:
    check_text(_suggest_driver("jaws", (), GripperDescription(name="hand")))
