"""What is to be run: every name found, every part checked, and all of it fitting together."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from robotcore.description import (
    Conditions,
    DrawnValues,
    RobotDescription,
    WorldDescription,
    describe_conditions,
    describe_light,
    describe_picture,
    draw_world,
    load_robot,
    load_world,
    randomise,
    require_start,
)
from robotcore.errors import UsageError
from robotcore.hal.backend import Backend, Capability, Setup, load_backend, loadable_backends
from robotcore.runtime.apps import load_app
from robotcore.runtime.behaviour import Behaviour
from robotcore.runtime.faults import PlannedFault, plan_faults
from robotcore.runtime.layers import needed_devices
from robotcore.runtime.settings import configure
from robotcore.runtime.verification import load_judge
from robotcore.safety import stopping_distance

DEFAULT_WORLD = "arena"
MIN_RATE_HZ, MAX_RATE_HZ = 1.0, 1000.0


@dataclass(frozen=True)
class RunRequest:
    """What to run, on what. Without a seed, a world stands as its file has it.

    ``randomise`` draws by the seed not only where things stand, but also how everything looks and works. ``judge`` is
    the app whose ``verify`` judges the end of the run; without one, the app's own does. ``faults`` are specs of what is
    to fail on purpose.
    """

    app: str
    backend: str = "kinematic"
    robot: str = "rover"
    world: str | None = None
    seed: int | None = None
    rate_hz: float = 20.0
    timeout_s: float = 120.0
    settings: Mapping[str, Any] = field(default_factory=dict)
    options: Mapping[str, Any] = field(default_factory=dict)
    gui: bool = False
    realtime: bool = False
    randomise: bool = False
    judge: str | None = None
    faults: tuple[str, ...] = ()


@dataclass(frozen=True)
class Plan:
    """A request with everything it names found, checked, and fitting together.

    ``drawn`` is what the seed made of the world's looks and conditions, by name, and which conditions the world's
    file fixes; ``notes`` are the backend's, and what is to be known of the world.
    """

    request: RunRequest
    behaviour: Behaviour
    judge: Behaviour
    backend: Backend
    description: RobotDescription
    world: WorldDescription | None
    setup: Setup
    drawn: DrawnValues = field(default_factory=dict)
    faults: tuple[PlannedFault, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def conditions(self) -> Conditions:
        """What the simulated devices are under; a real robot's are its own."""
        builds = self.backend.builds_world(self.description)
        return self.world.conditions if self.world and builds else Conditions()

    @classmethod
    def of(cls, request: RunRequest) -> Plan:
        """Find and check all that the request names; nothing is opened yet."""
        require_rate(request.rate_hz)
        _require_positive("--timeout", request.timeout_s)
        backend = load_backend(request.backend)
        judge = None if request.judge is None else load_judge(request.judge)
        behaviour = configure(load_app(request.app), request.settings)  # last: what it imports later is beside it
        description = backend.load_robot(request.robot, request.options)
        devices = needed_devices(description, behaviour.needs, behaviour.wants)
        devices |= backend.batteries(description, request.options)
        faults = plan_faults(request.faults, description, devices)
        _require_room_to_stop(behaviour, description)
        _require_window(request, backend)
        builds_world = backend.builds_world(description)
        _require_randomisable(request, backend, builds_world=builds_world)
        world, drawn = _world(request, description, builds_world=builds_world)
        backend.require_installed()
        robot = description.under(world.conditions) if world and builds_world else description
        setup = Setup(robot, world, devices, request.rate_hz, request.seed or 0, request.gui, request.options)
        judge = behaviour if judge is None else judge
        notes = (*backend.notes(setup), *_note_of_world(world, backend, builds_world=builds_world))
        return cls(request, behaviour, judge, backend, description, world, setup, drawn, faults, notes)


def drawn_for(request: RunRequest) -> DrawnValues:
    """Return what a plan of the request has as ``drawn``; no app is loaded for it."""
    description = load_robot(request.robot)
    builds_world = load_backend(request.backend).builds_world(description)
    _, drawn = _world(request, description, builds_world=builds_world)
    return drawn


def require_rate(rate_hz: float) -> None:
    """Raise UsageError for what is no rate for a loop."""
    if not MIN_RATE_HZ <= rate_hz <= MAX_RATE_HZ:
        raise UsageError(f"--rate is {rate_hz} Hz; it must be from {MIN_RATE_HZ:g} to {MAX_RATE_HZ:g}")


def _require_positive(what: str, value: float) -> None:
    if not 0 < value < float("inf"):
        raise UsageError(f"{what} is {value}; it must be a positive number")


def _require_room_to_stop(behaviour: Behaviour, description: RobotDescription) -> None:
    """Refuse an app that means to stop nearer than the range guard lets it."""
    if (stopping := behaviour.stopping) is None or not description.range_sensors_ahead:
        return
    safety = description.safety
    guard = stopping_distance(stopping.speed, safety.stop_distance_m, safety.deceleration_m_s2)
    if stopping.distance <= guard:
        raise UsageError(
            f"the app stops {stopping.distance:g} m in front of things, but at {stopping.speed:g} m/s the range "
            f"guard of {description.name!r} acts at {guard:.2f} m. Let the app stop farther away or drive slower "
            "(--set), or lower safety.stop_distance_m in the robot's description"
        )


def _require_window(request: RunRequest, backend: Backend) -> None:
    if request.gui and not backend.has_gui:
        others = [other.name for other in loadable_backends() if other.has_gui]
        raise UsageError(
            f"the backend {backend.name!r} opens no window. Leave --gui out and look at --picture FILE.png, "
            f"or take --backend {' or '.join(others)}"
        )


def _require_randomisable(request: RunRequest, backend: Backend, *, builds_world: bool) -> None:
    if request.randomise and not builds_world:
        raise UsageError(
            f"the backend {backend.name!r} makes no world for this robot, so there is nothing to randomise. "
            "Leave --randomise out, or take --backend kinematic"
        )
    if request.randomise and request.seed is None:
        raise UsageError("--randomise draws from the seed, and there is none. Name one, for example --seed 7")


def _world(
    request: RunRequest, description: RobotDescription, *, builds_world: bool
) -> tuple[WorldDescription | None, DrawnValues]:
    """Return the world, if there is to be one, and what is told of its looks and conditions."""
    if not (request.world or builds_world):
        return None, {}
    world = load_world(request.world or DEFAULT_WORLD)
    drawn: DrawnValues = {}
    if request.seed is None:
        require_start(world, description)
    else:
        world, drawn = _drawn(world, description, request.seed, is_randomised=request.randomise)
    fixed = describe_conditions(world.conditions) if builds_world else {}
    return world, {**drawn, **fixed}


def _note_of_world(world: WorldDescription | None, backend: Backend, *, builds_world: bool) -> Iterator[str]:
    """Yield what the end of a run is judged by, where the simulator knows where the robot is and made no world."""
    if world and not builds_world and Capability.POSE in backend.capabilities:
        yield (
            f"the scene is taken as it is; what is verified, and how far away targets are, is told by {world.name!r}: "
            "it holds where that is what the scene shows"
        )


def _drawn(
    world: WorldDescription, description: RobotDescription, seed: int, *, is_randomised: bool
) -> tuple[WorldDescription, DrawnValues]:
    """Return the world as the seed has it, and by name what was drawn."""
    world = draw_world(world, description, seed)
    drawn = describe_light(world.light)
    if is_randomised:
        world, more = randomise(world, seed)
        drawn |= more
    return world, {**drawn, **describe_picture(drawn)}
