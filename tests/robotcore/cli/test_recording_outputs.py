"""What ``robotcore info`` and its kin write of a recording, and what they refuse to write over."""

from __future__ import annotations

from pathlib import Path

import cv2
import pytest

from tests.robotcore.cli.conftest import Cli, Recorded


def test_info_names_what_it_has_made_also_where_the_next_fails(cli: Cli, search: Path, tmp_path: Path) -> None:
    table = tmp_path / "run.csv"
    told = cli("info", str(search), "--csv", str(table), "--video", str(tmp_path / "gone" / "run.mp4"))
    assert told.status == 2
    assert told.out.endswith(f"The table: {table}\n")


def test_info_makes_all_that_it_is_asked_for(cli: Cli, recorded: Recorded, tmp_path: Path) -> None:
    picture, film = tmp_path / "a.png", tmp_path / "a.mp4"
    files = ["--picture", str(picture), "--csv", str(tmp_path), "--video", str(film)]
    told = cli("info", str(recorded.file), *files, "--json")
    assert told.json["replayable"] is True
    assert len((tmp_path / "search.csv").read_text().splitlines()) == 1 + recorded.ticks
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
    assert "this is the file that is read. Name another one" in told.err
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
