"""The simulator without a protocol: its objects, time, stepping clients, and sensors."""

from __future__ import annotations

import threading
from collections.abc import Hashable
from dataclasses import dataclass, field
from enum import IntEnum

from robotcore.description import Light
from tests.doubles.coppeliasim.scene.graph import Graph
from tests.doubles.coppeliasim.scene.objects import (
    Depths,
    Joint,
    Node,
    Pixels,
    ProximitySensor,
    SceneError,
    VisionSensor,
)
from tests.doubles.coppeliasim.scene.poses import Vector
from tests.doubles.coppeliasim.scene.rendering import DEFAULT_LIGHT, EVERYTHING, Detection, Scenery, View
from tests.doubles.coppeliasim.scene.rover import Rover, find_drives

TIME_STEP_S = 0.05
PHYSICS_STEP_S = 0.005
STANDING: tuple[Vector, Vector] = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


class State(IntEnum):
    """The values of the API's ``simulation_...``."""

    STOPPED = 0
    PAUSED = 8
    FIRST_AFTER_STOP = 16
    RUNNING = 17
    LAST_BEFORE_PAUSE = 19
    FIRST_AFTER_PAUSE = 20
    ABOUT_TO_STOP = 21
    LAST_BEFORE_STOP = 22

    @property
    def is_advancing(self) -> bool:
        return self >= State.FIRST_AFTER_STOP


AFTER_START = {State.STOPPED: State.FIRST_AFTER_STOP, State.PAUSED: State.FIRST_AFTER_PAUSE}
AFTER_STEP = {
    State.LAST_BEFORE_PAUSE: State.PAUSED,
    State.ABOUT_TO_STOP: State.LAST_BEFORE_STOP,
    State.LAST_BEFORE_STOP: State.STOPPED,
}
"""The state that follows another one after a step. After the other states, it depends on the clients' requests."""


@dataclass(frozen=True)
class Ticket:
    """A client's request for a step.

    The step has ended if more than ``step`` steps were simulated. It is void if the simulation was stopped.
    """

    step: int
    is_void: bool


