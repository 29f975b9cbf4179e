"""``robotcore calibrate camera`` and ``robotcore calibrate range``: what they print, write and refuse."""

from __future__ import annotations

import random
import re
import signal
from collections.abc import Callable, Iterator
from importlib import import_module
from itertools import count
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import tomlkit

from robotcore.calibration.camera.board import Board
from robotcore.description import load_robot, read_shipped
from robotcore.errors import DeviceError, EmergencyStopError
from tests.robotcore.calibration.camera.rendered_boards import build_camera
from tests.robotcore.cli.conftest import Cli
from tests.texts import CheckText

CAMERA = build_camera((320, 240), 290.0, (164.0, 117.0), (-0.2, 0.03, 0.001, -0.001, 0.0), noise=3.0)
SIMULATED = ("--backend", "kinematic")


def write(folder: Path, *changes: tuple[str, str], name: str = "own.toml") -> str:
    text = read_shipped("rover")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (folder / name).write_text(text)
    return str(folder / name)


FOV = "horizontal_fov_rad = 1.0821"
LENS = (
    "horizontal_fov_rad = 0.98\ncentre_px = [166.0, 115.0]\ndistortion = [-0.22, 0.03, 0.0, 0.0, 0.0]\n"
    "noise_levels = 2.0"
)
CONE = "cone_rad = 0.5236  # 30 degrees\n"


@pytest.mark.slow
def test_a_simulated_camera_gets_its_true_noise_and_delay(tmp_path: Path, cli: Cli) -> None:
    own = write(tmp_path)
    true = write(tmp_path, (FOV, f"latency_s = 0.13\nnoise_levels = 3.0\n{FOV}"), name="true.toml")
    arguments = ["calibrate", "camera", "--robot", own, "--backend", "virtualpi", "--option", f"truth={true}"]
    answer = cli(*arguments, "--write", "--json", "--plot", str(tmp_path / "plot.png"))
    assert answer.status == 0
    parts = answer.json["parts"]
    assert parts["delay"]["latency_s"] == pytest.approx(0.13, abs=0.01)
    assert parts["noise"]["noise_levels"] == pytest.approx(3.0, abs=0.1)
    assert parts["colour"]["hue"] == pytest.approx(129, abs=3)
    assert answer.json["skipped"] == {}
    assert load_robot(own).first_of("camera").latency_s == parts["delay"]["latency_s"]
    assert (tmp_path / "plot.png").is_file()


def test_a_missing_folder_of_pictures_is_named(tmp_path: Path, cli: Cli) -> None:
    folder = tmp_path / "missing"
    arguments = ("calibrate", "camera", "--robot", "rover", *SIMULATED, "--pictures", str(folder), "--json")
    answer = cli(*arguments)
    assert (answer.status, answer.json["kind"]) == (2, "no-folder")
    assert str(folder) in answer.json["error"]


@pytest.mark.slow
def test_pictures_of_a_board_give_the_intrinsics(tmp_path: Path, cli: Cli) -> None:
    (folder := tmp_path / "pictures").mkdir()
    for number, picture in enumerate(CAMERA.render_views(Board(9, 6), 18, random.Random(1))):
        cv2.imwrite(str(folder / f"{number:02}.png"), picture)
    own = write(tmp_path)
    answer = cli("calibrate", "camera", "--robot", own, *SIMULATED, "--pictures", str(folder), "--write")
    assert answer.status == 0
    intrinsics = load_robot(own).first_of("camera").intrinsics
    assert intrinsics.focal_length == pytest.approx(CAMERA.intrinsics.focal_length, rel=0.003)
    assert intrinsics.distortion[0] == pytest.approx(-0.2, abs=0.02)
    assert "+centre_px" in answer.out


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["kinematic", "virtualpi"])
def test_a_simulated_camera_gets_its_true_lens(backend: str, tmp_path: Path, cli: Cli) -> None:
    true = write(tmp_path, (FOV, LENS), name="true.toml")
    own = write(tmp_path) if backend == "virtualpi" else true
    options = ["--option", f"truth={true}"] if backend == "virtualpi" else []
    answer = cli(
        "calibrate", "camera", "--only", "intrinsics", "--robot", own, "--backend", backend, *options, "--write"
    )
    assert answer.status == 0
    assert "the board is rendered" in answer.err
    found, expected = (load_robot(file).first_of("camera").intrinsics for file in (own, true))
    assert found.focal_length == pytest.approx(expected.focal_length, rel=0.01)
    assert (found.cx, found.cy) == pytest.approx((expected.cx, expected.cy), abs=1.0)
    edge = np.array([[10.0, 10.0], [310.0, 120.0], [160.0, 230.0]])
    assert found.undistort(edge) == pytest.approx(expected.undistort(edge), abs=0.01 * 160)


