"""``robotcore test-devices``: what it prints, writes and refuses, and how a person answers and stops it."""

from __future__ import annotations

import os
import random
import re
from pathlib import Path

import pytest
import tomlkit

from robotcore.cli.person import TerminalPerson
from robotcore.cli.test_devices import AnsweringPerson
from robotcore.description import read_shipped
from robotcore.errors import EmergencyStopError, UnknownNameError
from tests.robotcore.cli.conftest import Cli
from tests.robotcore.cli.terminal import Terminal, read_end, wait_for
from tests.robotcore.cli.terminal import terminal as terminal  # noqa: PLC0414  a fixture
from tests.robotcore.device_test.miswiring import MISTAKES, build_true_robot, draw_mistakes, find_differences
from tests.texts import CheckText, Raises


def write(folder: Path, text: str, name: str = "own.toml") -> str:
    (folder / name).write_text(text)
    return str(folder / name)


@pytest.mark.slow
@pytest.mark.parametrize("number", range(3))
def test_mistakes_are_found_and_written_until_the_robot_is_as_its_file(number: int, tmp_path: Path, cli: Cli) -> None:
    true = write(tmp_path, tomlkit.dumps(build_true_robot()), "true.toml")
    content, words = draw_mistakes(build_true_robot(), random.Random(f"robot {number}"))
    own = write(tmp_path, tomlkit.dumps(content))
    assert words
    arguments = ("test-devices", "--robot", own, "--backend", "virtualpi", "--option", f"truth={true}")
    assert cli(*arguments).status == 1
    before = Path(own).read_text()
    assert cli(*arguments, "--write").status == 0
    assert Path(own).read_text() != before
    assert find_differences(own, true) == []
    again = cli(*arguments, "--json")
    assert again.status == 0
    assert again.json["diff"] == ""
    assert not again.json["is_written"]


def test_each_mistake_changes_the_file() -> None:
    for word, change in MISTAKES.items():
        robot = build_true_robot()
        change(robot["raspberrypi"], random.Random(0))
        assert robot != build_true_robot(), word


@pytest.mark.slow
def test_the_findings_and_the_diff_are_shown_and_nothing_is_written(
    tmp_path: Path, cli: Cli, check_text: CheckText
) -> None:
    shipped = read_shipped("rover")
    text = shipped.replace("forward = 17\nbackward = 27", "forward = 27\nbackward = 17")
    own, true = write(tmp_path, text), write(tmp_path, shipped, "true.toml")
    answer = cli("test-devices", "--robot", own, "--backend", "virtualpi", "--option", f"truth={true}")
    assert answer.status == 1
    check_text(answer.out)
    assert Path(own).read_text() == text


@pytest.mark.slow
def test_answers_on_the_command_line_replace_those_of_the_truth(cli: Cli) -> None:
    arguments = ["test-devices", "--robot", "rover", "--backend", "virtualpi", "--only", "left_motor", "--json"]
    answer = cli(*arguments, "--answer", "left_motor.wheel=lb")
    assert answer.status == 1
    assert [finding["kind"] for finding in answer.json["findings"]] == ["motor-reversed", "encoder-reversed"]


def test_an_unknown_answer_is_refused_with_the_meanings_of_the_answers(cli: Cli, check_text: CheckText) -> None:
    arguments = ["test-devices", "--robot", "rover", "--backend", "virtualpi", "--only", "left_motor", "--json"]
    answer = cli(*arguments, "--answer", "left_motor.wheel=left")
    assert (answer.status, answer.json["kind"]) == (2, "unknown-answer-to-left_motor.wheel")
    check_text(answer.err)


@pytest.mark.slow
def test_a_motor_that_is_swapped_and_turns_backward_is_named_as_after_the_swap(tmp_path: Path, cli: Cli) -> None:
    shipped = read_shipped("rover")
    left, right = "forward = 17\nbackward = 27", "forward = 23\nbackward = 24"
    text = shipped.replace(right, "forward = 27\nbackward = 17").replace(left, right)
    own, true = write(tmp_path, text), write(tmp_path, shipped, "true.toml")
    truth = f"truth={true}"
    only = ["--only", "left_motor", "--only", "right_motor"]
    answer = cli("test-devices", "--robot", own, "--backend", "virtualpi", "--option", truth, *only)
    assert re.search(r"^error +left_motor +turns its wheel backward, after the swap$", answer.out, re.MULTILINE)


@pytest.mark.slow
def test_devices_that_do_not_open_are_reported_and_the_others_are_tested(tmp_path: Path, cli: Cli) -> None:
    shipped = read_shipped("rover")
    true = write(tmp_path, shipped.replace("[raspberrypi.nose]", "[vrep.other]"), "true.toml")
    own = write(tmp_path, shipped)
    answer = cli("test-devices", "--robot", own, "--backend", "virtualpi", "--option", f"truth={true}", "--json")
    kinds = {finding["subject"]: finding["kind"] for finding in answer.json["findings"]}
    assert answer.status == 1
    assert kinds["nose"] != "works"
    assert kinds["left_motor"] == kinds["eye"] == "works"


