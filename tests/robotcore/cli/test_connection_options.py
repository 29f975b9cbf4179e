from __future__ import annotations

import pytest

from tests.robotcore.cli.conftest import Cli


@pytest.mark.parametrize("command", [("wiring", "rover"), ("doctor", "--robot", "rover")])
def test_a_robot_is_looked_at_where_it_is_plugged_in(cli: Cli, command: tuple[str, ...]) -> None:
    answer = cli(*command, "--backend", "serial", "--port", "/dev/elsewhere")
    assert "/dev/elsewhere" in answer.out
    assert "/dev/ttyACM0" not in answer.out


def test_a_robot_is_stopped_where_it_is_plugged_in(cli: Cli) -> None:
    answer = cli("stop", "--backend", "serial", "--port", "/dev/elsewhere")
    assert answer.status == 3
    assert "CANNOT STOP left_motor and right_motor: there is no /dev/elsewhere; " in answer.err