def test_pictures_without_a_board_are_a_failure_and_the_file_stays(
    tmp_path: Path, cli: Cli, check_text: CheckText
) -> None:
    (folder := tmp_path / "pictures").mkdir()
    cv2.imwrite(str(folder / "1.png"), np.full((60, 80), 128, np.uint8))
    own = write(tmp_path)
    before = Path(own).read_text()
    answer = cli("calibrate", "camera", "--robot", own, *SIMULATED, "--pictures", str(folder), "--write")
    assert answer.status == 1
    assert Path(own).read_text() == before
    check_text(answer.err)


Routine = Callable[..., Iterator[None]]


def interrupt(monkeypatch: pytest.MonkeyPatch, routine: str, number: int, end: Callable[[], object]) -> None:
    """Let a call of a routine end by a function that raises an error or sends a signal.

    number: the number of the call, from 1 on.
    """
    module, _, name = routine.rpartition(".")
    run: Routine = getattr(import_module(module), name)
    calls = count(1)

    def run_or_end(*arguments: Any) -> Iterator[None]:
        if next(calls) == number:
            yield
            end()
        return (yield from run(*arguments))

    monkeypatch.setattr(routine, run_or_end)


def press() -> None:
    raise EmergencyStopError("the space bar was pressed in the terminal")


def lose() -> None:
    raise DeviceError("eye", "gives no picture", kind="no-picture")


def send_signal() -> None:
    signal.raise_signal(signal.SIGINT)


ENDS = pytest.mark.parametrize(
    "end, status, kind",
    [
        (press, 4, "emergency-stop"),
        (lose, 3, "no-picture"),
        (send_signal, 130, "interrupted"),
    ],
    ids=["e-stop", "device", "Ctrl-C"],
)


