"""``robotcore run --view`` and ``robotcore.open(view=True)``."""

from __future__ import annotations

import re
import socket
import subprocess
import sys
import urllib.request
from contextlib import suppress
from pathlib import Path

import pytest

import robotcore
from robotcore.errors import UsageError
from tests.robotcore.cli.conftest import Cli
from tests.robotcore.cli.conftest import cli as cli  # noqa: PLC0414  a fixture
from tests.robotcore.live.test_driving import wait_for
from tests.texts import Raises

pytestmark = pytest.mark.slow

SHORT = ("run", "avoid-obstacles", "--world", "open", "--set", "duration_s=0.5")


def test_view_prints_the_link_on_stderr_and_runs_in_real_time(cli: Cli) -> None:
    answer = cli(*SHORT, "--json", "--view")
    assert re.fullmatch(r"The live page: http://127\.0\.0\.1:\d+/\n", answer.err)
    assert (answer.status, answer.json["outcome"]) == (0, "success")
    assert answer.json["wall_time_s"] > 0.45


def test_view_before_the_app_is_wrong_usage(cli: Cli) -> None:
    answer = cli("run", "--view", "my_app.py", "avoid-obstacles")
    assert answer.status == 2
    assert "write --view after it" in answer.err


def test_an_open_robot_has_a_page_until_it_is_closed(capsys: pytest.CaptureFixture[str]) -> None:
    with robotcore.open("rover", world="open", view=True) as robot:
        link = capsys.readouterr().out.removeprefix("The live page: ").strip()
        robot.drive.move(0.1, seconds=0.2)
        with urllib.request.urlopen(link, timeout=10) as answer:  # noqa: S310  the page of this test
            assert b"robotcore" in answer.read()
    with pytest.raises(OSError, match="refused"):
        urllib.request.urlopen(link, timeout=10)  # noqa: S310


def test_no_file_beside_a_script_replaces_a_package_of_the_page(tmp_path: Path) -> None:
    (tmp_path / "uvicorn.py").write_text("import os\nos.abort()\n")
    script = tmp_path / "script.py"
    script.write_text(
        "import robotcore, urllib.request\n"
        "with robotcore.open('rover', world='open', view='127.0.0.1:0') as robot:\n"
        "    link = input()\n"
        "    print(urllib.request.urlopen(link, timeout=10).status)\n"
    )
    with subprocess.Popen(
        [sys.executable, script], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin
        assert process.stdout
        link = process.stdout.readline().removeprefix("The live page: ")
        assert process.communicate(link)[0] == "200\n"


def test_the_address_of_an_open_robot_is_checked(raises: Raises) -> None:
    with raises(UsageError, "not-an-address", address="my_app.py"):
        robotcore.open("rover", view="my_app.py")


def test_a_page_that_cannot_listen_leaves_no_port_of_foxglove() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken, socket.create_server(("127.0.0.1", 0)) as other:
        page, port = taken.getsockname()[1], other.getsockname()[1]
        other.close()
        with pytest.raises(UsageError):
            robotcore.open("rover", view=f"127.0.0.1:{page}", foxglove=port)
        wait_for(lambda: is_free(port))  # the server ends in the background


def is_free(port: int) -> bool:
    with suppress(OSError), socket.create_server(("127.0.0.1", port)):
        return True
    return False


def test_a_robot_that_cannot_be_opened_leaves_no_page(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(robotcore.errors.RobotcoreError):
        robotcore.open("rover", backend="coppeliasim", options={"port": "1"}, view=True)
