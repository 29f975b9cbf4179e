from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.autonomy.navigation.looking import NO_SURVEY, Look, Survey
from robotcore.geometry import Pose
from tests.robotcore.autonomy.navigation.places import HERE, REACH


def turn(look: Look, headings: list[float]) -> float:
    """Turn from 0 in steps of 0.1 rad until nothing is left; return how far."""
    heading = 0.0
    for _ in range(200):
        bearings = np.array([(at - heading + math.pi) % math.tau - math.pi for at in headings])
        if not (sense := look.sense(heading, bearings)):
            break
        heading += 0.1 * sense
        headings = [at for at in headings if abs((at - heading + math.pi) % math.tau - math.pi) > 0.15]
    return heading


def survey(sweep: Survey, heading: float) -> list[float]:
    """Return through which headings a survey turns, at its turning points."""
    turning_points, last = [], 0.0
    while sense := sweep.sense(heading):
        if sense == -last:
            turning_points.append(heading)
        last = sense
        heading += 0.02 * sense
    return [*turning_points, heading]


class TestLook:
    def test_turns_to_the_nearest_first_and_on_in_the_same_sense(self) -> None:
        assert turn(Look(0.0), [-0.5, 0.8]) == pytest.approx(0.8 - math.tau, abs=0.2)
        assert turn(Look(0.0), [0.5, -0.8]) == pytest.approx(math.tau - 0.8, abs=0.2)

    def test_ends_where_nothing_is_left_to_look_at(self) -> None:
        assert turn(Look(0.0), [1.0, 2.0]) == pytest.approx(2.0, abs=0.2)
        assert Look(0.0).sense(0.0, np.array([])) == 0.0

    def test_goes_round_only_once_though_there_be_more(self) -> None:
        look = Look(0.0)
        heading, bearing = 0.0, np.array([0.3])
        while look.sense(heading, bearing) and heading < 20:
            heading += 0.1
        assert heading == pytest.approx(math.tau - 0.3, abs=0.1)

    def test_turning_back_counts_as_turning_too(self) -> None:
        look = Look(0.0)
        senses = [look.sense(heading, np.array([0.5])) for heading in [0.0, 1.0] * 4]
        assert senses == [1.0] * 6 + [0.0] * 2


class TestSurvey:
    def test_sweeps_both_sides_of_what_is_ahead_the_nearer_first(self) -> None:
        assert survey(Survey.ahead(HERE, 0.3), 0.0) == pytest.approx([-0.5, 1.1], abs=0.12)
        assert survey(Survey.ahead(HERE, -0.3), 0.0) == pytest.approx([0.5, -1.1], abs=0.12)

    def test_all_round_is_one_whole_turn(self) -> None:
        assert survey(Survey.all_round(Pose(0.0, 0.0, 1.0)), 1.0) == pytest.approx([1.0 + math.tau], abs=0.12)

    def test_holds_until_the_robot_has_moved_on(self) -> None:
        sweep = Survey.ahead(HERE, 0.0)
        assert sweep.is_about(Pose(0.1, 0.0, 2.0), REACH)
        assert not sweep.is_about(Pose(0.2, 0.0, 0.0), REACH)

    def test_none_was_made_about_anywhere(self) -> None:
        assert not NO_SURVEY.is_about(HERE, REACH)
        assert NO_SURVEY.sense(0.0) == 0.0
