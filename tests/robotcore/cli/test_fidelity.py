"""``robotcore fidelity``, on files that ``run --record`` wrote."""

from __future__ import annotations

from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import cv2
import pytest

from robotcore.cli.main import execute
from tests.robotcore.cli.conftest import Cli
from tests.robotcore.fidelity.drives import write_truth
from tests.texts import CheckText


@pytest.fixture(scope="module")
def real(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, str]:
    """Record a run of a robot whose description is wrong. Return the recording and the true description."""
    folder = tmp_path_factory.mktemp("real")
    truth, file = write_truth(folder / "true.toml"), str(folder / "real.mcap")
    robot = ["--backend", "virtualpi", "--option", f"truth={truth}"]
    with redirect_stdout(StringIO()):
        execute(["run", "avoid-obstacles", *robot, "--timeout", "6", "--record", file, "--json"])
    return file, truth


@pytest.mark.slow
def test_a_file_brings_the_simulation_nearer_and_the_picture_is_drawn(
    cli: Cli, real: tuple[str, str], tmp_path: Path
) -> None:
    picture = tmp_path / "fidelity.png"
    answer = cli("fidelity", real[0], "--robot", real[1], "--picture", str(picture), "--json")
    before, after = answer.json["as_recorded"], answer.json["with_robot"]
    assert (answer.status, answer.json["exit_status"], answer.json["missed"]) == (0, 0, [])
    assert after["path"]["largest_m"] < before["path"]["largest_m"] / 5
    assert answer.err == f"The picture: {picture}\n"
    drawn = cv2.imread(str(picture))
    assert drawn is not None
    assert drawn.shape == (1000, 1600, 3)


def test_a_missed_bound_has_exit_status_1(cli: Cli, real: tuple[str, str], check_text: CheckText) -> None:
    bounds = ["--require", "path.end_m<=0.001", "--require", "path.heading_rad<=100"]
    answer = cli("fidelity", real[0], *bounds)
    assert answer.status == 1
    assert answer.out.startswith("real.mcap  avoid-obstacles on virtualpi")
    measured = answer.err.split("path.end_m is ")[1].split(",")[0]
    check_text(answer.err, hide=[measured])
    assert len(cli("fidelity", real[0], *bounds, "--json").json["missed"]) == 1
    assert cli("fidelity", real[0], "--robot", real[1], "--require", "path.end_m<=0.01").status == 0


@pytest.mark.parametrize(
    "arguments",
    [
        ["--backend", "raspberrypi"],
        ["--robot", "no-robot"],
        ["--world", "no-world"],
        ["--picture", "picture.jpg"],
        ["--require", "path.end_m"],
        ["--duration", "0"],
        ["--duration", "0.01"],
        ["--option", "speed=1"],
    ],
    ids=" ".join,
)
def test_a_wrong_option_is_refused(
    cli: Cli, real: tuple[str, str], arguments: list[str], check_text: CheckText
) -> None:
    answer = cli("fidelity", real[0], *arguments)
    assert (answer.status, answer.out) == (2, "")
    check_text(answer.err, hide=[real[0]])


def test_the_picture_does_not_replace_a_file_that_the_command_reads(
    cli: Cli, real: tuple[str, str], check_text: CheckText
) -> None:
    for file in real:
        answer = cli("fidelity", real[0], "--robot", real[1], "--picture", file)
        assert answer.status == 2
        check_text(answer.err, hide=[file])
