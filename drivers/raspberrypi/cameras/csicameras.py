"""The cameras on the Pi's ribbon connectors, and the library that knows them."""

from __future__ import annotations

from types import ModuleType
from typing import Any

from robotcore.errors import DeviceError

REMEDY = "On the Pi: sudo apt install python3-picamera2, and a venv made with --system-site-packages"

OTHER_NUMPY = "In the venv: pip install 'numpy<2' 'opencv-python-headless<4.12'"
"""Raspberry Pi OS 12 builds its picamera2 for NumPy 1.24; a later OpenCV wants NumPy 2."""


def imported(camera: str) -> Any:
    """Return the module picamera2; raises DeviceError where it is missing, or built for another NumPy."""
    try:
        import picamera2
    except ImportError as error:
        raise DeviceError(camera, f"picamera2 is not installed ({error}). {REMEDY}") from error
    except ValueError as error:  # Source: https://github.com/raspberrypi/picamera2/issues/1088
        raise DeviceError(
            camera, f"picamera2 is built for another NumPy than this one ({error}). {OTHER_NUMPY}"
        ) from error
    return picamera2


def require_there(camera: str, library: ModuleType, number: int) -> None:
    """Raise DeviceError where the Pi has no camera of that number."""
    there = library.Picamera2.global_camera_info()
    if number < len(there):
        return
    cameras = ", ".join(f"{index} ({told['Model']})" for index, told in enumerate(there))
    offer = f"there are: {cameras}" if cameras else "there is none: with the power off, look at its ribbon cable"
    raise DeviceError(camera, f"the Pi has no camera {number}; {offer}. rpicam-hello --list-cameras tells the same")
