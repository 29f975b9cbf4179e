"""`Shared` opens a resource once for all devices, and closes it after them."""

from __future__ import annotations

import pytest

from robotcore.hardware import Shared


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
