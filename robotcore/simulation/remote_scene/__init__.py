"""Drives a robot in a scene of a simulator that is a server. The robot's devices are bound to the scene's objects."""

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
from robotcore.simulation.remote_scene.session import Owner, keep_running, open_in_scene

__all__ = [
    "CameraOptics",
    "ObjectKind",
    "Owner",
    "Point",
    "RawPicture",
    "Scene",
    "SceneBinding",
    "SceneObject",
    "State",
    "compute_horizontal_fov",
    "inspect_scene",
    "keep_running",
    "open_in_scene",
    "read_bindings",
]
