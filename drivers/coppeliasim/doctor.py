"""Diagnose the CoppeliaSim that runs on this computer."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing

from drivers.coppeliasim.builder import SceneBuilder
from drivers.coppeliasim.connection import LOADING_S, Address, Connection
from drivers.coppeliasim.scene import CoppeliaSimScene
from drivers.coppeliasim.sensors import proximity_works
from robotcore.errors import BackendError
from robotcore.hal.finding import Finding
from robotcore.simulation.remote_scene import State

_NAME = "coppeliasim"
_ENGINES = {0: "Bullet", 1: "ODE", 2: "Vortex", 3: "Newton", 4: "MuJoCo", 5: "Drake"}


def diagnose(address: Address) -> Iterator[Finding]:
    """Yield which CoppeliaSim answers, what computes its physics, and whether it has proximity sensors."""
    try:
        with closing(CoppeliaSimScene(Connection.open(address, LOADING_S))) as scene:
            yield from _diagnose_scene(scene)
    except BackendError as error:
        said, _, remedy = str(error).removeprefix(f"{_NAME}: ").partition(". ")
        only = f". These are options of robotcore run and check: the doctor looks at {address} alone"
        yield Finding.warning(_NAME, said, remedy + only * ("--port" in remedy))


def _diagnose_scene(scene: CoppeliaSimScene) -> Iterator[Finding]:
    connection = scene.connection
    version = connection.call_as(int, "getInt32Param", connection.constant("intparam_program_full_version"))
    yield Finding.ok(_NAME, f"version {_version(version)} answers at {connection.address}")
    engine = connection.call_as(int, "getInt32Param", connection.constant("intparam_dynamic_engine"))
    yield Finding.ok("physics", f"by {_ENGINES.get(engine, engine)}")
    if scene.state() is not State.STOPPED:
        yield Finding.warning("proximity sensors", "not tried: a simulation is under way", "Stop it, and look again")
    elif proximity_works(SceneBuilder(connection), scene.detect):
        yield Finding.ok("proximity sensors", "detect what is in front of them")
    else:
        yield Finding.warning(
            "proximity sensors",
            "detect nothing: robots that are built measure by pictures of depth, others cannot be opened",
            "Install a CoppeliaSim with its plug-in for them, as the maker's downloads are",
        )


def _version(number: int) -> str:
    """Return 4.10.0 for 4100000: two digits each for the second, third and the revision."""
    return f"{number // 1000000}.{number // 10000 % 100}.{number // 100 % 100}"
