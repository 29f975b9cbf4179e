"""Textures as Bullet takes them: from a file, which may go once it was read."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import cv2

from drivers.pybullet.bullet import Bullet
from robotcore.description import Texture


class Textures:
    """The textures of a world, each loaded once."""

    def __init__(self, bullet: Bullet) -> None:
        self._bullet = bullet
        self._numbers: dict[Texture, int] = {}

    def number_of(self, texture: Texture) -> int:
        """Return Bullet's number for a texture."""
        if texture not in self._numbers:
            self._numbers[texture] = self._loaded(texture)
        return self._numbers[texture]

    def _loaded(self, texture: Texture) -> int:
        """Load a tile's picture. Its top row is the highest on the surface."""
        with TemporaryDirectory() as folder:
            file = Path(folder, "tile.png")
            cv2.imwrite(str(file), cv2.cvtColor(texture.tile[::-1], cv2.COLOR_GRAY2BGR))
            number: int = self._bullet.loadTexture(str(file))
        return number
