"""A person drives by the keys of a real terminal, and every way out stops the robot and restores the terminal."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from robotcore.cli.main import execute
from robotcore.errors import UnmetNeedError
from robotcore.recording import Recording, read
from robotcore.recording.replay import replay
from robotcore.safety.velocity_limits import STOPPED
from tests.robotcore.cli.terminal import Terminal, read_end, wait_for
from tests.robotcore.cli.terminal import terminal as terminal  # noqa: PLC0414  a fixture
from tests.robotcore.description.files import ROVER
from tests.texts import CheckText

OPEN = ("--world", "open")


def drive(terminal: Terminal, file: Path, *words: str, command: str = "teleop") -> None:
    """Start a run, and hold the key W until the robot moves."""
    terminal.run(*words, "--keys", "--record", str(file), command=command)
    wait_for(lambda: b"speed 50%" in terminal.output)
    for _ in range(20):
        terminal.type(b"w")
    wait_for(lambda: b"driving" in terminal.output)


def list_driven(recording: Recording) -> list[float]:
    """Return the times at which the person drove forward."""
    operator = [sample for key, sample in recording.samples.items() if key.device == "operator"]
    values: list[Any] = operator
    return [each.time for each in values if each.linear > 0]


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["kinematic", "virtualpi"])
def test_a_person_drives_by_keys_and_the_run_replays_equal(terminal: Terminal, tmp_path: Path, backend: str) -> None:
    file = tmp_path / "run.mcap"
    drive(terminal, file, *OPEN, "--backend", backend)
    terminal.type(b"\x03")
    answer, exited = read_end(terminal)
    assert (answer["app"], answer["outcome"], exited) == ("teleop", "interrupted", "exited -2")
    assert terminal.is_restored
    assert list_driven(read(file))
    found = replay(read(file), file)
    assert found.is_equal
    assert found.is_exact


@pytest.mark.slow
def test_the_space_bar_is_the_emergency_stop_while_a_person_drives(terminal: Terminal, tmp_path: Path) -> None:
    file = tmp_path / "run.mcap"
    drive(terminal, file, *OPEN)
    terminal.type(b"w w")
    answer, exited = read_end(terminal)
    assert (answer["kind"], exited) == ("emergency-stop", "exited 4")
    assert terminal.is_restored
    assert replay(read(file), file).is_equal


@pytest.mark.slow
def test_a_person_interrupts_an_app_and_returns_the_robot_to_it(terminal: Terminal, tmp_path: Path) -> None:
    file = tmp_path / "run.mcap"
    words = ("green-search", "--seed", "7", "--timeout", "8")
    drive(terminal, file, *words, command="run")
    terminal.type(b"r")
    answer, _ = read_end(terminal)
    assert answer["app"] == "green-search"
    recording = read(file)
    driven = list_driven(recording)
    assert driven
    assert recording.ticks[-1].time > driven[-1] + 1.0
    assert recording.ticks[-1].asked
    assert replay(recording, file).is_equal


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["kinematic", "virtualpi"])
def test_a_suspended_run_stands_when_it_continues(terminal: Terminal, tmp_path: Path, backend: str) -> None:
    file = tmp_path / "run.mcap"
    drive(terminal, file, *OPEN, "--backend", backend)
    terminal.type(b"\x1a")
    assert terminal.read_line() == "stopped"
    assert terminal.is_restored
    terminal.resume()
    wait_for(lambda: terminal.is_raw)
    terminal.output = b""
    wait_for(lambda: terminal.output.count(b"driving") > 3)
    terminal.type(b"\x03")
    read_end(terminal)
    last = [tick for tick in read(file).ticks if tick.sent][-3:]
    assert {tick.sent for tick in last} == {STOPPED}
    assert terminal.is_restored


@pytest.mark.slow
def test_a_closed_terminal_ends_the_run(terminal: Terminal, tmp_path: Path) -> None:
    file = tmp_path / "run.mcap"
    drive(terminal, file, *OPEN)
    terminal.hang_up()
    wait_for(lambda: (result := read(file).result) is not None and result.reason == "interrupted by SIGHUP")


@pytest.mark.parametrize(
    "words, kind",
    [
        (["teleop"], "no-way-to-drive"),
        (["teleop", "--keys"], "keys-without-terminal"),
        (["run", "green-search", "--keys"], "keys-without-terminal"),
        (["run", "green-search", "--keys", "--no-estop-key"], "keys-without-estop"),
    ],
)
def test_a_way_to_drive_that_cannot_work_is_refused(
    words: list[str], kind: str, capsys: pytest.CaptureFixture[str], check_text: CheckText
) -> None:
    assert execute([*words, "--json"]) == 2
    answer = json.loads(capsys.readouterr().out)
    assert answer["kind"] == kind
    assert answer["app"] == (words[1] if words[0] == "run" else "teleop")
    check_text(answer["error"])


@pytest.mark.slow
def test_keys_need_a_drive(terminal: Terminal) -> None:
    terminal.run("--keys", "--robot", "lookout", command="teleop")
    answer, exited = read_end(terminal)
    assert (answer["kind"], exited) == (UnmetNeedError.kind, "exited 2")
    assert terminal.is_restored


@pytest.mark.slow
def test_the_gamepad_of_the_robot_drives(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    robot = tmp_path / "driven.toml"
    robot.write_text(f'{ROVER}\n[[devices]]\nkind = "gamepad"\nname = "pad"\nscript = [{{ at_s = 0.2, left_y = 1.0 }}]')
    file = tmp_path / "run.mcap"
    execute(["teleop", "--robot", str(robot), *OPEN, "--timeout", "0.6", "--record", str(file), "--json"])
    capsys.readouterr()
    recording = read(file)
    assert {tick.state for tick in recording.ticks if tick.time > 0.2} == {"drive"}
    assert replay(recording, file).is_equal
