"""``robotcore replay``, ``compare`` and ``info``, on files that ``run --record`` wrote."""

from __future__ import annotations

import csv
import os
import re
from pathlib import Path
from typing import Any

import cv2
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from benchmarks.hostile_files.files import ESCAPES, name_files
from benchmarks.hostile_files.mcap_builder import change_json
from robotcore.recording.chunks import ChunkedFile, ChunkLocation
from robotcore.view.canvas import GOOD
from tests.robotcore.cli.conftest import AppFile, Cli, Recorded
from tests.texts import CheckText

COMMANDS = ("replay", "info", "compare")
HEAD_BYTES = 9
"""A record of an MCAP file begins with its kind and its length."""


def test_same_app_is_bit_equal(cli: Cli, recorded: Recorded, check_text: CheckText) -> None:
    answers = cli("replay", str(recorded.file))
    assert (answers.status, answers.err) == (0, "")
    check_text(answers.out, hide=[f"{recorded.ticks} ticks, {recorded.time}", *re.findall("[0-9a-f]{64}", answers.out)])


def test_json_is_one_line_with_the_digests(cli: Cli, recorded: Recorded) -> None:
    answers = cli("replay", str(recorded.file), "--json").json
    assert (answers["bit_equal"], answers["deviation"], answers["exit_status"]) == (True, None, 0)
    assert answers["ticks"] == recorded.ticks
    assert answers["trace_sha256"] == answers["recorded_sha256"]


def test_another_setting_is_evaluated_and_drawn(cli: Cli, search: Path, tmp_path: Path) -> None:
    picture = tmp_path / "other.png"
    answers = cli("replay", str(search), "--set", "speed_m_s=0.1", "--picture", str(picture), "--json")
    assert answers.status == 0
    assert answers.json["parting"]
    assert answers.json["differing_ticks"] > 0
    drawn = cv2.imread(str(picture))
    assert drawn is not None
    assert drawn.shape == (1000, 1600, 3)
    assert not (drawn[:130, :, ::-1] == GOOD).all(axis=2).any()


def test_app_that_needs_another_device_is_refused(cli: Cli, brief: Path, check_text: CheckText) -> None:
    answers = cli("replay", str(brief), "--app", "green-search")
    assert answers.status == 2
    check_text(answers.err)


def test_lossy_recording_is_refused_and_evaluated_with_a_warning(
    cli: Cli, tmp_path: Path, check_text: CheckText
) -> None:
    file = str(tmp_path / "lossy.mcap")
    cli("run", "mark-green", "--robot", "lookout", "--timeout", "1", "--record", file, "--record-jpeg")
    refused = cli("replay", file)
    assert refused.status == 2
    check_text(refused.err)
    answers = cli("replay", file, "--app", "mark-green", "--json")
    assert answers.status == 0
    check_text(answers.json["warning"])


def test_comparison_of_a_run_with_itself_is_alike(
    cli: Cli, search: Path, tmp_path: Path, check_text: CheckText
) -> None:
    picture = tmp_path / "both.png"
    answers = cli("compare", str(search), str(search), "--picture", str(picture))
    assert answers.status == 0
    check_text(answers.out.splitlines()[0])
    assert picture.stat().st_size > 10_000


def test_comparison_of_different_runs_has_exit_status_1(cli: Cli, search: Path, brief: Path) -> None:
    answers = cli("compare", str(search), str(brief), "--json")
    assert answers.status == answers.json["exit_status"] == 1
    assert (answers.json["first"]["outcome"], answers.json["second"]["outcome"]) == ("success", "timeout")


def test_info_shows_the_run_and_its_devices(cli: Cli, recorded: Recorded) -> None:
    answers = cli("info", str(recorded.file))
    assert answers.status == 0
    assert f"{recorded.ticks} ticks" in answers.out
    devices = [line.split()[0] for line in answers.out.rpartition("─\n")[2].splitlines()]
    assert devices == ["left_motor", "right_motor", "left_encoder", "right_encoder", "nose", "eye", "screen"]


