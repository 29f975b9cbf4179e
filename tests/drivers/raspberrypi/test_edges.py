from __future__ import annotations

from typing import Any

import pytest

from drivers.raspberrypi.edges import hear_no_more


class Pin:
    """Raises in turn what it is given, for every time that it is told to be silent."""

    def __init__(self, *raised: str) -> None:
        self._raised = list(raised)
        self.is_heard = True

    @property
    def when_changed(self) -> Any:
        raise NotImplementedError

    @when_changed.setter
    def when_changed(self, _: None) -> None:
        if self._raised:
            raise OSError(self._raised.pop(0))
        self.is_heard = False


def test_a_line_that_lgpio_s_own_thread_still_waits_on_is_tried_again() -> None:
    pin = Pin("GPIO busy", "GPIO busy")
    hear_no_more(pin)
    assert not pin.is_heard


def test_a_line_that_stays_busy_is_told_in_the_end() -> None:
    with pytest.raises(OSError, match="GPIO busy"):
        hear_no_more(Pin(*["GPIO busy"] * 200))


def test_any_other_failure_is_told_at_once() -> None:
    pin = Pin("unknown handle")
    with pytest.raises(OSError, match="unknown handle"):
        hear_no_more(pin)
    assert pin.is_heard
