"""Somebody's scene in a simulator that is a server: objects by path, and devices over them."""

from robotcore.scene.port import Kind, Lens, Point, RawPicture, Scene, SceneObject, State

__all__ = ["Kind", "Lens", "Point", "RawPicture", "Scene", "SceneObject", "State"]
