"""What several devices have in common is opened once, and closed when they are."""

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
    """Something else, perhaps at the same place."""


def test_the_first_that_asks_opens_it_and_the_others_get_the_same() -> None:
    shared = Shared()
    ports = [shared.take(Port, "usb0", lambda: Port("usb0")) for _ in range(3)]
    assert ports[0] is ports[1] is ports[2]
    assert DIARY == ["open usb0"]


def test_another_place_and_another_kind_are_something_else() -> None:
    shared = Shared()
    usb0, usb1 = (shared.take(Port, path, lambda path=path: Port(path)) for path in ("usb0", "usb1"))  # type: ignore[misc]
    board = shared.take(Board, "usb0", lambda: Board("usb0"))
    assert len({id(usb0), id(usb1), id(board)}) == 3


def test_what_fails_in_opening_is_tried_again_by_the_next() -> None:
    def refuse() -> Port:
        raise OSError("no such port")

    shared = Shared()
    with pytest.raises(OSError, match="no such port"):
        shared.take(Port, "usb0", refuse)
    assert shared.take(Port, "usb0", lambda: Port("usb0")).path == "usb0"


def test_closing_closes_the_last_one_first_each_once_and_even_where_one_fails() -> None:
    class Stuck(Port):
        def close(self) -> None:
            raise OSError("stuck")

    shared = Shared()
    shared.take(Port, "usb0", lambda: Port("usb0"))
    shared.take(Stuck, "usb1", lambda: Stuck("usb1"))
    shared.take(Port, "usb2", lambda: Port("usb2"))
    with pytest.raises(OSError, match="stuck"):
        shared.close()
    shared.close()
    assert DIARY[3:] == ["close usb2", "close usb0"]