def test_error_without_a_text_is_reported_without_a_colon(cli: Cli, app_file: AppFile, check_text: CheckText) -> None:
    answers = cli("run", app_file("raise ValueError"))
    check_text(answers.plain_err)


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("content", [None, b"", b"no recording", b"\x89MCAP0\r\n", b"\x89MCAP0\r\n\x89MCAP0\r\n"])
def test_a_file_that_is_no_recording_is_named(
    cli: Cli, tmp_path: Path, command: str, content: Any, check_text: CheckText
) -> None:
    file = tmp_path / "odd.mcap"
    if content is not None:
        file.write_bytes(content)
    answers = cli(command, *[str(file)] * (2 if command == "compare" else 1))
    assert (answers.status, answers.out) == (2, "")
    check_text(answers.plain_err)


@pytest.mark.parametrize("command", COMMANDS)
def test_missing_extra_is_named_with_its_remedy(
    cli: Cli, search: Path, monkeypatch: pytest.MonkeyPatch, command: str, check_text: CheckText
) -> None:
    monkeypatch.setattr("robotcore.recording.mcap_file.find_spec", lambda _: None)
    answers = cli(command, *[str(search)] * (2 if command == "compare" else 1))
    assert answers.status == 3
    check_text(answers.err)


def test_a_damaged_recording_is_replayed_up_to_the_damage(
    cli: Cli, search: Path, tmp_path: Path, check_text: CheckText
) -> None:
    file = tmp_path / "damaged.mcap"
    chunk = _middle_chunk(search)
    file.write_bytes(_flip_bit(search.read_bytes(), chunk.offset + chunk.length // 2))
    info, replayed = cli("info", str(file)), cli("replay", str(file))
    answers = cli("info", str(file), "--json").json
    assert (info.status, answers["damaged"], answers["whole"]) == (0, True, False)
    time = f"{answers['duration_s']:.1f} s"
    (damage,) = (line for line in info.out.splitlines() if line.startswith("damaged  "))
    # The contents of the chunk decide whether its decompression or its checksum fails.
    check_text(re.sub(r"byte \d+, [^)]*", "byte N, REASON", damage), hide=[time])
    assert replayed.status == 0
    assert time in replayed.out.splitlines()[-1]
    assert cli("replay", str(file), "--json").json["bit_equal"] is True


def test_damage_between_two_chunks_costs_nothing_of_the_run(cli: Cli, recorded: Recorded, tmp_path: Path) -> None:
    file = tmp_path / "damaged.mcap"
    chunk = _middle_chunk(recorded.file)
    file.write_bytes(_flip_bit(recorded.file.read_bytes(), chunk.offset + chunk.length + HEAD_BYTES))
    answers, replayed = cli("info", str(file), "--json").json, cli("replay", str(file), "--json")
    assert (answers["damaged"], answers["replayable"], answers["outcome"]) == (True, True, "success")
    assert answers["ticks"] == recorded.ticks
    assert (replayed.status, replayed.json["bit_equal"]) == (0, True)


damages = st.one_of(
    st.tuples(st.just("cut"), st.floats(0, 1), st.just(0)),
    st.tuples(st.just("flip"), st.floats(0, 1), st.integers(1, 255)),
)


@pytest.mark.parametrize("command", ["replay", "evaluate", "info", "compare"])
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(damage=st.lists(damages, min_size=1, max_size=3))
def test_damaged_file_ends_in_a_shorter_recording_or_a_named_error(
    cli: Cli, brief: Path, tmp_path: Path, command: str, damage: list[tuple[str, float, int]]
) -> None:
    file = tmp_path / "damaged.mcap"
    file.write_bytes(_damage(brief.read_bytes(), damage))
    answers = cli(*_arguments(command, file, brief, tmp_path))
    assert answers.status in (0, 1, 2, 3)
    assert "Traceback" not in answers.err
    assert answers.status != 2 or "damaged.mcap" in answers.err
    assert answers.status == 0 or answers.out or answers.err


def _arguments(command: str, file: Path, whole: Path, folder: Path) -> list[str]:
    return {
        "replay": ["replay", str(file)],
        "evaluate": ["replay", str(file), "--app", "mark-green"],
        "info": ["info", str(file), "--csv", str(folder), "--picture", str(folder / "a.png")],
        "compare": ["compare", str(whole), str(file)],
    }[command]


def _middle_chunk(file: Path) -> ChunkLocation:
    """Return the middle chunk of a file. The length of chunks depends on the load of the machine."""
    places = [place for place, _ in ChunkedFile(file).chunks()]
    return places[len(places) // 2]


def _flip_bit(content: bytes, at: int) -> bytes:
    return content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :]


def _damage(content: bytes, damage: list[tuple[str, float, int]]) -> bytes:
    damaged = bytearray(content)
    for kind, where, bits in damage:
        at = int(where * (len(damaged) - 1)) if damaged else 0
        if kind == "cut":
            del damaged[at:]
        elif damaged:
            damaged[at] ^= bits
    return bytes(damaged)


def test_info_names_the_table_even_if_the_video_fails(cli: Cli, search: Path, tmp_path: Path) -> None:
    table = tmp_path / "run.csv"
    answers = cli("info", str(search), "--csv", str(table), "--video", str(tmp_path / "gone" / "run.mp4"))
    assert answers.status == 2
    assert answers.out.endswith(f"The table: {table}\n")


def test_info_writes_table_picture_and_video(cli: Cli, recorded: Recorded, tmp_path: Path) -> None:
    picture, film = tmp_path / "a.png", tmp_path / "a.mp4"
    files = ["--picture", str(picture), "--csv", str(tmp_path), "--video", str(film)]
    answers = cli("info", str(recorded.file), *files, "--json")
    assert answers.json["replayable"] is True
    assert len((tmp_path / "search.csv").read_text().splitlines()) == 1 + recorded.ticks
    assert picture.stat().st_size > 10_000
    assert film.stat().st_size > 10_000


def test_device_without_a_film_is_refused(cli: Cli, search: Path, check_text: CheckText) -> None:
    answers = cli("info", str(search), "--device", "eye")
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
    cli: Cli, brief: Path, tmp_path: Path, arguments: tuple[str, ...], check_text: CheckText
) -> None:
    file, link, twin = tmp_path / "run.mcap", tmp_path / "link.csv", tmp_path / "twin.png"
    file.write_bytes(brief.read_bytes())
    link.symlink_to(file)
    twin.hardlink_to(file)
    answers = cli(*(each.format(file, link, twin) for each in arguments))
    assert (answers.status, answers.out) == (2, "")
    check_text(answers.err)
    assert file.read_bytes() == brief.read_bytes()


def test_recording_named_as_a_table_is_not_written_over_by_its_table_in_its_folder(
    cli: Cli, brief: Path, tmp_path: Path
) -> None:
    file = tmp_path / "run.csv"
    file.write_bytes(brief.read_bytes())
    assert cli("info", str(file), "--csv", str(tmp_path)).status == 2
    assert file.read_bytes() == brief.read_bytes()


@pytest.mark.parametrize("option, name", [("--video", "v.txt"), ("--video", "v"), ("--csv", "t.xlsx")])
def test_output_with_a_wrong_suffix_is_refused(
    cli: Cli, brief: Path, tmp_path: Path, option: str, name: str, check_text: CheckText
) -> None:
    answers = cli("info", str(brief), option, str(tmp_path / name))
    assert (answers.status, answers.out) == (2, "")
    check_text(answers.err)
    assert answers.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["v.mp4", "v.avi", "V.MP4"])
