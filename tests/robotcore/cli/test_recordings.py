"""``robotcore replay``, ``compare`` and ``info``, on files that ``run --record`` wrote."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from robotcore.cli.main import execute
from tests.robotcore.cli.conftest import AppFile, Cli

COMMANDS = ("replay", "info", "compare")


@pytest.fixture(scope="session")
def search(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A whole run of the main job."""
    file = tmp_path_factory.mktemp("recorded") / "search.mcap"
    assert execute(["run", "green-search", "--seed", "7", "--record", str(file), "--json"]) == 0
    return file


@pytest.fixture(scope="session")
def brief(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A second of looking at a ball, small enough to be damaged often."""
    file = tmp_path_factory.mktemp("recorded") / "brief.mcap"
    arguments = ["run", "mark-green", "--robot", "lookout", "--world", "open", "--timeout", "1", "--json"]
    assert execute([*arguments, "--record", str(file)]) == 1
    return file


def test_same_app_is_bit_equal(cli: Cli, search: Path) -> None:
    told = cli("replay", str(search))
    assert told.status == 0
    assert told.out.startswith("bit-equal  green-search on kinematic, arena, seed 7\n  480 ticks, 23.95 s\n  trace ")
    assert "as recorded" in told.out
    assert told.err == ""


def test_json_is_one_line_with_the_digests(cli: Cli, search: Path) -> None:
    told = cli("replay", str(search), "--json").json
    assert (told["bit_equal"], told["ticks"], told["deviation"], told["exit_status"]) == (True, 480, None, 0)
    assert told["trace_sha256"] == told["recorded_sha256"]


def test_own_app_that_has_changed_since_is_told_where(cli: Cli, app_file: AppFile, tmp_path: Path) -> None:
    app, file = app_file("pass"), str(tmp_path / "own.mcap")
    assert cli("run", app, "--timeout", "1", "--record", file).status == 1
    same = cli("replay", file)
    assert same.status == 0
    assert "was recorded" not in same.out
    app_file("robot.drive.set_velocity(0.125, 0.0)")
    told = cli("replay", file)
    assert told.status == 1
    assert "odd.py has changed since it was recorded" in told.out
    assert "differs" in told.out
    assert "tick 2, at 0.1 s, the command differs" in told.out
    assert "before it, 2 of 21 ticks are equal" in told.out
    assert cli("replay", file, "--json").json["deviation"]["tick"] == 2


def test_own_app_that_has_changed_but_decides_the_same_is_told(cli: Cli, app_file: AppFile, tmp_path: Path) -> None:
    app, file = app_file("pass"), str(tmp_path / "own.mcap")
    cli("run", app, "--timeout", "1", "--record", file)
    app_file("...")
    told = cli("replay", file)
    assert told.status == 0
    assert "odd.py has changed since it was recorded" in told.out
    assert cli("replay", file, "--json").json["app_changed"] is True


def test_own_app_that_is_the_same_but_decides_otherwise_is_asked_for_chance(
    cli: Cli, app_file: AppFile, tmp_path: Path
) -> None:
    chance = "robot.drive.set_velocity(int.from_bytes(os.urandom(3), 'big') * 1e-8, 0.0)"
    file = str(tmp_path / "own.mcap")
    cli("run", app_file(chance), "--timeout", "1", "--record", file)
    told = cli("replay", file)
    assert told.status == 1
    assert "odd.py is the file that was recorded: does it use random numbers, the time, or another file?" in told.out


def test_own_app_that_is_gone_is_named_with_what_to_do(cli: Cli, app_file: AppFile, tmp_path: Path) -> None:
    app, file = app_file("pass"), str(tmp_path / "own.mcap")
    cli("run", app, "--timeout", "1", "--record", file)
    Path(app).unlink()
    told = cli("replay", file)
    assert told.status == 2
    assert f"own.mcap: its app, {app}, is not here. Replay it from the folder that it was run in" in told.err
    assert cli("replay", file, "--set", "speed=1").err == told.err


def test_own_app_that_raises_now_is_told_with_its_traceback(cli: Cli, app_file: AppFile, tmp_path: Path) -> None:
    app, file = app_file("pass"), str(tmp_path / "own.mcap")
    cli("run", app, "--timeout", "1", "--record", file)
    app_file("1 / 0")
    told = cli("replay", file)
    assert told.status == 1
    assert "Odd raised ZeroDivisionError" in told.out
    assert "odd.py" in told.err


def test_app_that_raised_then_is_replayed_without_a_word_of_it(cli: Cli, app_file: AppFile, tmp_path: Path) -> None:
    file = str(tmp_path / "own.mcap")
    assert cli("run", app_file("1 / 0"), "--record", file).status == 5
    told = cli("replay", file)
    assert (told.status, told.err) == (0, "")


def test_run_that_a_signal_ended_says_so(cli: Cli, app_file: AppFile, tmp_path: Path) -> None:
    file = str(tmp_path / "own.mcap")
    assert cli("run", app_file("os.kill(os.getpid(), signal.SIGTERM)"), "--record", file).status == 143
    app_file("pass")
    told = cli("replay", file)
    assert told.status == 0
    assert "the recording ends here: interrupted by SIGTERM" in told.out


def test_another_setting_is_rehearsed_and_drawn(cli: Cli, search: Path, tmp_path: Path) -> None:
    picture = tmp_path / "other.png"
    told = cli("replay", str(search), "--set", "speed_m_s=0.1", "--picture", str(picture))
    assert told.status == 0
    assert "they part in tick" in told.out
    assert "ticks differ" in told.out
    drawn = cv2.imread(str(picture))
    assert drawn is not None
    assert drawn.shape == (1000, 1600, 3)


def test_app_that_needs_another_sensor_is_refused_by_its_name(cli: Cli, brief: Path) -> None:
    told = cli("replay", str(brief), "--app", "green-search")
    assert told.status == 2
    assert "drive" in told.err


def test_lossy_recording_is_refused_and_rehearsed_with_a_warning(cli: Cli, tmp_path: Path) -> None:
    file = str(tmp_path / "lossy.mcap")
    cli("run", "mark-green", "--robot", "lookout", "--timeout", "1", "--record", file, "--record-jpeg")
    refused = cli("replay", file)
    assert refused.status == 2
    assert "JPEG is not what the app saw" in refused.err
    told = cli("replay", file, "--app", "mark-green")
    assert told.status == 0
    assert "JPEG is not what the app saw" in told.out


def test_comparison_of_a_run_with_itself_is_alike(cli: Cli, search: Path, tmp_path: Path) -> None:
    picture = tmp_path / "both.png"
    told = cli("compare", str(search), str(search), "--picture", str(picture))
    assert told.status == 0
    assert told.out.startswith("alike  the same milestones in the same order")
    assert picture.stat().st_size > 10_000


def test_comparison_of_different_runs_has_exit_status_1(cli: Cli, search: Path, brief: Path) -> None:
    told = cli("compare", str(search), str(brief), "--json")
    assert told.status == told.json["exit_status"] == 1
    assert (told.json["first"]["outcome"], told.json["second"]["outcome"]) == ("success", "timeout")


def test_info_names_what_it_has_made_also_where_the_next_fails(cli: Cli, search: Path, tmp_path: Path) -> None:
    table = tmp_path / "run.csv"
    told = cli("info", str(search), "--csv", str(table), "--video", str(tmp_path / "gone" / "run.mp4"))
    assert told.status == 2
    assert told.out.endswith(f"The table: {table}\n")


def test_info_tells_the_run_its_devices_and_what_it_is_good_for(cli: Cli, search: Path) -> None:
    told = cli("info", str(search))
    assert told.status == 0
    for words in ("whole, replayable", "480 ticks at 20.00 Hz", "verified by the simulator", "range sensor"):
        assert words in told.out


def test_info_makes_all_that_it_is_asked_for(cli: Cli, search: Path, tmp_path: Path) -> None:
    picture, film = tmp_path / "a.png", tmp_path / "a.mp4"
    told = cli("info", str(search), "--picture", str(picture), "--csv", str(tmp_path), "--video", str(film), "--json")
    assert told.json["replayable"] is True
    assert len((tmp_path / "search.csv").read_text().splitlines()) == 481
    assert picture.stat().st_size > 10_000
    assert film.stat().st_size > 10_000


def test_device_without_a_film_is_refused(cli: Cli, search: Path) -> None:
    told = cli("info", str(search), "--device", "eye")
    assert told.status == 2
    assert "--video" in told.err


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
def test_no_output_is_written_over_the_recording_that_is_read(
    cli: Cli, brief: Path, tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    file, link, twin = tmp_path / "run.mcap", tmp_path / "link.csv", tmp_path / "twin.png"
    file.write_bytes(brief.read_bytes())
    link.symlink_to(file)
    twin.hardlink_to(file)
    told = cli(*(each.format(file, link, twin) for each in arguments))
    assert (told.status, told.out) == (2, "")
    assert "this is the recording that is read. Name another file" in told.err
    assert file.read_bytes() == brief.read_bytes()


def test_recording_named_as_a_table_is_not_written_over_by_its_table_in_its_folder(
    cli: Cli, brief: Path, tmp_path: Path
) -> None:
    file = tmp_path / "run.csv"
    file.write_bytes(brief.read_bytes())
    assert cli("info", str(file), "--csv", str(tmp_path)).status == 2
    assert file.read_bytes() == brief.read_bytes()


@pytest.mark.parametrize("option, name", [("--video", "v.txt"), ("--video", "v"), ("--csv", "t.xlsx")])
def test_output_of_an_ending_that_does_not_fit_is_refused_before_it_is_made(
    cli: Cli, brief: Path, tmp_path: Path, option: str, name: str
) -> None:
    told = cli("info", str(brief), option, str(tmp_path / name))
    assert (told.status, told.out) == (2, "")
    assert "Give it that ending" in told.err
    assert told.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["v.mp4", "v.avi", "V.MP4"])
def test_film_is_written_without_a_word_of_the_library(cli: Cli, brief: Path, tmp_path: Path, name: str) -> None:
    told = cli("info", str(brief), "--video", str(tmp_path / name))
    assert (told.status, told.err) == (0, "")
    assert cv2.VideoCapture(str(tmp_path / name)).read()[0]


def test_film_that_cannot_be_written_is_told_without_a_word_of_the_library(
    cli: Cli, brief: Path, tmp_path: Path
) -> None:
    told = cli("info", str(brief), "--video", str(tmp_path / "gone" / "v.mp4"))
    assert told.status == 2
    assert told.err.count("\n") == 1


def test_camera_that_is_not_there_offers_the_nearest(cli: Cli, brief: Path, tmp_path: Path) -> None:
    told = cli("info", str(brief), "--video", str(tmp_path / "v.mp4"), "--device", "eey")
    assert told.status == 2
    assert "unknown camera or display of the recording 'eey'. Did you mean 'eye'?" in told.err


def test_end_that_alone_differs_is_told_beside_what_was_decided(cli: Cli, app_file: AppFile, tmp_path: Path) -> None:
    app, file = app_file("return Status.SUCCESS"), str(tmp_path / "own.mcap")
    cli("run", app, "--record", file)
    app_file("return Status.FAILURE")
    told = cli("replay", file)
    assert "the end differs" in told.out
    assert "before it" not in told.out
    assert "all that was decided in 3 ticks is equal" in told.out


def test_error_without_words_is_told_without_a_colon(cli: Cli, app_file: AppFile) -> None:
    told = cli("run", app_file("raise ValueError"))
    assert "Odd raised ValueError\n" in told.err


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("content", [None, b"", b"no recording", b"\x89MCAP0\r\n", b"\x89MCAP0\r\n\x89MCAP0\r\n"])
def test_what_is_no_recording_is_told_by_its_file(cli: Cli, tmp_path: Path, command: str, content: Any) -> None:
    file = tmp_path / "odd.mcap"
    if content is not None:
        file.write_bytes(content)
    told = cli(command, *[str(file)] * (2 if command == "compare" else 1))
    assert (told.status, told.out) == (2, "")
    assert told.err.startswith("error: ")
    assert "odd.mcap" in told.err


@pytest.mark.parametrize("command", COMMANDS)
def test_missing_extra_is_named_with_its_remedy(
    cli: Cli, search: Path, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    monkeypatch.setattr("robotcore.recording.extra.find_spec", lambda _: None)
    told = cli(command, *[str(search)] * (2 if command == "compare" else 1))
    assert told.status == 3
    assert "pip install 'robotcore[record]'" in told.err


def test_damage_is_told_by_its_time_and_what_came_before_is_replayed(cli: Cli, search: Path, tmp_path: Path) -> None:
    file = tmp_path / "damaged.mcap"
    file.write_bytes(_damaged(search.read_bytes(), [("flip", 0.5, 1)]))
    info, replayed = cli("info", str(file)), cli("replay", str(file))
    told = cli("info", str(file), "--json").json
    assert (info.status, told["damaged"], told["whole"]) == (0, True, False)
    words = f"the file is damaged at {told['duration_s']:.1f} s: what comes after is not read"
    assert f"damaged  {words}" in info.out
    assert "cut" not in info.out
    assert replayed.status == 0
    assert replayed.out.startswith("bit-equal")
    assert f"the recording ends here: {words}" in replayed.out


damages = st.one_of(
    st.tuples(st.just("cut"), st.floats(0, 1), st.just(0)),
    st.tuples(st.just("flip"), st.floats(0, 1), st.integers(1, 255)),
)


@pytest.mark.parametrize("command", ["replay", "rehearse", "info", "compare"])
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(damage=st.lists(damages, min_size=1, max_size=3))
def test_damaged_file_ends_in_a_shorter_recording_or_a_named_error(
    cli: Cli, brief: Path, tmp_path: Path, command: str, damage: list[tuple[str, float, int]]
) -> None:
    file = tmp_path / "damaged.mcap"
    file.write_bytes(_damaged(brief.read_bytes(), damage))
    told = cli(*_arguments(command, file, brief, tmp_path))
    assert told.status in (0, 1, 2, 3)
    assert "Traceback" not in told.err
    assert told.status != 2 or "damaged.mcap" in told.err
    assert told.status == 0 or told.out or told.err


def _arguments(command: str, file: Path, whole: Path, folder: Path) -> list[str]:
    return {
        "replay": ["replay", str(file)],
        "rehearse": ["replay", str(file), "--app", "mark-green"],
        "info": ["info", str(file), "--csv", str(folder), "--picture", str(folder / "a.png")],
        "compare": ["compare", str(whole), str(file)],
    }[command]


def _damaged(content: bytes, damage: list[tuple[str, float, int]]) -> bytes:
    damaged = bytearray(content)
    for kind, where, bits in damage:
        at = int(where * (len(damaged) - 1)) if damaged else 0
        if kind == "cut":
            del damaged[at:]
        elif damaged:
            damaged[at] ^= bits
    return bytes(damaged)
