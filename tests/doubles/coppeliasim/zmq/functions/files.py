"""Scenes from files: the double reads none, and begins anew with the default scene instead."""

from __future__ import annotations

from tests.doubles.coppeliasim.scene import SceneError
from tests.doubles.coppeliasim.scene.states import State
from tests.doubles.coppeliasim.scenes import fill_default_scene
from tests.doubles.coppeliasim.zmq.functions.registry import function
from tests.doubles.coppeliasim.zmq.session import Session

DEFAULT_SCENES = ("scene.ttt", "dfltscn.ttt", "")
"""What is loaded as the default scene: its file as recorded, the simulator's own, and no name."""


@function("loadScene")
def load_scene(session: Session, path: str) -> int:
    if session.simulator.state is not State.STOPPED:
        raise SceneError("simulation is not stopped.")
    if path not in DEFAULT_SCENES:
        raise SceneError(f"the double reads no scene files; it has the default scene as {DEFAULT_SCENES[0]}.")
    fill_default_scene(session.simulator)
    return 1


@function("closeScene")
def close_scene(session: Session) -> int:
    return load_scene(session, "")