def test_film_is_written_without_output_of_the_library(cli: Cli, brief: Path, tmp_path: Path, name: str) -> None:
    answers = cli("info", str(brief), "--video", str(tmp_path / name))
    assert (answers.status, answers.err) == (0, "")
    assert cv2.VideoCapture(str(tmp_path / name)).read()[0]


def test_film_that_cannot_be_written_is_reported_without_output_of_the_library(
    cli: Cli, brief: Path, tmp_path: Path
) -> None:
    answers = cli("info", str(brief), "--video", str(tmp_path / "gone" / "v.mp4"))
    assert answers.status == 2
    assert answers.err.count("\n") == 1


def test_camera_that_is_not_there_offers_the_nearest(
    cli: Cli, brief: Path, tmp_path: Path, check_text: CheckText
) -> None:
    answers = cli("info", str(brief), "--video", str(tmp_path / "v.mp4"), "--device", "eey")
    assert answers.status == 2
    check_text(answers.err)


OUTPUTS = [("--csv", "t.csv"), ("--picture", "p.png"), ("--video", "v.mp4")]


@pytest.mark.parametrize("option, name", OUTPUTS)
@pytest.mark.parametrize("kind", ["link", "dangling", "fifo"])
def test_no_output_is_written_through_a_link_or_into_a_fifo(
    cli: Cli, brief: Path, tmp_path: Path, option: str, name: str, kind: str
) -> None:
    own, output = tmp_path / "own.py", tmp_path / name
    if kind == "fifo":
        os.mkfifo(output)
    else:
        output.symlink_to(own)
    if kind == "link":
        own.write_text("mine")
    before = sorted(tmp_path.iterdir())
    answer = cli("info", str(brief), option, str(output))
    assert answer.status == 2
    assert name in answer.err
    assert sorted(tmp_path.iterdir()) == before
    assert kind != "link" or own.read_text() == "mine"


