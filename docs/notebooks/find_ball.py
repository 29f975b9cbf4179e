"""Find a green ball, and drive to it."""

from dataclasses import dataclass

from robotcore import Behaviour, Robot, Role, Routine, Status, Truth, until, wait
from robotcore.autonomy.vision import Blob, ColourDetector


@dataclass
class FindBall(Behaviour):
    """Turns until it sees the ball, drives to it, and stops in front of it."""

    speed_m_s: float = 0.2
    distance_m: float = 0.3

    needs = frozenset({Role.DRIVE, Role.CAMERA, Role.RANGE})
    turns_on_spot = True
    milestones = ("seen", "near")

    def __post_init__(self) -> None:
        self._detector = ColourDetector("green")

    def run(self, robot: Robot) -> Routine[Status]:
        yield from until(lambda: self._find(robot), self._spin(robot))
        self.state = "seen"
        yield from until(lambda: robot.range.read().distance < self.distance_m, self._approach(robot))
        self.state = "near"
        yield from wait(robot, 0.5)
        return Status.SUCCESS

    def verify(self, truth: Truth) -> bool:
        return truth.is_at_rest and truth.sees_target and truth.contacts == 0

    def _find(self, robot: Robot) -> list[Blob]:
        return self._detector.find(robot.camera.read().image, robot.camera.intrinsics)

    def _spin(self, robot: Robot) -> Routine[None]:
        while True:
            robot.drive.set_velocity(0.0, 0.8)
            yield

    def _approach(self, robot: Robot) -> Routine[None]:
        while True:
            blobs = self._find(robot)
            bearing = blobs[0].bearing if blobs else 0.0
            robot.drive.set_velocity(self.speed_m_s, 2 * bearing)
            yield
