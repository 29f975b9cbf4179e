"""Search for a green ball, drive to it round whatever stands in the way, and stop in front of it."""

from __future__ import annotations

from dataclasses import dataclass

from robotcore import Behaviour, Pose, Positive, Robot, Role, Status, Stopping, Truth, Twist
from robotcore.autonomy.navigation import BallTracker, Navigator, Target
from robotcore.autonomy.vision import Blob

STANDING = Twist(0.0, 0.0)
CENTRED_RAD = 0.1
"""The ball is straight ahead: not farther aside than this."""

NEAR_M, TOO_NEAR_M = 0.02, 0.06
"""The robot is there: not farther before the place to stand than the one, not farther past it than the other."""

ECHO_M = 0.1
"""The ball is still there: its echo is not farther than this from where it should be."""

CONFIRM_S = 0.15
"""What looks like the ball for one picture may be a glint; three at 20 Hz are not."""

PATIENCE_S = 0.5
"""How long the ball may be out of sight before it is lost, and how long the robot stands before it has arrived."""


@dataclass
class GreenSearch(Behaviour):
    """Looks round, explores while nothing is seen, approaches what is, and stops in front of it."""

    hue: str = "green"
    speed_m_s: Positive = 0.25
    turn_rad_s: Positive = 1.5
    stop_distance_m: Positive = 0.28
    ball_radius_m: Positive = 0.10

    needs = frozenset({Role.DRIVE, Role.CAMERA, Role.RANGE})
    wants = frozenset({Role.DISPLAY})
    milestones = ("search", "seen", "approach", "arrived")

    def __post_init__(self) -> None:
        self._ball = BallTracker(self.hue, self.ball_radius_m)
        self._way = Navigator(self.speed_m_s, self.turn_rad_s)
        self._pose = Pose(0.0, 0.0, 0.0)
        self._now = 0.0
        self._begin_search()

    @property
    def stopping(self) -> Stopping:
        return Stopping(self.stop_distance_m, self.speed_m_s)

    def verify(self, truth: Truth) -> bool:
        """At rest, 0.15 to 0.40 m in front of the ball, which is in view."""
        distance = truth.distance_to_target
        is_near = distance is not None and 0.15 <= distance <= 0.40
        return is_near and truth.is_at_rest and truth.sees_target

    def step(self, robot: Robot) -> Status:
        self._pose, self._now = robot.drive.pose, robot.clock.now()
        self._way.observe(robot, self._pose)
        blob = self._ball.look(robot, self._pose)
        act = {
            "search": self._search,
            "explore": self._explore,
            "seen": self._confirm,
            "approach": self._approach,
            "avoid": self._avoid,
            "survey": self._survey,
            "arrived": self._rest,
        }[self.state]
        robot.drive.set_velocity(*act(robot, blob))
        is_done = self.state == "arrived" and self._here_for > PATIENCE_S
        return Status.SUCCESS if is_done else Status.RUNNING

    def _search(self, robot: Robot, blob: Blob | None) -> Twist:
        """Look at all that can be seen from here; then go where most can be seen that was not."""
        if self._ball.is_in_sight:
            return self._enter("seen")
        if twist := self._way.look(self._pose):
            return twist
        if self._way.plan_to_view(self._pose):
            return self._enter("explore")
        self._way.forget(self._pose)
        return self._begin_search()

    def _explore(self, robot: Robot, blob: Blob | None) -> Twist:
        """Go there, with open eyes."""
        if self._ball.is_in_sight:
            return self._enter("seen")
        return self._way.follow(self._pose) or self._begin_search()

    def _confirm(self, robot: Robot, blob: Blob | None) -> Twist:
        """Turn to where the ball should be until it has proved to be there; go and look where something hides it."""
        target = self._target(robot)
        bearing = blob.bearing if blob else target.bearing(self._pose)
        if abs(bearing) > CENTRED_RAD or self._here_for < CONFIRM_S:
            return self._way.turn_to(bearing)
        if blob:
            return self._enter("approach")
        if self._ball.lost_for < PATIENCE_S:
            return STANDING
        return self._give_up() if self._way.is_known_straight(self._pose, target) else self._go_round(target)

    def _approach(self, robot: Robot, blob: Blob | None) -> Twist:
        """Drive straight at the ball; go round what comes between."""
        target = self._target(robot)
        if self._ball.lost_for > PATIENCE_S:
            return self._enter("seen")
        if not self._way.is_straight(self._pose, target):
            return self._go_round(target)
        is_there = -TOO_NEAR_M < target.gap(self._pose) < NEAR_M
        if blob and is_there and abs(target.bearing(self._pose)) < CENTRED_RAD:
            return self._enter("arrived")
        return self._way.drive_at(self._pose, target) or self._go_round(target)

    def _avoid(self, robot: Robot, blob: Blob | None) -> Twist:
        """Follow the way round what is between, as far as it is known; look closer where it goes on."""
        if twist := self._way.follow(self._pose):
            return twist
        if not self._way.is_at_frontier:
            return self._enter("seen")
        self._way.survey_ahead(self._pose)
        return self._enter("survey")

    def _survey(self, robot: Robot, blob: Blob | None) -> Twist:
        """Turn to and fro to learn what stands here; then plan again."""
        return self._way.survey(self._pose) or self._go_round(self._target(robot))

    def _rest(self, robot: Robot, blob: Blob | None) -> Twist:
        """Stand, as long as the ball is in view and its echo is where it should be."""
        is_there = abs(robot.range.read().distance - self.stop_distance_m) < ECHO_M
        return STANDING if blob and is_there else self._begin_search()

    def _go_round(self, target: Target) -> Twist:
        """Plan a way round; where none is known, look closer from here, then from elsewhere; or begin anew."""
        if self._way.plan_to(self._pose, target):
            return self._enter("avoid")
        if self._way.survey_more(self._pose):
            return self._enter("survey")
        if self._way.plan_to_view(self._pose):
            return self._enter("avoid")
        self._way.forget(self._pose)
        return self._give_up()

    def _give_up(self) -> Twist:
        """Search again: the ball does not show where it should be, or nothing leads there."""
        self._ball.forget()
        return self._begin_search()

    def _begin_search(self) -> Twist:
        self._way.begin_look(self._pose)
        return self._enter("search")

    def _enter(self, state: str) -> Twist:
        """Begin a state, standing."""
        self.state = state
        self._entered_at = self._now
        return STANDING

    @property
    def _here_for(self) -> float:
        """How long the state has lasted, in seconds."""
        return self._now - self._entered_at

    def _target(self, robot: Robot) -> Target:
        """Return the ball, and how far from it the axle is when the robot stands where it means to."""
        assert self._ball.place, "only search and explore go on before the ball is seen"
        return Target(*self._ball.place, robot.range.mount.x + self.stop_distance_m + self.ball_radius_m)


if __name__ == "__main__":
    from robotcore.cli.main import run_app

    run_app("green-search")
