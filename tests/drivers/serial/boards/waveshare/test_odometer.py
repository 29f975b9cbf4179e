from __future__ import annotations

import pytest

from drivers.serial.boards.waveshare.board import Odometer
from drivers.serial.boards.waveshare.protocol import Track


def _metres(*told: tuple[int, float], every: float = 0.05) -> float:
    """Return where it is after the board told centimetres and speeds, so often."""
    odometer = Odometer()
    for nth, (centimetres, speed) in enumerate(told):
        odometer.move(Track(centimetres, speed), nth * every)
    angle = odometer.turning.angle(1.0)
    assert angle
    return angle.angle


def test_within_a_centimetre_it_goes_by_the_speed() -> None:
    assert _metres((0, 0.06), (0, 0.06), (0, 0.06)) == pytest.approx(0.006)


@pytest.mark.parametrize(
    "centimetres, speed, metres",
    [(3, 0.0, 0.03), (-3, 0.0, -0.03), (0, 5.0, 0.01), (0, -5.0, -0.01), (3, 5.0, 0.04), (-3, -5.0, -0.04)],
)
def test_it_never_leaves_the_centimetre_that_the_board_tells(centimetres: int, speed: float, metres: float) -> None:
    assert _metres((0, 0.0), (centimetres, speed)) == pytest.approx(metres)


def test_no_error_adds_up() -> None:
    """The speed is told twice too high, for 10 m."""
    assert _metres(*((n, 0.4) for n in range(1001))) == pytest.approx(10.0, abs=0.01)


def test_a_wheel_that_stands_does_not_creep() -> None:
    assert _metres((0, 0.1), (0, 0.1), (0, 0.0), (0, 0.0), (0, 0.0)) == _metres((0, 0.1), (0, 0.1), (0, 0.0))


def test_after_a_restart_it_goes_on_from_where_it_was() -> None:
    odometer = Odometer()
    for nth, centimetres in enumerate((0, 20, -1, 700, 720)):
        if centimetres in (-1, 700):
            odometer.restart()
        odometer.move(Track(centimetres, 0.0), nth)
    angle = odometer.turning.angle(1.0)
    assert angle
    assert angle.angle == pytest.approx(0.4, abs=0.011)


@pytest.mark.parametrize("centimetres, is_likely", [(15, True), (-15, True), (1000, False), (-1000, False)])
def test_what_no_track_can_do_in_the_time_is_not_likely(centimetres: int, is_likely: bool) -> None:
    odometer = Odometer()
    assert odometer.is_likely(Track(1000, 0.0), 0.0)
    odometer.move(Track(0, 0.0), 0.0)
    assert odometer.is_likely(Track(centimetres, 0.0), 0.05) is is_likely
