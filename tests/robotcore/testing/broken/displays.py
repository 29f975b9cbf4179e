from __future__ import annotations

from robotcore.hal.devices import Image
from robotcore.hal.robot import Robot
from tests.robotcore.testing.harness import broken, swap_in


def refusing_grey(robot: Robot) -> None:
    def show(image: Image) -> None:
        _, _, _ = image.shape

    if "screen" in robot.devices:
        swap_in(robot["screen"], "_show", show)


def drawing_a_frame(robot: Robot) -> None:
    def show(image: Image) -> None:
        if image.flags.writeable:
            image[0] = 0

    if "screen" in robot.devices:
        swap_in(robot["screen"], "_show", show)


BROKEN = (
    broken("grey pictures are not taken", "display_takes_a_picture", refusing_grey),
    broken("the display draws on the app's picture", "display_leaves_the_picture_as_it_is", drawing_a_frame),
)