def test_table_into_a_folder_is_not_written_through_a_link_in_it(cli: Cli, brief: Path, tmp_path: Path) -> None:
    own = tmp_path / "search.py"
    own.write_text("mine")
    (tmp_path / "brief.csv").symlink_to(own)
    assert cli("info", str(brief), "--csv", str(tmp_path)).status == 2
    assert own.read_text() == "mine"


@pytest.mark.parametrize("command", ["replay", "compare"])
def test_picture_of_a_replay_or_comparison_is_not_written_through_a_link(
    cli: Cli, brief: Path, tmp_path: Path, command: str
) -> None:
    own, picture = tmp_path / "own.py", tmp_path / "p.png"
    own.write_text("mine")
    picture.symlink_to(own)
    files = [str(brief)] * (2 if command == "compare" else 1)
    answer = cli(command, *files, "--picture", str(picture))
    assert (answer.status, answer.out) == (2, "")
    assert own.read_text() == "mine"


@pytest.mark.parametrize("option, name", OUTPUTS)
def test_output_takes_the_place_of_the_one_before_and_leaves_nothing_beside_it(
    cli: Cli, brief: Path, tmp_path: Path, option: str, name: str
) -> None:
    output, other = tmp_path / name, tmp_path / "other"
    output.write_text("old")
    other.hardlink_to(output)
    assert cli("info", str(brief), option, str(output)).status == 0
    assert output.read_bytes() != b"old"
    assert other.read_text() == "old"
    assert sorted(tmp_path.iterdir()) == sorted((output, other))


@pytest.mark.parametrize("mode", [0o600, 0o664])
@pytest.mark.parametrize("option, name", OUTPUTS)
def test_output_has_the_permissions_of_the_replaced_file(
    cli: Cli, brief: Path, tmp_path: Path, option: str, name: str, mode: int
) -> None:
    output = tmp_path / name
    output.touch()
    output.chmod(mode)
    assert cli("info", str(brief), option, str(output)).status == 0
    assert output.stat().st_mode & 0o777 == mode


