"""Cameras on USB as the kernel lists them, and why one cannot be used."""

from __future__ import annotations

import os
from pathlib import Path

FILES = Path("/dev")
CLASS = Path("/sys/class/video4linux")
"""A folder for every video file: its ``name``, its ``index`` within its device, and where that is plugged in.
Source: https://www.kernel.org/doc/html/latest/driver-api/media/v4l2-dev.html."""


def explain_unusable(path: Path, *, was_there: bool) -> str:
    """Say that there is no such file, or that this user may not use it; nothing where it can be used."""
    if not path.exists():
        return f"{path} is gone; plug it in again" if was_there else f"there is no {path}. {_list_cameras()}"
    if not os.access(path, os.R_OK | os.W_OK):
        return f"this user may not use {path}. Run sudo usermod -aG video $USER, then log out and in again"
    return ""


def usb_cameras() -> list[str]:
    """Return the files of the cameras on USB, each with the camera's name.

    Left out are a camera's further files, which give no pictures, and the Pi's own codecs.
    """
    nodes = sorted(CLASS.glob("video*"), key=lambda node: int(node.name.removeprefix("video")))
    return [f"{FILES / node.name} ({_read_attribute(node, 'name')})" for node in nodes if _is_usb_camera(node)]


def _is_usb_camera(node: Path) -> bool:
    return "/usb" in str((node / "device").resolve()) and _read_attribute(node, "index") == "0"


def _read_attribute(node: Path, attribute: str) -> str:
    return (node / attribute).read_text().strip()


def _list_cameras() -> str:
    cameras = usb_cameras()
    return f"There are: {', '.join(cameras)}" if cameras else "There is no camera on USB: plug it in, and look at lsusb"
