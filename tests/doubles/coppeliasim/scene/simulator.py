"""The simulator without a protocol: its objects, time, stepping clients, and sensors."""

from __future__ import annotations

import threading
from collections.abc import Hashable
from dataclasses import dataclass, field

from tests.doubles.coppeliasim.scene.graph import Graph
from tests.doubles.coppeliasim.scene.objects import Depths, Node, Pixels, ProximitySensor, SceneError, VisionSensor
from tests.doubles.coppeliasim.scene.outlines import Contact
from tests.doubles.coppeliasim.scene.poses import Vector
from tests.doubles.coppeliasim.scene.rays import Detection
from tests.doubles.coppeliasim.scene.rendering import BlankPicture
from tests.doubles.coppeliasim.scene.states import State, States, Stepping
from tests.doubles.coppeliasim.scene.world import InitialState, SceneLight, World, count_physics_steps

TIME_STEP_S = 0.05
PHYSICS_STEP_S = 0.005
SUMMARY_PX = 24


@dataclass(frozen=True)
class Ticket:
    """A client's request for a step.

    The step has ended if more than ``step`` steps were simulated. It is void if the simulation was stopped.
    """

    step: int
    is_void: bool


@dataclass
class Simulator:
    """A scene and its simulation. Hold ``lock`` during each use.

    ``can_detect``: the maker's plug-in for proximity sensors, collisions and distances is present.
    """

    graph: Graph = field(default_factory=Graph)
    look: SceneLight = field(default_factory=SceneLight)
    can_detect: bool = True
    time_step: float = TIME_STEP_S
    physics_step: float = PHYSICS_STEP_S

    def __post_init__(self) -> None:
        self.lock = threading.RLock()
        self.changed = threading.Condition(self.lock)
        self.stepping = Stepping()
        self.time = 0.0
        self.steps = 0
        self._states = States()
        self._initial: InitialState | None = None
        self._world = World(self.graph, self.look)

    @property
    def state(self) -> State:
        return self._states.state

    def start(self) -> None:
        """Start or resume the simulation."""
        if self.state is State.STOPPED:
            self.time = 0.0
            self._initial = InitialState(self.graph)
            for sensor in self.graph.all_of(VisionSensor):
                sensor.has_result = False
            self._world.begin(self.time_step / self._substeps)
        self._states.start()
        self.changed.notify_all()

    def pause(self) -> None:
        self._states.pause()
        self.changed.notify_all()

    def stop(self) -> None:
        """Request a stop, which takes a few steps; no client steps from now on."""
        self.stepping.reset()
        self._states.stop()
        self.changed.notify_all()

    def clear_scene(self) -> None:
        """Remove all objects of the scene, and restart the handles."""
        self.graph.clear()

    def hold(self, client: Hashable) -> int:
        """Raise a client's stepping level, and return the previous one. Time then waits for this client's requests."""
        return self.stepping.raise_level(client)

    def release(self, client: Hashable) -> int:
        """Lower a client's stepping level, and return the previous one.

        At level 0, time does not wait for this client.
        """
        self.changed.notify_all()
        return self.stepping.lower_level(client)

    def leave(self, client: Hashable) -> None:
        """Remove a client. Time then does not wait for it."""
        self.stepping.remove(client)
        self.changed.notify_all()

    def step(self, client: Hashable) -> Ticket:
        """Request a step for a client. If no other client holds time, the step is performed at once."""
        ticket = Ticket(self.steps, not self.state.is_advancing)
        if self.stepping.level(client) and self.state.is_advancing:
            self.stepping.request_step(client)
            if not self.stepping.is_held:
                self.advance()
        return ticket

    def is_done(self, ticket: Ticket) -> bool:
        """Return whether a requested step has ended or is void."""
        return ticket.is_void or self.steps > ticket.step or not self.state.is_advancing

    def advance(self) -> None:
        """Simulate one step, even if clients hold time."""
        self.time += self.time_step
        self._world.advance(self._substeps)
        self._render_sensors()
        self.steps += 1
        self.stepping.finish_step()
        if self._states.next() is State.STOPPED:
            self._restore_scene()
        self.changed.notify_all()

    def set_time_step(self, step: float) -> bool:
        """Set the time step, at least 0.1 ms. Return False unless the simulation is stopped."""
        if self.state is not State.STOPPED:
            return False
        self.time_step = max(step, 1e-4) if step == step else step  # noqa: PLR0124  the server stores NaN
        return True

    def set_physics_step(self, step: float) -> bool:
        """Set the physics step in seconds. Return False unless the simulation is stopped."""
        if self.state is not State.STOPPED or not step > 0:
            return False
        self.physics_step = step
        return True

    def picture(self, sensor: VisionSensor) -> Pixels:
        """Return the last rendered picture of a sensor; black if there is none."""
        return (sensor.sight or BlankPicture.of(sensor)).picture

    def depth(self, sensor: VisionSensor) -> Depths:
        """Return the last rendered depths of a sensor in metres. Before the first rendering, all depths are ``far``."""
        return (sensor.sight or BlankPicture.of(sensor)).depths

    def summary(self, sensor: VisionSensor) -> tuple[Pixels, Depths]:
        """Return the pixels and depths from which a sensor's result is computed.

        For a large picture they are a subset.
        """
        nth = max(1, max(sensor.width, sensor.height) // SUMMARY_PX)
        sight = sensor.sight or BlankPicture.of(sensor)
        return sight.picture[::nth, ::nth], sight.depths_of_every(nth)

    def show(self, sensor: VisionSensor, picture: Pixels) -> None:
        """Show a picture on a sensor, (height, width, 3), in the layout of `picture`."""
        sensor.sight = BlankPicture.of(sensor, picture)
        sensor.has_result = True

    def handle(self, sensor: VisionSensor) -> None:
        """Render the picture of a sensor with explicit handling now."""
        if not sensor.explicit:
            raise SceneError("object not tagged for explicit handling.")
        self._render(sensor)

    def detection(self, sensor: ProximitySensor) -> Detection | None:
        """Return the detection of a sensor; None if it detects nothing, or without the plug-in."""
        return self._world.detection(sensor) if self.can_detect else None

    def velocity(self, node: Node) -> tuple[Vector, Vector]:
        """Return an object's linear and angular velocity in the world, in m/s and rad/s."""
        return self._world.velocity(node)

    def contacts(self) -> list[Contact]:
        """Return the contacts in the last step. While the simulation is stopped, there are none."""
        return [] if self.state is State.STOPPED else self._world.contacts

    @property
    def _substeps(self) -> int:
        return count_physics_steps(self.time_step, self.physics_step)

    def _render_sensors(self) -> None:
        for sensor in self.graph.all_of(VisionSensor):
            if not sensor.explicit:
                self._render(sensor)

    def _render(self, sensor: VisionSensor) -> None:
        if not sensor.takes_external_pictures:
            sensor.sight = self._world.render(sensor)
        sensor.has_result = True

    def _restore_scene(self) -> None:
        self._world.end()
        if self._initial:
            self._initial.restore(self.graph)
