"""Sessions of `robotcore.open` on the tests' simulated lines."""

from __future__ import annotations

import pytest

import robotcore
from robotcore.errors import DeviceGroupError
from tests.drivers.raspberrypi.lines import FOLDER, ROOT, Lines
from tests.texts import Raises

PLAIN = str(ROOT / "tests" / "system" / "guest" / "robots" / "plain.toml")
FORWARD = (17, 23)


@pytest.mark.slow
def test_second_session_on_the_same_pins_is_refused_and_the_first_drives_on(
    fake_lgpio: Lines, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.syspath_prepend(FOLDER)  # the guardians import the double too
    with robotcore.open(PLAIN, "raspberrypi") as first:
        with raises(DeviceGroupError, "device-group") as refused:
            robotcore.open(PLAIN, "raspberrypi")
        failures = refused.value.failures
        assert [(each.kind, each.fields["gpios"]) for each in failures] == [  # type: ignore[attr-defined]
            ("gpio-in-use", (gpio,)) for gpio in FORWARD
        ]
        levels: list[int] = []
        first.run(drive(first, fake_lgpio, levels))
        assert max(levels) > 0
    assert [fake_lgpio.level(gpio) for gpio in FORWARD] == [0, 0]
    with robotcore.open(PLAIN, "raspberrypi") as third:
        third.wait(0.1)


def drive(robot: robotcore.LiveRobot, lines: Lines, levels: list[int]) -> robotcore.Routine[None]:
    for _ in range(4):
        robot.drive.set_velocity(0.2, 0.0)
        yield
        levels.append(lines.level(FORWARD[0]))
