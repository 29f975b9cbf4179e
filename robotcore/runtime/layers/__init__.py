"""What fits over any device, and the one place that says in which order."""

from robotcore.runtime.layers.assembly import Assembled, assemble, needed_devices

__all__ = ["Assembled", "assemble", "needed_devices"]
