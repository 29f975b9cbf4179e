"""Mark what is green: a yellow rectangle round it, on the picture that goes to the display."""

from __future__ import annotations

from dataclasses import dataclass

from robotcore import Behaviour, Positive, Robot, Role, Status
from robotcore.autonomy.vision import ColourDetector, draw_boxes


@dataclass
class MarkGreen(Behaviour):
    """Watches through the camera and shows what it finds, until ``duration_s`` has passed; needs no wheels."""

    hue: str = "green"
    duration_s: Positive = 10.0

    needs = frozenset({Role.CAMERA, Role.DISPLAY})
    milestones = ("search", "seen")

    def __post_init__(self) -> None:
        self._detector = ColourDetector(self.hue)

    def step(self, robot: Robot) -> Status:
        frame = robot.camera.read()
        blobs = self._detector.find(frame.image, robot.camera.intrinsics)
        self.state = "seen" if blobs else "search"
        robot.display.show(draw_boxes(frame.image, blobs))
        return Status.SUCCESS if robot.clock.now() >= self.duration_s else Status.RUNNING


if __name__ == "__main__":
    from robotcore.cli.main import run_app

    run_app("mark-green")
