"""The plan of a run: its request with resolved names and checked values."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import inf

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
from robotcore.runtime.behaviour import Behaviour, require_declarations
from robotcore.runtime.faults import PlannedFault, plan_faults
from robotcore.runtime.needs import choose_devices, require_turn_on_spot
from robotcore.runtime.operator_input import OPERATOR, add_operator
from robotcore.runtime.request import RunRequest as RunRequest  # noqa: PLC0414  the modules above import it from here
from robotcore.runtime.settings import configure, list_changes
from robotcore.runtime.success_verification import load_judge
from robotcore.safety.range_guard import compute_stopping_distance
from robotcore.safety.real_time import require_real_time

__all__ = ["Plan"]

DEFAULT_WORLD = "arena"
MIN_RATE_HZ, MAX_RATE_HZ = 1.0, 1000.0


@dataclass(frozen=True)
class Plan:
    """A request with resolved names and checked values.

    Its request names the app, also if the user's request has a class or an instance. It has the settings of
    an instance.

    >>> from robotcore import RunRequest
    >>> plan = Plan.resolve(RunRequest("green-search", seed=7))
    >>> plan
    Plan(app='green-search', backend='kinematic', robot='rover', world='arena', seed=7)
    """

    request: RunRequest
    behaviour: Behaviour
    """The app, with its settings."""
    judge: Behaviour
    """The app whose ``verify`` decides whether the run was a success."""
    backend: Backend
    description: RobotDescription
    world: WorldDescription | None
    """The world with the layout that was drawn from the seed. None if the run has no world."""
    setup: Setup
    """The arguments with which the backend opens the robot."""
    drawn: DrawnValues = field(default_factory=dict)
    """The light, colours and imperfections of the world by name. The seed or the world's file determines them."""
    faults: tuple[PlannedFault, ...] = ()
    notes: tuple[str, ...] = ()
    """Notes of the backend, and a note if the simulator did not build its scene from the world."""

    def __repr__(self) -> str:
        world = self.world.name if self.world else None
        names = f"app={self.request.app_reference!r}, backend={self.backend.name!r}, robot={self.description.name!r}"
        return f"Plan({names}, world={world!r}, seed={self.request.seed})"

    @property
    def conditions(self) -> Conditions:
        """The imperfections of the simulated devices. A real robot has no simulated imperfections."""
        builds = self.backend.builds_world(self.description)
        return self.world.conditions if self.world and builds else Conditions()

    @classmethod
    def resolve(cls, request: RunRequest) -> Plan:
        """Resolve the names of a request and check its values. No device is opened.

        Raises UsageError if a part is unknown or does not fit, and BackendMissingError if a library is missing.
        """
        if not isinstance(request, RunRequest):
            name = getattr(request, "__name__", repr(request))
            raise UsageError(f"run needs a RunRequest. Write run(RunRequest({name}))", kind="not-a-request")
        require_rate(request.rate_hz)
        if not 0 < request.timeout_s < inf:
            text = f"--timeout is {request.timeout_s}; it must be a positive number"
            raise UsageError(text, kind="not-positive", option="--timeout")
        backend = load_backend(request.backend)
        judge = None if request.judge is None else load_judge(request.judge)
        behaviour = _make_behaviour(request)  # last: it changes where imports search
        require_declarations(behaviour)
        settings = list_changes(request.app) if isinstance(request.app, Behaviour) else request.settings
        request = replace(request, app=request.app_reference, settings=settings)
        description = backend.load_robot(request.robot, request.options)
        if request.ideal:
            _require_simulator(backend)
            description = description.idealise()
        devices = choose_devices(backend, description, request.options, behaviour.needs, behaviour.wants)
        opened = devices
        if request.has_operator:
            if description.first_of(OPERATOR.kind):  # in a recording, so the replay opens it
                devices |= {OPERATOR.name}
            description, opened = add_operator(description), devices | {OPERATOR.name}
        faults = plan_faults(request.faults, description, opened)
        _require_room_to_stop(behaviour, description)
        if behaviour.turns_on_spot:
            require_turn_on_spot(description)
        _require_window(request, backend)
        if request.has_real_time_priority:
            require_real_time()
            require_no_lockstep(backend)
        builds_world = backend.builds_world(description)
        _require_randomisable(request, backend, builds_world=builds_world)
        world, drawn = _load_world(request, description, builds_world=builds_world)
        backend.require_installed()
        robot = description.with_conditions(world.conditions) if world and builds_world else description
        setup = Setup(
            robot, world, devices, request.rate_hz, request.seed or 0, request.gui, request.options, request.ideal
        )
        if request.has_separate_motors:
            description = description.model_copy(update={"drive": None})
        judge = behaviour if judge is None else judge
        notes = list(backend.notes(setup))
        if world and not builds_world and Capability.POSE in backend.capabilities:
            notes.append(
                "the scene is used as it is. The verification and the distance to targets use the positions in "
                f"{world.name!r}; they must match the scene"
            )
        return cls(request, behaviour, judge, backend, description, world, setup, drawn, faults, tuple(notes))


