"""A camera's picture of a world, painted from back to front with NumPy and OpenCV."""

from robotcore.simulation.painter.painter import Painter

__all__ = ["Painter"]
