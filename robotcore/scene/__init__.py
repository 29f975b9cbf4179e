"""Somebody's scene in a simulator that is a server: objects by path, and devices over them."""

from robotcore.scene.joining import join
from robotcore.scene.looking import look
from robotcore.scene.port import Kind, Lens, Point, RawPicture, Scene, SceneObject, State
from robotcore.scene.section import Placed, places
from robotcore.scene.simulating import Whose, running

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
