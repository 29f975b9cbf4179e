from __future__ import annotations

import pytest

from tests.robotcore.cli.conftest import Cli


@pytest.mark.parametrize("command", [("wiring", "rover"), ("doctor", "--robot", "rover")])
def test_a_robot_is_looked_at_where_it_is_plugged_in(cli: Cli, command: tuple[str, ...]) -> None:
    told = cli(*command, "--backend", "serial", "--port", "/dev/elsewhere")
    assert "/dev/elsewhere" in told.out
    assert "/dev/ttyACM0" not in told.out


def test_a_robot_is_stopped_where_it_is_plugged_in(cli: Cli) -> None:
    told = cli("stop", "--backend", "serial", "--port", "/dev/elsewhere")
    assert told.status == 3
    assert "CANNOT STOP left_motor and right_motor: there is no /dev/elsewhere; " in told.err
