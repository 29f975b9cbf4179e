"""The world: a floor, prisms and balls, none of which moves, its light and its sky."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from drivers.mujoco.model.attributes import CollisionGroup, Colour, RenderGroup, about_z, rgba
from robotcore.description import Ball, Box, Floor, Light, Texture, WorldDescription
from robotcore.description.meshes import Mesh, ground_mesh, prism_mesh
from robotcore.description.world import Prism

if TYPE_CHECKING:
    from mujoco import MjSpec


GROUND_HALF_M = 200.0
"""The ground is drawn this far; its edge lies a pixel's fraction below the horizon."""

GROUND = "Ground"
"""The floor's name in the model: no thing's, for these are in lower case."""

BALL_SLICES, BALL_STACKS = 64, 32
"""A sphere is drawn by so many: its outline covers 99.8 % of a circle."""


def seen_name(thing: str) -> str:
    """Return the name of the shape that is seen of a thing."""
    return f"{thing}.seen"


def add_world(spec: MjSpec, world: WorldDescription) -> None:
    """Add all that stands in a world; each thing's shape that is touched has the thing's name."""
    looks = Materials(spec)
    _add_light(spec, world.light)
    looks.add_sky(world.light.sky_colour)
    _add_floor(spec, world.floor, looks)
    for prism in world.prisms:
        _add_prism(spec, prism, looks)
    for ball in world.targets:
        _add_ball(spec, ball, looks)
    spec.visual.quality.numslices, spec.visual.quality.numstacks = BALL_SLICES, BALL_STACKS


def _add_light(spec: MjSpec, light: Light) -> None:
    """Add the lamp, and the glow from everywhere."""
    import mujoco

    glow, lamp = light.ambient * light.brightness, light.diffuse * light.brightness
    headlight = spec.visual.headlight
    headlight.ambient, headlight.diffuse, headlight.specular = [glow] * 3, [0.0] * 3, [0.0] * 3
    spec.worldbody.add_light(
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        dir=[-part for part in light.direction],
        diffuse=[lamp] * 3,
        ambient=[0.0] * 3,
        specular=[0.0] * 3,
        castshadow=False,
    )


def _add_floor(spec: MjSpec, floor: Floor, looks: Materials) -> None:
    import mujoco

    spec.worldbody.add_geom(
        name=GROUND,
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[0.0, 0.0, 1.0],
        contype=CollisionGroup.FLOOR,
        conaffinity=CollisionGroup.NOTHING,
        friction=[1.0, 0.0, 0.0],
        group=RenderGroup.TOUCHED_ROBOT,
    )
    _add_seen(spec, GROUND, ground_mesh(GROUND_HALF_M, floor), looks.of(floor.colour, floor.texture), RenderGroup.FLOOR)


def _add_prism(spec: MjSpec, prism: Prism, looks: Materials) -> None:
    import mujoco

    mesh = prism_mesh(prism)
    place = {"pos": [prism.x_m, prism.y_m, 0.0], "quat": about_z(prism.yaw_rad)}
    _add_seen(spec, prism.name, mesh, looks.of(prism.colour, prism.texture), RenderGroup.WORLD, **place)
    touched = {
        "contype": CollisionGroup.THING,
        "conaffinity": CollisionGroup.NOTHING,
        "group": RenderGroup.TOUCHED_THING,
        "name": prism.name,
    }
    if isinstance(prism, Box):
        half = prism.height_m / 2
        size = [prism.length_m / 2, prism.width_m / 2, half]
        middle = {**place, "pos": [prism.x_m, prism.y_m, half]}
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=size, **middle, **touched)
    else:
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=_mesh_name(prism.name), **place, **touched)


def _add_ball(spec: MjSpec, ball: Ball, looks: Materials) -> None:
    import mujoco

    sphere = {
        "type": mujoco.mjtGeom.mjGEOM_SPHERE,
        "size": [ball.radius_m, 0.0, 0.0],
        "pos": [ball.x_m, ball.y_m, ball.radius_m],
        "conaffinity": CollisionGroup.NOTHING,
    }
    seen = {"contype": CollisionGroup.NOTHING, "group": RenderGroup.WORLD, "material": looks.of(ball.colour, None)}
    spec.worldbody.add_geom(name=seen_name(ball.name), **sphere, **seen)
    spec.worldbody.add_geom(name=ball.name, **sphere, contype=CollisionGroup.THING, group=RenderGroup.TOUCHED_THING)


def _add_seen(spec: MjSpec, name: str, mesh: Mesh, material: str, group: RenderGroup, **place: Any) -> None:
    """Add what is only seen of a thing: a mesh with a look."""
    import mujoco

    made = spec.add_mesh(name=_mesh_name(name))
    made.uservert = [part for vertex in mesh.vertices for part in vertex]
    made.usernormal = [part for normal in mesh.normals for part in normal]
    made.userface = mesh.indices
    if mesh.uvs:
        made.usertexcoord = [part for uv in mesh.uvs for part in uv]
    made.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    spec.worldbody.add_geom(
        name=seen_name(name),
        type=mujoco.mjtGeom.mjGEOM_MESH,
        meshname=made.name,
        material=material,
        contype=CollisionGroup.NOTHING,
        conaffinity=CollisionGroup.NOTHING,
        group=group,
        **place,
    )


def _mesh_name(thing: str) -> str:
    return f"{thing}_mesh"


class Materials:
    """Materials of a model: matt, so that a face shows its colour times the light, and nothing else."""

    def __init__(self, spec: MjSpec) -> None:
        self._spec = spec
        self._names: dict[tuple[Colour, Texture | None], str] = {}
        self._textures: dict[Texture, str] = {}

    def of(self, colour: Colour, texture: Texture | None) -> str:
        """Return the name of the material of a colour, darkened by a texture where there is one."""
        key = (colour, texture)
        if key not in self._names:
            self._names[key] = name = f"look_{len(self._names)}"
            material = self._spec.add_material(
                name=name, rgba=rgba(colour), specular=0.0, shininess=0.0, reflectance=0.0
            )
            if texture:
                import mujoco

                material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = self._texture(texture)
        return self._names[key]

    def add_sky(self, colour: Colour) -> None:
        """Let every direction in which nothing stands show one colour."""
        import mujoco

        rgb = [part / 255 for part in colour]
        self._spec.add_texture(
            name="sky",
            type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
            builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT,
            rgb1=rgb,
            rgb2=rgb,
            width=8,
            height=48,
        )

    def _texture(self, texture: Texture) -> str:
        import mujoco

        if texture not in self._textures:
            self._textures[texture] = name = f"texture_{len(self._textures)}"
            tile = np.repeat(texture.tile[:, :, None], 3, axis=2)
            height, width, channels = tile.shape
            made = self._spec.add_texture(
                name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, width=width, height=height, nchannel=channels
            )
            made.data = tile.tobytes()
        return self._textures[texture]
