"""The table and the picture of a recorded run and its simulations."""

from __future__ import annotations

from dataclasses import replace

import pytest
from rich.console import Console

from robotcore.description import load_robot
from robotcore.fidelity.fidelity import Fidelity, measure_fidelity
from robotcore.view.fidelity_picture import RECORDED, SIMULATED, draw_fidelity
from robotcore.view.fidelity_table import build_rows, format_fidelity
from robotcore.view.page import MAP, SIDE, TOP
from tests.robotcore.fidelity.drives import record, write_truth
from tests.texts import CheckText


@pytest.fixture(scope="module")
def fidelity(tmp_path_factory: pytest.TempPathFactory) -> Fidelity:
    """Compare a run of a robot with a wrong description."""
    truth = write_truth(tmp_path_factory.mktemp("robot") / "true.toml")
    recording = record(backend="virtualpi", options={"truth": truth}, timeout_s=2.0)
    return measure_fidelity(recording, "folder/real.mcap", robot=load_robot(truth))


def render(fidelity: Fidelity) -> str:
    console = Console(width=160, color_system=None)
    with console.capture() as capture:
        console.print(format_fidelity(fidelity))
    return "\n".join(line.rstrip() for line in capture.get().splitlines())


def test_the_table_has_a_column_for_each_description(fidelity: Fidelity) -> None:
    lines = render(fidelity).splitlines()
    assert lines[0] == "real.mcap  Winding on virtualpi, arena, seed 3, simulated by kinematic in arena"
    assert lines[1].startswith("  41 ticks in 2.00 s, 0.")
    (head,) = (line.split() for line in lines if "as recorded" in line)
    assert head == ["as", "recorded", "true.toml"]


def test_each_measure_has_a_row_and_an_unknown_one_has_a_dash(fidelity: Fidelity) -> None:
    rows = {row[0]: row[1:] for row in build_rows(fidelity)}
    assert list(rows)[:4] == ["path, at the end", "path, largest", "path, mean", "path, heading"]
    assert {"left wheel, RMS", "right wheel, largest", "nose, median", "nose, no echo", "eye, grey"} <= rows.keys()
    first, second = fidelity.simulations
    other = replace(second, differences=replace(second.differences, path=None, ranges={}))
    rows = {row[0]: row[1:] for row in build_rows(replace(fidelity, simulations=(first, other)))}
    assert rows["path, mean"][1] == rows["nose, median"][1] == "–"
    one = replace(first, differences=replace(first.differences, path=None))
    assert "path, mean" not in {row[0] for row in build_rows(replace(fidelity, simulations=(one, other)))}


def test_texts_of_a_recording_are_escaped(fidelity: Fidelity, check_text: CheckText) -> None:
    metadata = fidelity.recording.metadata
    request = replace(metadata.request, app="\x1b[2J")
    recording = replace(fidelity.recording, result=None, metadata=replace(metadata, request=request))
    check_text(render(replace(fidelity, recording=recording, notes=("\x1b]0;PWNED\x07",))).splitlines()[0])


@pytest.mark.slow
def test_the_picture_shows_all_paths_and_charts(fidelity: Fidelity) -> None:
    picture = draw_fidelity(fidelity)[:, :, ::-1]
    assert picture.shape == (1000, 1600, 3)
    world, side = picture[TOP : TOP + MAP, : SIDE - 40], picture[TOP + 80 :, SIDE:]
    for colour in (RECORDED, *SIMULATED):
        for part in (world, side):
            assert (part == colour).all(axis=2).sum() > 50
    one = draw_fidelity(replace(fidelity, simulations=fidelity.simulations[:1]))[:, :, ::-1]
    assert not (one == SIMULATED[1]).all(axis=2)[:, SIDE:].any()


@pytest.mark.slow
def test_a_run_without_a_world_is_drawn_on_an_empty_floor(fidelity: Fidelity) -> None:
    assert draw_fidelity(replace(fidelity, world=None)).shape == (1000, 1600, 3)
