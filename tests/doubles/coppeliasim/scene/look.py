"""How a scene is lit: what CoppeliaSim leaves to lamps and the background."""

from __future__ import annotations

import math
from dataclasses import dataclass

from robotcore.description import Light
from tests.doubles.coppeliasim.scene.graph import Graph
from tests.doubles.coppeliasim.scene.objects import Lamp

DEFAULT_LIGHT = Light(elevation_rad=math.pi / 2, ambient=0.57, diffuse=0.38, sky_colour=(0, 0, 0))
"""As the recorded pictures are lit: from straight above, before a black background."""


@dataclass
class Look:
    """The light of a scene, as long as nobody sets a lamp of it."""

    light: Light = DEFAULT_LIGHT

    def under(self, graph: Graph) -> Light:
        """Return the light that the scene is in: of the first lamp that is on, if somebody has set any."""
        lamps = [lamp for lamp in graph.all_of(Lamp) if lamp.is_set]
        if not lamps:
            return self.light
        lit = next((lamp for lamp in lamps if lamp.is_on), None)
        return self._lit(lit, graph) if lit else self.light.model_copy(update={"diffuse": 0.0})

    def _lit(self, lamp: Lamp, graph: Graph) -> Light:
        x, y, z = graph.pose(lamp).axes[2]
        towards = {"azimuth_rad": math.atan2(-y, -x), "elevation_rad": math.asin(max(-1.0, min(1.0, -z)))}
        return self.light.model_copy(update={**towards, "diffuse": sum(lamp.diffuse) / 3, "brightness": 1.0})