def test_film_with_too_many_pictures_is_refused(
    cli: Cli, brief: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    file, film = tmp_path / "long.mcap", tmp_path / "v.mp4"
    monkeypatch.setattr("robotcore.view.video._MAX_PICTURES", 50)
    file.write_bytes(change_json(brief, "/ticks", lambda number, event: event | {"time": 0.05 * number * 60}))
    answer = cli("info", str(file), "--video", str(film), "--device", "eye")
    assert answer.status == 2
    check_text(answer.err)
    assert not film.exists()


@pytest.mark.parametrize("name", ["time-of-a-long-pause", "picture-0x0", "jpeg-bomb"])
def test_film_of_a_hostile_recording_is_refused_and_leaves_no_half(
    cli: Cli, brief: Path, tmp_path: Path, name: str
) -> None:
    file = tmp_path / "hostile.mcap"
    name_files(is_small=True)[name](brief, file)
    device = "screen" if name.startswith("jpeg") else "eye"
    answer = cli("info", str(file), "--video", str(tmp_path / "v.mp4"), "--device", device)
    assert answer.status == 2
    assert list(tmp_path.iterdir()) == [file]


def test_film_of_a_picture_far_too_high_has_a_size_that_can_be_seen(cli: Cli, brief: Path, tmp_path: Path) -> None:
    file, film = tmp_path / "hostile.mcap", tmp_path / "v.mp4"
    name_files()["picture-1x20000"](brief, file)
    assert cli("info", str(file), "--video", str(film), "--device", "eye").status == 0
    is_read, picture = cv2.VideoCapture(str(film)).read()
    assert is_read
    assert picture.shape[0] < 2000


@pytest.mark.parametrize("name", ["escapes-in-run", "escapes-in-result", "escapes-in-ticks"])
@pytest.mark.parametrize("command", ["info", "replay", "compare"])
def test_texts_of_a_recording_stay_text_in_their_line(
    cli: Cli, brief: Path, tmp_path: Path, command: str, name: str
) -> None:
    file = tmp_path / "hostile.mcap"
    name_files()[name](brief, file)
    answer = cli(command, *[str(file)] * (2 if command == "compare" else 1))
    printed = answer.out + answer.err
    assert printed
    assert printed.replace("\n", "").isprintable()
    assert not any(line.startswith("error: forged") for line in printed.splitlines())


def test_text_that_a_spreadsheet_takes_for_a_formula_is_marked_as_text(cli: Cli, brief: Path, tmp_path: Path) -> None:
    file, table = tmp_path / "hostile.mcap", tmp_path / "t.csv"
    states = ["=cmd()", "+1", "-1", "@sum", "\tx", "safe = 1", ESCAPES]
    file.write_bytes(
        change_json(brief, "/ticks", lambda number, event: event | {"state": states[number % 7], "time": number - 5.0})
    )
    cli("info", str(file), "--csv", str(table))
    with table.open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["state"] for row in rows[:7]] == [f"'{state}" for state in states[:5]] + states[5:]
    assert rows[0]["time_s"] == "-5.0"


@pytest.mark.parametrize("name", ["escapes-in-result", "escapes-in-ticks", "poses-nan", "poses-1e308", "truth-1e308"])
def test_picture_of_a_recording_with_milestones_or_poses_that_cannot_be_is_drawn(
    cli: Cli, search: Path, tmp_path: Path, name: str
) -> None:
    file, picture = tmp_path / "hostile.mcap", tmp_path / "p.png"
    name_files()[name](search, file)
    assert cli("info", str(file), "--picture", str(picture)).status == 0
    assert cv2.imread(str(picture)) is not None


@pytest.mark.parametrize("arguments", [(), ("--set", "duration_s=1")], ids=["verified", "evaluated"])
def test_damaged_picture_is_a_failure_of_its_device_and_not_of_the_app(
    cli: Cli, brief: Path, tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    file = tmp_path / "hostile.mcap"
    name_files()["picture-0x0"](brief, file)
    answer = cli("replay", str(file), *arguments, "--json")
    assert answer.json["exit_status"] in (1, 3)
    assert "Traceback" not in answer.err
