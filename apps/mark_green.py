"""Show the camera's picture on the display, with a yellow rectangle around each green blob."""

from __future__ import annotations

from dataclasses import dataclass

from robotcore import Behaviour, Positive, Robot, Role, Status
from robotcore.autonomy.vision import ColourDetector, draw_boxes


@dataclass
class MarkGreen(Behaviour):
    """Marks blobs of a hue in the camera's pictures for a given time. It needs no drive."""

    hue: str = "green"
    """The hue to mark, by name or in degrees."""
    duration_s: Positive = 10.0
    """The duration of the run."""

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
