"""The tables, pictures and videos that ``info``, ``replay`` and ``compare`` write from a recording."""

from __future__ import annotations

import csv
import os
from pathlib import Path

import cv2
import pytest

from tests.robotcore.cli.conftest import Cli, RecordedRun
from tests.robotcore.recording.hostile_files import ESCAPES, name_files
from tests.robotcore.recording.mcap_builder import change_json
from tests.texts import CheckText


@pytest.mark.slow
def test_info_names_the_table_even_if_the_video_fails(cli: Cli, search_recording: Path, tmp_path: Path) -> None:
    table = tmp_path / "run.csv"
    answers = cli("info", str(search_recording), "--csv", str(table), "--video", str(tmp_path / "gone" / "run.mp4"))
    assert answers.status == 2
    assert answers.out.endswith(f"The table: {table}\n")


@pytest.mark.slow
def test_info_writes_table_picture_and_video(cli: Cli, recorded: RecordedRun, tmp_path: Path) -> None:
    picture, video = tmp_path / "a.png", tmp_path / "a.mp4"
    files = ["--picture", str(picture), "--csv", str(tmp_path), "--video", str(video)]
    answers = cli("info", str(recorded.file), *files, "--json")
    assert answers.json["replayable"] is True
    assert len((tmp_path / "search.csv").read_text().splitlines()) == 1 + recorded.ticks
    assert picture.stat().st_size > 10_000
    assert video.stat().st_size > 10_000


@pytest.mark.slow
def test_device_without_a_video_is_refused(cli: Cli, search_recording: Path, check_text: CheckText) -> None:
    answers = cli("info", str(search_recording), "--device", "eye")
    assert answers.status == 2
    check_text(answers.err)


@pytest.mark.parametrize(
    "arguments",
    [
        ("info", "{0}", "--csv", "{0}"),
        ("info", "{0}", "--csv", "{1}"),
        ("info", "{0}", "--picture", "{2}"),
        ("info", "{0}", "--video", "{0}"),
        ("replay", "{0}", "--picture", "{0}"),
        ("compare", "{1}", "{0}", "--picture", "{2}"),
    ],
    ids=" ".join,
)
def test_the_recording_is_not_overwritten_by_an_output(
    cli: Cli, brief_recording: Path, tmp_path: Path, arguments: tuple[str, ...], check_text: CheckText
) -> None:
    file, link, twin = tmp_path / "run.mcap", tmp_path / "link.csv", tmp_path / "twin.png"
    file.write_bytes(brief_recording.read_bytes())
    link.symlink_to(file)
    twin.hardlink_to(file)
    answers = cli(*(each.format(file, link, twin) for each in arguments))
    assert (answers.status, answers.out) == (2, "")
    check_text(answers.err)
    assert file.read_bytes() == brief_recording.read_bytes()


def test_a_recording_with_the_name_of_its_table_is_not_overwritten(
    cli: Cli, brief_recording: Path, tmp_path: Path
) -> None:
    file = tmp_path / "run.csv"
    file.write_bytes(brief_recording.read_bytes())
    assert cli("info", str(file), "--csv", str(tmp_path)).status == 2
    assert file.read_bytes() == brief_recording.read_bytes()


@pytest.mark.parametrize("option, name", [("--video", "v.txt"), ("--video", "v"), ("--csv", "t.xlsx")])
def test_output_with_a_wrong_suffix_is_refused(
    cli: Cli, brief_recording: Path, tmp_path: Path, option: str, name: str, check_text: CheckText
) -> None:
    answers = cli("info", str(brief_recording), option, str(tmp_path / name))
    assert (answers.status, answers.out) == (2, "")
    check_text(answers.err)
    assert answers.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["v.mp4", "v.avi", "V.MP4"])
def test_a_video_is_written_without_output_of_the_library(
    cli: Cli, brief_recording: Path, tmp_path: Path, name: str
) -> None:
    answers = cli("info", str(brief_recording), "--video", str(tmp_path / name))
    assert (answers.status, answers.err) == (0, "")
    assert cv2.VideoCapture(str(tmp_path / name)).read()[0]