@ENDS
def test_parts_that_were_measured_before_an_interruption_are_shown_and_written(
    end: Callable[[], object], status: int, kind: str, tmp_path: Path, cli: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    interrupt(monkeypatch, "robotcore.calibration.camera.measuring.take_pictures", 3, end)  # the first one is a check
    own = write(tmp_path, (FOV, f"noise_levels = 9.0\n{FOV}"))
    arguments = ["calibrate", "camera", "--robot", own, *SIMULATED, "--only", "noise", "--only", "colour", "--write"]
    answer = cli(*arguments)
    assert answer.status == status
    assert "grey levels" in answer.out
    assert f"{own} has been corrected." in answer.out
    assert load_robot(own).first_of("camera").noise_levels == pytest.approx(9.0, abs=0.5)
    assert load_robot(own).first_of("camera").noise_levels != 9.0


@ENDS
def test_the_answer_in_json_has_the_parts_and_the_error(
    end: Callable[[], object], status: int, kind: str, tmp_path: Path, cli: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    interrupt(monkeypatch, "robotcore.calibration.camera.measuring.take_pictures", 3, end)
    own = write(tmp_path, (FOV, f"noise_levels = 9.0\n{FOV}"))
    arguments = ["calibrate", "camera", "--robot", own, *SIMULATED, "--only", "noise", "--only", "colour", "--json"]
    answer = cli(*arguments)
    assert answer.status == status
    assert (answer.json["kind"], answer.json["exit_status"], answer.json["is_written"]) == (kind, status, False)
    assert list(answer.json["parts"]) == ["noise"]
    assert "+noise_levels" in answer.json["diff"]


@pytest.mark.slow
@ENDS
def test_distances_before_an_interruption_are_shown_and_not_written(
    end: Callable[[], object], status: int, kind: str, tmp_path: Path, cli: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    interrupt(monkeypatch, "robotcore.calibration.range_sensor.collect_samples", 4, end)
    own = write(tmp_path, (CONE, f"{CONE}noise_m = 0.006\n"))
    before = Path(own).read_text()
    answer = cli("calibrate", "range", "--robot", own, *SIMULATED, "--seconds", "0.5", "--write")
    assert answer.status == status
    assert "+offset_m" in answer.out or "nose: offset" in answer.out
    assert f"{own} stays as it is: the measurement did not reach its end." in answer.out
    assert Path(own).read_text() == before


def test_a_file_that_cannot_be_written_does_not_replace_the_error_of_an_interruption(
    tmp_path: Path, cli: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = write(tmp_path, (FOV, f"noise_levels = 9.0\n{FOV}"))

    def change_file() -> None:
        write(tmp_path, ("# On a Raspberry Pi", "# On my Raspberry Pi"))
        press()

    interrupt(monkeypatch, "robotcore.calibration.camera.measuring.take_pictures", 3, change_file)
    answer = cli("calibrate", "camera", "--robot", own, *SIMULATED, "--only", "noise", "--only", "colour", "--write")
    assert answer.status == 4
    assert "another program has changed the file" in answer.err
    assert "e-stop" in answer.err.splitlines()[-1]
    assert f"{own} stays as it is: it could not be written." in answer.out


def test_an_interruption_without_a_result_is_only_an_error(
    tmp_path: Path, cli: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    interrupt(monkeypatch, "robotcore.calibration.range_sensor.collect_samples", 2, press)
    answer = cli("calibrate", "range", "--robot", write(tmp_path), *SIMULATED, "--seconds", "0.5", "--write")
    assert (answer.status, answer.out) == (4, "")


def test_the_commands_for_a_measured_colour_work(tmp_path: Path, cli: Cli) -> None:
    own = write(tmp_path)
    answer = cli("calibrate", "camera", "--robot", own, *SIMULATED, "--only", "colour")
    (command,) = [line.split() for line in answer.out.splitlines() if line.startswith("    robotcore run")]
    assert cli(*command[1:], "--world", "bench", "--timeout", "0.2", "--json").json["outcome"] == "timeout"
    (settings,) = [line.strip() for line in answer.out.splitlines() if "settings = {" in line]
    assert tomlkit.parse(settings)["settings"].keys() == {"hue", "tolerance"}
    mark = cli("calibrate", "camera", "--robot", "lookout", *SIMULATED, "--only", "colour")
    assert re.search(r"robotcore run mark-green --robot lookout --backend kinematic --set hue=\d+\n", mark.out)


@pytest.mark.parametrize(
    "arguments",
    [
        ["camera", "--robot", "rover", *SIMULATED, "--write"],
        ["camera", "--robot", "rover", "--backend", "vrep", "--only", "intrinsics"],
        ["camera", "--robot", "rover", *SIMULATED, "--camera", "eya"],
        ["camera", "--robot", "rover", *SIMULATED, "--board", "9by6"],
        ["camera", "--robot", "lookout", *SIMULATED, "--only", "delay"],
        ["range", "--robot", "lookout", *SIMULATED],
        ["range", "--robot", "rover", *SIMULATED, "--distances", "0.5,1"],
        ["range", "--robot", "rover", *SIMULATED, "--distances", "0.5,-1"],
        ["range", "--robot", "rover", *SIMULATED, "--distances", "20,50,100"],
        ["range", "--robot", "rover", *SIMULATED, "--distances", "0.2m,0.5m"],
        ["range", "--robot", "rover", *SIMULATED, "--distances", "near"],
        ["range", "--robot", "rover", *SIMULATED, "--drive", "5"],
        ["range", "--robot", "rover", *SIMULATED, "--drive", "160 cm"],
        ["drive", "--robot", "rover", *SIMULATED, "--distance", "2m"],
        ["drive", "--robot", "rover", *SIMULATED, "--distance", "inf"],
        ["motors", "--robot", "rover", *SIMULATED, "--distance", "0.1"],
        ["range", "--robot", "rover", "--backend", "raspberrypi"],
        ["range", "--robot", "rover", *SIMULATED, "--sensor", "nos"],
    ],
)
def test_what_cannot_be_measured_is_refused(
    arguments: list[str], cli: Cli, check_text: CheckText, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", None)
    answer = cli("calibrate", *arguments)
    assert answer.status == 2
    check_text(answer.err)


NOTE = "the measurement compares {own} with itself. To simulate a robot that differs from its file: {option}=FILE"


@pytest.mark.parametrize(
    "backend, option", [("kinematic", "--backend virtualpi --option truth"), ("virtualpi", "--option truth")]
)
@pytest.mark.parametrize(
    "command",
    [["calibrate", "camera", "--only", "noise"], ["test-devices", "--only", "eye"]],
    ids=lambda command: command[0],
)
def test_a_simulator_of_the_same_file_is_noted_once(
    command: list[str], backend: str, option: str, tmp_path: Path, cli: Cli
) -> None:
    own = write(tmp_path)
    answer = cli(*command, "--robot", own, "--backend", backend)
    assert answer.err.count("note: ") == 1
    assert NOTE.format(own=own, option=option) in answer.err


@pytest.mark.slow
@pytest.mark.parametrize(
    "command", [["drive", "--turns", "1"], ["motors"], ["range", "--seconds", "0.5"]], ids=lambda command: command[0]
)
def test_each_calibration_notes_a_simulator_of_the_same_file(command: list[str], tmp_path: Path, cli: Cli) -> None:
    own = write(tmp_path)
    answer = cli("calibrate", *command, "--robot", own, *SIMULATED)
    assert answer.err.count(NOTE.format(own=own, option="--backend virtualpi --option truth")) == 1


def test_a_simulator_of_another_file_is_not_noted(tmp_path: Path, cli: Cli) -> None:
    own, true = write(tmp_path), write(tmp_path, name="true.toml")
    answer = cli(
        "calibrate", "camera", "--only", "noise", "--robot", own, "--backend", "virtualpi", "--option", f"truth={true}"
    )
    assert "note: " not in answer.err


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["kinematic", "virtualpi"])
def test_a_range_sensor_gets_its_true_errors_and_then_agrees(backend: str, tmp_path: Path, cli: Cli) -> None:
    errors = f"{CONE}noise_m = 0.006\nloss = 0.07\n"
    true = write(tmp_path, (CONE, f"{errors}offset_m = 0.021\n"), name="true.toml")
    own = write(tmp_path, (CONE, errors)) if backend == "virtualpi" else true
    options = ["--option", f"truth={true}"] if backend == "virtualpi" else []
    arguments = ["calibrate", "range", "--robot", own, "--backend", backend, *options, "--seconds", "2"]
    answer = cli(*arguments, "--write", "--json", "--plot", str(tmp_path / "plot.png"))
    assert answer.status == 0
    assert answer.json["noise_m"] == pytest.approx(0.006, rel=0.2)
    assert answer.json["loss"] == pytest.approx(0.07, abs=0.03)
    assert load_robot(own).first_of("range_sensor").offset_m == pytest.approx(0.021, abs=0.002)
    assert abs(cli(*arguments, "--json").json["offset_m"]) < 0.002


@pytest.mark.slow
def test_errors_of_zero_are_no_change_of_a_file_without_them(tmp_path: Path, cli: Cli) -> None:
    own = write(tmp_path)
    answer = cli("calibrate", "range", "--robot", own, *SIMULATED, "--seconds", "0.5")
    assert f"{own} agrees with the measurement. There is nothing to correct." in answer.out
    assert re.search(r"noise 0.0000 m ± 0.0000 m, lost echoes 0.0% ± 0.\d%", answer.out)


@pytest.mark.slow
def test_the_errors_of_a_range_sensor_are_shown(cli: Cli) -> None:
    answer = cli("calibrate", "range", "--robot", "rover", *SIMULATED, "--seconds", "0.5")
    assert answer.status == 0
    assert re.search(r"nose: offset [+-]0\.\d+ m", answer.out)


@pytest.mark.slow
def test_the_values_for_a_shipped_robot_are_shown_with_the_commands_that_copy_its_file(cli: Cli) -> None:
    answer = cli("calibrate", "camera", "--robot", "rover", *SIMULATED, "--only", "intrinsics")
    assert "devices.eye: horizontal_fov_rad = 1.08" in answer.out
    assert "robotcore robots rover > my_rover.toml" in answer.out
