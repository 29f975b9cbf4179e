"""Colours and textures, each made once."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from robotcore.description import Texture

if TYPE_CHECKING:
    from mujoco import MjSpec

Colour = tuple[int, int, int]


def rgba(colour: Colour) -> list[float]:
    """Return a colour as MuJoCo takes it."""
    return [*(part / 255 for part in colour), 1.0]


class Looks:
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