@dataclass
class Simulator:
    """A scene and its simulation. Hold ``lock`` during each use. The lock is reentrant.

    can_detect: the maker's plug-in for proximity sensors is present.
    changed: a condition on the lock, which is notified after each step and each change of the state.
    steps: the number of simulated steps.

    A stepping client has a level above 0. Time waits until all of them have requested the next step.
    """

    graph: Graph = field(default_factory=Graph)
    light: Light = DEFAULT_LIGHT
    can_detect: bool = True
    time_step: float = TIME_STEP_S

    def __post_init__(self) -> None:
        self.lock = threading.RLock()
        self.changed = threading.Condition(self.lock)
        self.time = 0.0
        self.steps = 0
        self.state = State.STOPPED
        self._request: State | None = None
        self._levels: dict[Hashable, int] = {}
        self._step_requests: set[Hashable] = set()
        self._initial: InitialState | None = None
        self._rovers: list[Rover] = []
        self._sceneries: dict[int, Scenery] = {}
        self._revision = -1

    def start(self) -> None:
        """Start or resume the simulation. This has no effect while it runs."""
        if self.state is State.STOPPED:
            self.time, self._request = 0.0, None
            self._initial = InitialState(self.graph)
            step = self.time_step / self._substeps
            self._rovers = [Rover(drive, self.graph, self._scenery(), step) for drive in find_drives(self.graph)]
        self.state = AFTER_START.get(self.state, self.state)
        self.changed.notify_all()

    def pause(self) -> None:
        """Request a pause, which begins after two steps."""
        if self.state.is_advancing:
            self._request = State.LAST_BEFORE_PAUSE
        self.changed.notify_all()

    def stop(self) -> None:
        """Request a stop, which takes a few steps; no client steps from now on."""
        self._levels.clear()
        self._step_requests.clear()
        if self.state is State.PAUSED:
            self.state = State.ABOUT_TO_STOP
        elif self.state.is_advancing and self.state not in AFTER_STEP:
            self._request = State.ABOUT_TO_STOP
        self.changed.notify_all()

    @property
    def is_stepped(self) -> bool:
        """Whether a client steps the simulation."""
        return bool(self._levels)

    @property
    def is_held(self) -> bool:
        """Whether time must wait, because a stepping client has not requested the next step."""
        return not self._levels.keys() <= self._step_requests

    def level(self, client: Hashable) -> int:
        """Return a client's stepping level."""
        return self._levels.get(client, 0)

    def hold(self, client: Hashable) -> int:
        """Raise a client's stepping level, and return the previous one. Time then waits for this client's requests."""
        before = self.level(client)
        self._levels[client] = before + 1
        return before

    def release(self, client: Hashable) -> int:
        """Lower a client's stepping level, and return the previous one.

        At level 0, time does not wait for this client.
        """
        before = self._levels.pop(client, 0)
        if before > 1:
            self._levels[client] = before - 1
        self.changed.notify_all()
        return before

    def leave(self, client: Hashable) -> None:
        """Remove a client. Time then does not wait for it."""
        self._levels.pop(client, None)
        self._step_requests.discard(client)
        self.changed.notify_all()

    def step(self, client: Hashable) -> Ticket:
        """Request a step for a client. If no other client holds time, the step is performed at once."""
        ticket = Ticket(self.steps, not self.state.is_advancing)
        if self.level(client) and self.state.is_advancing:
            self._step_requests.add(client)
            if not self.is_held:
                self.advance()
        return ticket

    def is_done(self, ticket: Ticket) -> bool:
        """Return whether a requested step has ended or is void."""
        return ticket.is_void or self.steps > ticket.step or not self.state.is_advancing

    def advance(self) -> None:
        """Simulate one step, even if clients hold time."""
        self.time += self.time_step
        for rover in self._rovers:
            rover.advance(self._substeps)
        for sensor in self.graph.all_of(VisionSensor):
            if not sensor.explicit:
                self._render(sensor)
        self.steps += 1
        self._step_requests.clear()
        following = AFTER_STEP.get(self.state)
        if following is None:
            following, self._request = self._request or State.RUNNING, None
        self.state = following
        if following is State.STOPPED:
            self._restore()
        self.changed.notify_all()

    def set_time_step(self, step: float) -> bool:
        """Set the time step, at least 0.1 ms. Return False unless the simulation is stopped."""
        if self.state is State.STOPPED:
            self.time_step = max(step, 1e-4)
        return self.state is State.STOPPED

    def picture(self, sensor: VisionSensor) -> Pixels:
        """Return the last rendered picture of a sensor; black if there is none."""
        return (sensor.view or View(sensor)).picture

    def depth(self, sensor: VisionSensor) -> Depths:
        """Return the last rendered depths of a sensor in metres. Before the first rendering, all depths are ``far``."""
        return (sensor.view or View(sensor)).depths

    def show(self, sensor: VisionSensor, picture: Pixels) -> None:
        """Show a picture on a sensor, (height, width, 3), in the layout of `picture`."""
        sensor.view = View(sensor)
        sensor.view.picture = picture

    def handle(self, sensor: VisionSensor) -> None:
        """Render the picture of a sensor with explicit handling now."""
        if not sensor.explicit:
            raise SceneError("object not tagged for explicit handling.")
        self._render(sensor)

    def detection(self, sensor: ProximitySensor) -> Detection | None:
        """Return the detection of a sensor; None if it detects nothing, or without the plug-in."""
        if not self.can_detect:
            return None
        return self._scenery(sensor.entity).detect(sensor, self.graph.pose(sensor))

    def velocity(self, node: Node) -> tuple[Vector, Vector]:
        """Return an object's linear and angular velocity in the world, in m/s and rad/s."""
        rover = next((rover for rover in self._rovers if node in self.graph.tree([rover.body])), None)
        return rover.velocity(self.graph.pose(node).position) if rover else STANDING

    def contacts(self) -> list[tuple[Node, Node]]:
        """Return the contacts of the robots' bodies with obstacles in the last step."""
        return [(rover.body, thing) for rover in self._rovers for thing in rover.touched]

    @property
    def _substeps(self) -> int:
        return max(1, round(self.time_step / PHYSICS_STEP_S))

    def _render(self, sensor: VisionSensor) -> None:
        if not sensor.takes_external_pictures:
            sensor.view = View(sensor, self.graph.pose(sensor), self._scenery(sensor.entity))

    def _scenery(self, entity: int = EVERYTHING) -> Scenery:
        """Return the present shapes without the robots, either all or those of a collection."""
        if self._revision != self.graph.revision:
            self._revision = self.graph.revision
            self._sceneries = {}
        if entity not in self._sceneries:
            robots = self.graph.tree([drive.body for drive in find_drives(self.graph)])
            self._sceneries[entity] = Scenery.of(self.graph, self.light, robots, entity)
        return self._sceneries[entity]

    def _restore(self) -> None:
        self._rovers = []
        if self._initial:
            self._initial.restore(self.graph)


class InitialState:
    """The initial poses and joints of a scene. `restore` removes later objects."""

    def __init__(self, graph: Graph) -> None:
        self._poses = {node: node.local for node in graph}
        self._joints = {joint: (joint.position, joint.target_velocity) for joint in graph.all_of(Joint)}

    def restore(self, graph: Graph) -> None:
        """Restore the scene."""
        for node in list(graph):
            if node not in self._poses:
                graph.remove(node)
        for node in graph:
            node.local = self._poses[node]
        for joint in graph.all_of(Joint):
            joint.position, joint.target_velocity = self._joints[joint]
        graph.revision += 1
