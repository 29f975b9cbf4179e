from __future__ import annotations

import math
from typing import Any

import pytest

from robotcore.live.actions import MAX_NAME_CHARACTERS, MAX_NUMBERS, MAX_SPEED, MAX_STEPS, MIN_SPEED, read_action

NO_RATIOS = (math.nan, math.inf, 10**400, 1.01, True, "1", None)


@pytest.mark.parametrize(
    "action",
    [
        {"type": "drive", "linear": -1.0, "angular": 1.0, "sent": 5.0},
        {"type": "actuate", "device": "pan", "value": [0.5], "sent": 5.0},
        {"type": "pace", "speed": None},
        {"type": "pace", "speed": MIN_SPEED},
        {"type": "pace", "speed": MAX_SPEED},
        {"type": "pace", "is_paused": True},
        {"type": "pace", "steps": MAX_STEPS},
        {"type": "release"},
    ],
)
def test_an_action_of_the_page_is_read(action: dict[str, Any]) -> None:
    assert read_action(action) == action


def test_other_fields_of_a_message_are_left_out() -> None:
    assert read_action({"type": "release", "reason": "x"}) == {"type": "release"}


@pytest.mark.parametrize(
    "message",
    [
        {},
        {"type": "estop now"},
        {"type": "viewers", "count": 3},
        *({"type": "drive", "linear": each, "angular": 0, "sent": 0} for each in NO_RATIOS),
        *({"type": "drive", "linear": 0, "angular": 0, "sent": each} for each in (math.nan, 10**400, None)),
        {"type": "drive", "linear": 0, "angular": -1.01, "sent": 0},
        {"type": "drive", "linear": 0, "sent": 0},
        {"type": "drive", "linear": 0, "angular": 0},
        {"type": "actuate", "device": "pan", "value": [0.5]},
        {"type": "actuate", "device": "pan", "value": 0.5, "sent": 0},
        {"type": "actuate", "device": "pan", "value": [math.inf], "sent": 0},
        {"type": "actuate", "device": "pan", "value": [0.0] * (MAX_NUMBERS + 1), "sent": 0},
        {"type": "actuate", "device": None, "value": [0.0], "sent": 0},
        {"type": "actuate", "device": "x" * (MAX_NAME_CHARACTERS + 1), "value": [0.0], "sent": 0},
        *({"type": "pace", "speed": each} for each in (0, -1, MAX_SPEED + 1, 10**400, math.nan, "1")),
        *({"type": "pace", "steps": each} for each in (0, MAX_STEPS + 1, 1.5)),
        {"type": "pace", "is_paused": 0},
    ],
)
def test_another_message_is_refused(message: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="not"):
        read_action(message)