def test_a_video_that_cannot_be_written_is_reported_without_output_of_the_library(
    cli: Cli, brief_recording: Path, tmp_path: Path
) -> None:
    answers = cli("info", str(brief_recording), "--video", str(tmp_path / "gone" / "v.mp4"))
    assert answers.status == 2
    assert answers.err.count("\n") == 1


def test_for_an_unknown_camera_the_nearest_name_is_suggested(
    cli: Cli, brief_recording: Path, tmp_path: Path, check_text: CheckText
) -> None:
    answers = cli("info", str(brief_recording), "--video", str(tmp_path / "v.mp4"), "--device", "eey")
    assert answers.status == 2
    check_text(answers.err)


OUTPUTS = [("--csv", "t.csv"), ("--picture", "p.png"), ("--video", "v.mp4")]


@pytest.mark.parametrize("option, name", OUTPUTS)
@pytest.mark.parametrize("kind", ["link", "dangling", "fifo"])
def test_no_output_is_written_through_a_link_or_into_a_fifo(
    cli: Cli, brief_recording: Path, tmp_path: Path, option: str, name: str, kind: str
) -> None:
    own, output = tmp_path / "own.py", tmp_path / name
    if kind == "fifo":
        os.mkfifo(output)
    else:
        output.symlink_to(own)
    if kind == "link":
        own.write_text("mine")
    before = sorted(tmp_path.iterdir())
    answer = cli("info", str(brief_recording), option, str(output))
    assert answer.status == 2
    assert name in answer.err
    assert sorted(tmp_path.iterdir()) == before
    assert kind != "link" or own.read_text() == "mine"


def test_table_into_a_folder_is_not_written_through_a_link_in_it(
    cli: Cli, brief_recording: Path, tmp_path: Path
) -> None:
    own = tmp_path / "search.py"
    own.write_text("mine")
    (tmp_path / "brief.csv").symlink_to(own)
    assert cli("info", str(brief_recording), "--csv", str(tmp_path)).status == 2
    assert own.read_text() == "mine"


@pytest.mark.parametrize("command", ["replay", "compare"])
def test_picture_of_a_replay_or_comparison_is_not_written_through_a_link(
    cli: Cli, brief_recording: Path, tmp_path: Path, command: str
) -> None:
    own, picture = tmp_path / "own.py", tmp_path / "p.png"
    own.write_text("mine")
    picture.symlink_to(own)
    files = [str(brief_recording)] * (2 if command == "compare" else 1)
    answer = cli(command, *files, "--picture", str(picture))
    assert (answer.status, answer.out) == (2, "")
    assert own.read_text() == "mine"


@pytest.mark.parametrize("option, name", OUTPUTS)
def test_an_output_replaces_the_previous_file_and_leaves_no_other_file(
    cli: Cli, brief_recording: Path, tmp_path: Path, option: str, name: str
) -> None:
    output, other = tmp_path / name, tmp_path / "other"
    output.write_text("old")
    other.hardlink_to(output)
    assert cli("info", str(brief_recording), option, str(output)).status == 0
    assert output.read_bytes() != b"old"
    assert other.read_text() == "old"
    assert sorted(tmp_path.iterdir()) == sorted((output, other))


@pytest.mark.parametrize("mode", [0o600, 0o664])
@pytest.mark.parametrize("option, name", OUTPUTS)
@pytest.mark.posix("Windows has no permission bits")
def test_output_has_the_permissions_of_the_replaced_file(
    cli: Cli, brief_recording: Path, tmp_path: Path, option: str, name: str, mode: int
) -> None:
    output = tmp_path / name
    output.touch()
    output.chmod(mode)
    assert cli("info", str(brief_recording), option, str(output)).status == 0
    assert output.stat().st_mode & 0o777 == mode


