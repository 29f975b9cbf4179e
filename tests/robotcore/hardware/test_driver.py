"""`Shared` opens a resource once for all devices, and closes it after them."""

from __future__ import annotations

import pytest

from robotcore.hardware import Shared

DIARY: list[str] = []


@pytest.fixture(autouse=True)
def _begun_anew() -> None:
    DIARY.clear()


class Port:
    def __init__(self, path: str) -> None:
        DIARY.append(f"open {path}")
        self.path = path

    def close(self) -> None:
        DIARY.append(f"close {self.path}")


class Board(Port):
    """A resource of another class, which may have the same path."""


def test_the_first_take_opens_a_resource_and_the_others_return_it() -> None:
    shared = Shared()
    ports = [shared.take(Port, "usb0", lambda: Port("usb0")) for _ in range(3)]
    assert ports[0] is ports[1] is ports[2]
    assert DIARY == ["open usb0"]


def test_another_place_or_another_kind_is_another_resource() -> None:
    shared = Shared()
    usb0, usb1 = (shared.take(Port, path, lambda path=path: Port(path)) for path in ("usb0", "usb1"))  # type: ignore[misc]
    board = shared.take(Board, "usb0", lambda: Board("usb0"))
    assert len({id(usb0), id(usb1), id(board)}) == 3


def test_a_resource_that_could_not_be_opened_is_opened_by_the_next_take() -> None:
    def refuse() -> Port:
        raise FileNotFoundError

    shared = Shared()
    with pytest.raises(FileNotFoundError):
        shared.take(Port, "usb0", refuse)
    assert shared.take(Port, "usb0", lambda: Port("usb0")).path == "usb0"


def test_resources_are_closed_once_in_reverse_order_even_if_one_fails() -> None:
    class Stuck(Port):
        def close(self) -> None:
            raise TimeoutError

    shared = Shared()
    shared.take(Port, "usb0", lambda: Port("usb0"))
    shared.take(Stuck, "usb1", lambda: Stuck("usb1"))
    shared.take(Port, "usb2", lambda: Port("usb2"))
    with pytest.raises(TimeoutError):
        shared.close()
    shared.close()
    assert DIARY[3:] == ["close usb2", "close usb0"]
