from __future__ import annotations

import inspect
from pathlib import Path

import pytest

from robotcore.autonomy import manoeuvres
from robotcore.autonomy.manoeuvres import blockage, limits, motion, path_planning
from robotcore.errors import _BLOCKAGES
from tests.docs.listings import find_code, read_rows

PAGE = (Path(__file__).parents[2] / "docs" / "manoeuvres.md").read_text()
CALLS = [row[0].strip(" `") for row in read_rows(PAGE, "Manoeuvres")]


@pytest.mark.parametrize("call", CALLS)
def test_the_page_shows_the_parameters_of_each_manoeuvre(call: str) -> None:
    name = call.partition("(")[0]
    parameters = inspect.signature(getattr(manoeuvres, name)).parameters.values()
    bare = [each.replace(annotation=inspect.Parameter.empty) for each in parameters]
    assert call == f"{name}{inspect.Signature(bare)}"


def test_the_page_names_each_cause_of_a_blockage() -> None:
    assert {find_code(row[0])[0] for row in read_rows(PAGE, "A blocked robot")} == set(_BLOCKAGES)


def test_the_numbers_on_the_page_are_those_of_the_code() -> None:
    assert (blockage.GUARDED_S, blockage.STALLED_S, blockage.STALLED_SHARE) == (0.5, 0.8, 0.25)
    assert (motion.SETTLE_S, motion.CORRECTION_S) == (0.2, 2.0)
    assert (limits.SPEED_SHARE, limits.TURN_SHARE, limits.ACCELERATION_SHARE) == (0.5, 0.3, 0.8)
    assert (limits.MAX_M, limits.MAX_RAD) == (100.0, 20.0)
    assert (path_planning.CUT_M, path_planning.RADIUS_FACTOR, path_planning.SAME_M) == (0.01, 1.1, 0.003)