def test_a_video_with_too_many_pictures_is_refused(
    cli: Cli, brief_recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    file, video = tmp_path / "long.mcap", tmp_path / "v.mp4"
    monkeypatch.setattr("robotcore.view.video._MAX_PICTURES", 50)
    file.write_bytes(change_json(brief_recording, "/ticks", lambda number, event: event | {"time": 0.05 * number * 60}))
    answer = cli("info", str(file), "--video", str(video), "--device", "eye")
    assert answer.status == 2
    check_text(answer.err)
    assert not video.exists()


@pytest.mark.parametrize("name", ["time-of-a-long-pause", "picture-0x0", "jpeg-bomb"])
def test_the_video_of_a_hostile_recording_is_refused_and_leaves_no_partial_file(
    cli: Cli, brief_recording: Path, tmp_path: Path, name: str
) -> None:
    file = tmp_path / "hostile.mcap"
    name_files(is_small=True)[name](brief_recording, file)
    device = "screen" if name.startswith("jpeg") else "eye"
    answer = cli("info", str(file), "--video", str(tmp_path / "v.mp4"), "--device", device)
    assert answer.status == 2
    assert list(tmp_path.iterdir()) == [file]


def test_a_very_high_picture_is_squeezed_in_the_video(cli: Cli, brief_recording: Path, tmp_path: Path) -> None:
    file, video = tmp_path / "hostile.mcap", tmp_path / "v.mp4"
    name_files()["picture-1x20000"](brief_recording, file)
    assert cli("info", str(file), "--video", str(video), "--device", "eye").status == 0
    is_read, picture = cv2.VideoCapture(str(video)).read()
    assert is_read
    assert picture.shape[0] < 2000


@pytest.mark.parametrize("name", ["escapes-in-run", "escapes-in-result", "escapes-in-ticks"])
@pytest.mark.parametrize("command", ["info", "replay", "compare"])
def test_texts_of_a_recording_stay_in_one_line(
    cli: Cli, brief_recording: Path, tmp_path: Path, command: str, name: str
) -> None:
    file = tmp_path / "hostile.mcap"
    name_files()[name](brief_recording, file)
    answer = cli(command, *[str(file)] * (2 if command == "compare" else 1))
    printed = answer.out + answer.err
    assert printed
    assert printed.replace("\n", "").isprintable()
    assert not any(line.startswith("error: forged") for line in printed.splitlines())


def test_text_that_a_spreadsheet_would_read_as_a_formula_is_marked_as_text(
    cli: Cli, brief_recording: Path, tmp_path: Path
) -> None:
    file, table = tmp_path / "hostile.mcap", tmp_path / "t.csv"
    states = ["=cmd()", "+1", "-1", "@sum", "\tx", "safe = 1", ESCAPES]
    file.write_bytes(
        change_json(
            brief_recording, "/ticks", lambda number, event: event | {"state": states[number % 7], "time": number - 5.0}
        )
    )
    cli("info", str(file), "--csv", str(table))
    with table.open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["state"] for row in rows[:7]] == [f"'{state}" for state in states[:5]] + states[5:]
    assert rows[0]["time_s"] == "-5.0"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["escapes-in-result", "escapes-in-ticks", "poses-nan", "poses-1e308", "truth-1e308"])
def test_a_recording_with_impossible_milestones_or_poses_has_a_picture(
    cli: Cli, search_recording: Path, tmp_path: Path, name: str
) -> None:
    file, picture = tmp_path / "hostile.mcap", tmp_path / "p.png"
    name_files()[name](search_recording, file)
    assert cli("info", str(file), "--picture", str(picture)).status == 0
    assert cv2.imread(str(picture)) is not None


@pytest.mark.parametrize("arguments", [(), ("--set", "duration_s=1")], ids=["verified", "evaluated"])
def test_damaged_picture_is_a_failure_of_its_device_and_not_of_the_app(
    cli: Cli, brief_recording: Path, tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    file = tmp_path / "hostile.mcap"
    name_files()["picture-0x0"](brief_recording, file)
    answer = cli("replay", str(file), *arguments, "--json")
    assert answer.json["exit_status"] in (1, 3)
    assert "Traceback" not in answer.err
