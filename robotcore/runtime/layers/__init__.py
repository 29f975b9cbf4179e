"""The layers between a driver's devices and the app. The module `assembly` defines their order."""

from robotcore.runtime.layers.assembly import AssembledRobot, assemble

__all__ = ["AssembledRobot", "assemble"]
