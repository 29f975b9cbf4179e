"""Drive a robot in an existing scene of a simulator that runs as a server."""

from robotcore.simulation.remote_scene.bindings import SceneBinding, inspect_scene, read_bindings
from robotcore.simulation.remote_scene.interface import (
    CameraOptics,
    ObjectKind,
    Point,
    RawPicture,
    Scene,
    SceneObject,
    State,
    compute_horizontal_fov,
)
from robotcore.simulation.remote_scene.scene_kinds import (
    list_scene_devices,
    require_scene_devices,
    warn_of_missing_kinds,
)
from robotcore.simulation.remote_scene.session import SceneOptions, SimulationControl, keep_running, open_in_scene

__all__ = [
    "CameraOptics",
    "ObjectKind",
    "Point",
    "RawPicture",
    "Scene",
    "SceneBinding",
    "SceneObject",
    "SceneOptions",
    "SimulationControl",
    "State",
    "compute_horizontal_fov",
    "inspect_scene",
    "keep_running",
    "list_scene_devices",
    "open_in_scene",
    "read_bindings",
    "require_scene_devices",
    "warn_of_missing_kinds",
]
