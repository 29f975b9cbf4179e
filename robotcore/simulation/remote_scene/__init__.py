"""Somebody's scene in a simulator that is a server: objects by path, and devices over them."""

from robotcore.simulation.remote_scene.joining import join
from robotcore.simulation.remote_scene.looking import look
from robotcore.simulation.remote_scene.port import Kind, Lens, Point, RawPicture, Scene, SceneObject, State
from robotcore.simulation.remote_scene.section import Placed, places
from robotcore.simulation.remote_scene.simulating import Whose, running

__all__ = [
    "Kind",
    "Lens",
    "Placed",
    "Point",
    "RawPicture",
    "Scene",
    "SceneObject",
    "State",
    "Whose",
    "join",
    "look",
    "places",
    "running",
]