def draw_conditions(request: RunRequest) -> DrawnValues:
    """Return the values that `Plan.drawn` has for a request, without loading the app."""
    description = load_robot(request.robot)
    builds_world = load_backend(request.backend).builds_world(description)
    _, drawn = _load_world(request, description, builds_world=builds_world)
    return drawn


def require_rate(rate_hz: float) -> None:
    """Raise UsageError if a loop cannot run at ``rate_hz`` ticks a second."""
    if not MIN_RATE_HZ <= rate_hz <= MAX_RATE_HZ:
        raise UsageError(
            f"--rate is {rate_hz} Hz; it must be from {MIN_RATE_HZ:g} to {MAX_RATE_HZ:g}",
            kind="rate-out-of-range",
            rate_hz=rate_hz,
        )


def _make_behaviour(request: RunRequest) -> Behaviour:
    app = request.app
    if not isinstance(app, Behaviour):
        return configure(app if isinstance(app, type) else load_app(app), request.settings)
    if request.settings:
        raise UsageError(
            f"the settings {', '.join(request.settings)} have no effect, because the app is an instance of "
            f"{type(app).__name__}. Create the instance with its settings, or name the class",
            kind="settings-without-effect",
        )
    return app


def _require_room_to_stop(behaviour: Behaviour, description: RobotDescription) -> None:
    if (stopping := behaviour.stopping) is None or not description.sensors_ahead:
        return
    stop_distance, deceleration = description.guard_distance_m, description.safety.deceleration_m_s2
    guard = compute_stopping_distance(stopping.speed, stop_distance, deceleration)
    if stopping.distance <= guard:
        raise UsageError(
            f"the app stops {stopping.distance:g} m in front of an obstacle, but at {stopping.speed:g} m/s the range "
            f"guard of {description.name!r} stops the robot at {guard:.2f} m. Let the app stop farther away or drive "
            "slower (--set), or lower safety.stop_distance_m in the robot's description",
            kind="stops-behind-guard",
            distance_m=stopping.distance,
            speed_m_s=stopping.speed,
            guard_m=guard,
        )


def _require_window(request: RunRequest, backend: Backend) -> None:
    if request.gui and not backend.has_gui:
        others = [other.name for other in loadable_backends() if other.has_gui]
        raise UsageError(
            f"the backend {backend.name!r} cannot open a window. Use --picture FILE.png in place of --gui, "
            f"or use --backend {' or '.join(others)}",
            kind="no-window",
            backends=others,
        )


def require_no_lockstep(backend: Backend) -> None:
    """Raise UsageError if real-time priority has no effect on a backend."""
    if Capability.LOCKSTEP in backend.capabilities:
        raise UsageError(
            f"--rt has no effect on the backend {backend.name!r}, because its time waits for each tick. Leave --rt "
            "out, or run on a real robot",
            kind="rt-without-real-time",
            backend=backend.name,
        )


def _require_simulator(backend: Backend) -> None:
    if Capability.POSE not in backend.capabilities:
        raise UsageError(
            f"--ideal needs simulated devices, and the backend {backend.name!r} does not simulate. Leave --ideal out, "
            "or use --backend kinematic",
            kind="nothing-to-idealise",
        )


def _require_randomisable(request: RunRequest, backend: Backend, *, builds_world: bool) -> None:
    if request.randomise and not builds_world:
        raise UsageError(
            f"--randomise needs a simulated world, and the backend {backend.name!r} builds none for this robot. "
            "Leave --randomise out, or use --backend kinematic",
            kind="nothing-to-randomise",
        )
    if request.randomise and request.seed is None:
        raise UsageError("--randomise needs a seed. Add one, for example --seed 7", kind="seed-missing")


def _load_world(
    request: RunRequest, description: RobotDescription, *, builds_world: bool
) -> tuple[WorldDescription | None, DrawnValues]:
    """Return the world and the values of `Plan.drawn`. The world is None if the run has none."""
    if not (request.world or builds_world):
        return None, {}
    world = load_world(request.world or DEFAULT_WORLD)
    drawn: DrawnValues = {}
    if request.seed is None:
        require_start(world, description)
    else:
        world = draw_world(world, description, request.seed)
        drawn = describe_light(world.light)
        if request.randomise:
            world, more = randomise(world, request.seed)
            drawn |= more
        drawn |= describe_picture(drawn)
    fixed = describe_conditions(world.conditions) if builds_world else {}
    return world, {**drawn, **fixed}
