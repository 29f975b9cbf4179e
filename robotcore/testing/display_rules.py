"""Rules for displays: they take what an app shows, in colour or grey, and leave it as it is."""

from __future__ import annotations

import numpy as np
import pytest

from robotcore.hal.robot import Role
from robotcore.testing.bench import Bench

SHAPES = {"colour": (48, 64, 3), "grey": (48, 64)}


class DisplayRules(Bench):
    """What every display owes."""

    @pytest.mark.parametrize("kind", SHAPES)
    def test_display_takes_a_picture(self, kind: str) -> None:
        picture = np.full(SHAPES[kind], 99, dtype=np.uint8)
        picture.flags.writeable = False
        with self.opened(None, Role.DISPLAY) as robot:
            try:
                robot.display.show(picture)
            except Exception as error:  # noqa: BLE001  whatever it is, it is the driver's
                pytest.fail(f"{robot.display.name}: a read-only picture in {kind} raised {error!r}")

    def test_display_leaves_the_picture_as_it_is(self) -> None:
        picture = np.arange(48 * 64 * 3, dtype=np.uint32).astype(np.uint8).reshape(48, 64, 3)
        shown = picture.copy()
        with self.opened(None, Role.DISPLAY) as robot:
            robot.display.show(shown)
        assert np.array_equal(shown, picture), "showing a picture changed it; work on a copy"
