from __future__ import annotations

import pytest

from tests.robotcore.cli.conftest import Cli


@pytest.mark.parametrize("command", [("wiring", "rover"), ("doctor", "--robot", "rover")])
def test_the_option_port_replaces_the_port_in_the_robots_file(cli: Cli, command: tuple[str, ...]) -> None:
    answer = cli(*command, "--backend", "serial", "--port", "/dev/elsewhere")
    assert "/dev/elsewhere" in answer.out
    assert "/dev/ttyACM0" not in answer.out


def test_a_robot_is_stopped_at_the_given_port(cli: Cli) -> None:
    answer = cli("stop", "--backend", "serial", "--port", "/dev/elsewhere")
    assert answer.status == 3
    assert "/dev/elsewhere" in answer.err