@pytest.mark.parametrize(
    "arguments",
    [
        ["--robot", "rover", "--backend", "virtualpi", "--write"],
        ["--robot", "rover", "--backend", "virtualpi", "--only", "lef_motor"],
        ["--robot", "rover", "--backend", "virtualpi", "--answer", "lef_motor.wheel=lf"],
        ["--robot", "rover", "--backend", "virtualpi", "--answer", "left_motor=lf"],
        ["--robot", "rover", "--backend", "raspberrypi"],
        ["--robot", "missing.toml", "--backend", "virtualpi"],
    ],
)
def test_wrong_arguments_are_refused_before_a_device_is_opened(
    arguments: list[str], cli: Cli, check_text: CheckText, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", None)
    answer = cli("test-devices", *arguments)
    assert answer.status == 2
    check_text(answer.err)


def start(terminal: Terminal, *more: str) -> None:
    arguments = ["--robot", "rover", "--backend", "virtualpi", "--only", "left_motor", *more]
    terminal.run(*arguments, command="test-devices")
    wait_for(lambda: b"Which wheel turned" in terminal.output)


@pytest.mark.slow
def test_a_person_answers_at_the_terminal(terminal: Terminal) -> None:
    start(terminal)
    terminal.type(b"what\n")
    wait_for(lambda: b"is no answer" in terminal.output)
    terminal.type(b"lb\n")
    answer, ended = read_end(terminal)
    assert [finding["kind"] for finding in answer["findings"]] == ["motor-reversed", "encoder-reversed"]
    assert ended == "exited 1"
    assert terminal.is_restored


@pytest.mark.parametrize(
    "answers, is_ready", [(["zzz", "S"], False), (["ready", ""], True), (["s"], False), ([None], False)], ids=str
)
def test_only_enter_confirms_an_instruction(
    answers: list[str | None],
    is_ready: bool,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    left = iter(answers)
    monkeypatch.setattr(TerminalPerson, "read_line", lambda *_: next(left))
    assert AnsweringPerson(TerminalPerson(), {}).follow("nose", "wall", "Put the robot before a wall") is is_ready
    assert capsys.readouterr().err.count("is no answer") == len(answers) - 1
    assert next(left, "no more") == "no more"


def test_an_answer_in_advance_confirms_or_skips_an_instruction(raises: Raises) -> None:
    person = AnsweringPerson(TerminalPerson(), {"nose.wall": "ready", "nose.far": "skip", "nose.near": "zzz"})
    assert [person.follow("nose", topic, "Put the robot there") for topic in ("wall", "far")] == [True, False]
    with raises(UnknownNameError, "unknown-answer-to-nose.near", name="zzz"):
        person.follow("nose", "near", "Put the robot there")


@pytest.mark.slow
@pytest.mark.parametrize("key,kind,status", [(b" ", "emergency-stop", 4), (b"\x03", "interrupted", 130)])
def test_the_space_bar_and_ctrl_c_end_a_question(key: bytes, kind: str, status: int, terminal: Terminal) -> None:
    start(terminal)
    terminal.type(key)
    answer, ended = read_end(terminal)
    assert answer["kind"] == kind
    assert answer["exit_status"] == status
    assert ended == f"exited {status if status == 4 else -2}"
    assert terminal.is_restored


@pytest.mark.slow
def test_findings_before_an_error_are_shown_and_their_changes_are_not_written(
    tmp_path: Path, cli: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    def press(*_arguments: object) -> None:
        raise EmergencyStopError("the space bar was pressed in the terminal")

    monkeypatch.setattr("robotcore.kinds.device_tests.wheels._report_encoders", press)
    shipped = read_shipped("rover")
    text = shipped.replace("forward = 17\nbackward = 27", "forward = 27\nbackward = 17")
    own, true = write(tmp_path, text), write(tmp_path, shipped, "true.toml")
    arguments = ("test-devices", "--robot", own, "--backend", "virtualpi", "--option", f"truth={true}", "--write")
    answer = cli(*arguments)
    assert answer.status == 4
    assert f"{own} stays as it is: the test did not reach its end." in answer.out
    assert Path(own).read_text() == text
    in_json = cli(*arguments, "--json").json
    assert (in_json["kind"], in_json["is_written"]) == ("emergency-stop", False)
    assert "motor-reversed" in [finding["kind"] for finding in in_json["findings"]]
    assert "+forward = 17" in in_json["diff"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everything")
def test_a_read_only_file_is_refused(tmp_path: Path, cli: Cli) -> None:
    own = write(tmp_path, read_shipped("rover"))
    Path(own).chmod(0o444)
    assert cli("test-devices", "--robot", own, "--backend", "virtualpi", "--write").status == 2
