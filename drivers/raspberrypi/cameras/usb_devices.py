"""List the cameras on USB, and explain why a camera cannot be used."""

from __future__ import annotations

import os
from pathlib import Path

FILES = Path("/dev")
CLASS = Path("/sys/class/video4linux")
"""A folder for each video file: its ``name``, its ``index`` within its device, and a link to that device.
Source: https://www.kernel.org/doc/html/latest/driver-api/media/v4l2-dev.html."""


def explain_unusable(path: Path, *, was_there: bool) -> str:
    """Return why this user cannot use a camera's file, and a remedy; an empty text if it can be used.

    was_there: whether the camera was open before.
    """
    if not path.exists():
        return f"{path} is gone; plug it in again" if was_there else f"there is no {path}. {_list_cameras()}"
    if not os.access(path, os.R_OK | os.W_OK):
        return f"no permission for {path}. Run sudo usermod -aG video $USER, then log out and in again"
    return ""


def usb_cameras() -> list[str]:
    """Return the files of the cameras on USB, each with the camera's name.

    A camera's further files, which give no pictures, and the Pi's own codecs are left out.
    """
    nodes = sorted(CLASS.glob("video*"), key=lambda node: int(node.name.removeprefix("video")))
    return [f"{FILES / node.name} ({_read_attribute(node, 'name')})" for node in nodes if _is_usb_camera(node)]


def _is_usb_camera(node: Path) -> bool:
    return "/usb" in str((node / "device").resolve()) and _read_attribute(node, "index") == "0"


def _read_attribute(node: Path, attribute: str) -> str:
    return (node / attribute).read_text().strip()


def _list_cameras() -> str:
    cameras = usb_cameras()
    return f"There are: {', '.join(cameras)}" if cameras else "There is no camera on USB: plug it in, and check lsusb"
