"""The world in Bullet: a floor, prisms and balls, none of which moves."""

from __future__ import annotations

from enum import IntFlag
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2

from drivers.pybullet.bullet import Bullet
from robotcore.description import Ball, Floor, Texture, WorldDescription
from robotcore.description.meshes import Mesh, ball_mesh, ground_mesh, prism_mesh
from robotcore.description.world import Prism

GROUND_HALF_M = 200.0
"""The ground is drawn this far; its edge lies a pixel's fraction below the horizon."""

HULL_MARGIN_M = 1e-6
"""Bullet puts a margin around a hull, 1 mm if not told, which rays hit; with none, rays miss it."""


class Group(IntFlag):
    """Who collides with whom. Bullet's rays belong to group 1."""

    RAY = 1
    FLOOR = 64
    THING = 128
    BODY = 256
    WHEEL = 512


class Scene:
    """What stands in the world, and its light; ``things`` maps names, but for the floor's, to Bullet's numbers."""

    def __init__(self, bullet: Bullet, world: WorldDescription) -> None:
        self._bullet = bullet
        self._textures = Textures(bullet)
        self.light = world.light
        prisms = {prism.name: self._add_prism(prism) for prism in world.prisms}
        balls = {ball.name: self._add_ball(ball) for ball in world.targets}
        self.things = prisms | balls
        self._add_floor(world.floor)

    def _add_floor(self, floor: Floor) -> None:
        """Add the floor last: it is drawn last, and not where something stands in front of it."""
        bullet = self._bullet
        plane = bullet.createCollisionShape(bullet.GEOM_PLANE)
        body = self._add(plane, ground_mesh(GROUND_HALF_M, floor), floor.colour, (0.0, 0.0, 0.0))
        self._cover(body, floor.texture)
        bullet.changeDynamics(body, -1, lateralFriction=1.0)
        bullet.setCollisionFilterGroupMask(body, -1, Group.FLOOR, Group.BODY | Group.WHEEL)

    def _add_prism(self, prism: Prism) -> int:
        bullet = self._bullet
        mesh = prism_mesh(prism)
        hull = bullet.createCollisionShape(bullet.GEOM_MESH, vertices=mesh.vertices)
        body = self._add(hull, mesh, prism.colour, (prism.x_m, prism.y_m, 0.0), prism.yaw_rad)
        bullet.changeDynamics(body, -1, collisionMargin=HULL_MARGIN_M)
        self._cover(body, prism.texture)
        return self._as_thing(body)

    def _add_ball(self, ball: Ball) -> int:
        bullet = self._bullet
        sphere = bullet.createCollisionShape(bullet.GEOM_SPHERE, radius=ball.radius_m)
        place = (ball.x_m, ball.y_m, ball.radius_m)
        return self._as_thing(self._add(sphere, ball_mesh(ball.radius_m), ball.colour, place))

    def _cover(self, body: int, texture: Texture | None) -> None:
        if texture:
            self._bullet.changeVisualShape(body, -1, textureUniqueId=self._textures.number_of(texture))

    def _as_thing(self, body: int) -> int:
        self._bullet.setCollisionFilterGroupMask(body, -1, Group.THING, Group.BODY | Group.RAY)
        return body

    def _add(
        self,
        collision: int,
        mesh: Mesh,
        colour: tuple[int, int, int],
        place: tuple[float, float, float],
        yaw: float = 0.0,
    ) -> int:
        bullet = self._bullet
        visual = bullet.createVisualShape(
            bullet.GEOM_MESH,
            vertices=mesh.vertices,
            normals=mesh.normals,
            indices=mesh.indices,
            uvs=mesh.uvs,
            rgbaColor=[*(part / 255 for part in colour), 1.0],
            specularColor=[0.0, 0.0, 0.0],
        )
        facing = bullet.getQuaternionFromEuler([0.0, 0.0, yaw])
        body: int = bullet.createMultiBody(0.0, collision, visual, place, facing)
        return body


class Textures:
    """The textures of a world, each loaded once."""

    def __init__(self, bullet: Bullet) -> None:
        self._bullet = bullet
        self._numbers: dict[Texture, int] = {}

    def number_of(self, texture: Texture) -> int:
        """Return Bullet's number for a texture."""
        if texture not in self._numbers:
            self._numbers[texture] = self._load_texture(texture)
        return self._numbers[texture]

    def _load_texture(self, texture: Texture) -> int:
        """Load a tile's picture. Its top row is the highest on the surface."""
        with TemporaryDirectory() as folder:
            file = Path(folder, "tile.png")
            cv2.imwrite(str(file), cv2.cvtColor(texture.tile[::-1], cv2.COLOR_GRAY2BGR))
            number: int = self._bullet.loadTexture(str(file))
        return number
