from __future__ import annotations

import pytest

from robotcore.description import load_robot, load_world
from robotcore.errors import UsageError
from robotcore.hal.backend import Setup
from robotcore.simulation.body_cameras import CameraOptions, needs_sheet
from tests.texts import Raises


@pytest.mark.parametrize(
    "devices, gui, choice, is_needed",
    [
        ({"eye"}, False, None, True),
        ({"eye"}, False, "rendered", True),
        ({"eye"}, False, "painted", False),
        ({"eye"}, True, "painted", True),
        ({"nose"}, False, None, False),
        ({"nose"}, True, None, True),
    ],
)
def test_a_sheet_is_needed_for_a_window_and_for_a_rendered_camera(
    devices: set[str], gui: bool, choice: str | None, is_needed: bool
) -> None:
    setup = Setup(load_robot("rover"), load_world("open"), frozenset(devices), gui=gui)
    assert needs_sheet(setup, choice) is is_needed


def test_another_source_of_pictures_is_refused(raises: Raises) -> None:
    setup = Setup(load_robot("rover"), load_world("open"), frozenset(), options={"camera": "drawn"})
    with raises(UsageError, "invalid-option", option="camera"):
        setup.options_as(CameraOptions)
