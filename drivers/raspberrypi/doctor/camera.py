"""Whether the cameras that a robot has are there, and whether picamera2 fits the NumPy that is installed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from importlib import import_module
from pathlib import Path

from drivers.raspberrypi.cameras.csicameras import OTHER_NUMPY
from drivers.raspberrypi.doctor.files import told
from robotcore.hal.finding import Finding
from robotcore.hardware import Fitting

WHAT = "camera"
NODES = "sys/class/video4linux/video*/name"
RECEIVERS = ("unicam", "rp1-cfe")
"""What receives pictures from the camera's connector, up to a Pi 4 and on a Pi 5; it is there when a sensor was found.
Sources: the kernel's drivers bcm2835-unicam and rp1-cfe."""

CSI = "CSI"
NO_CAMERA = (
    "Switch the board off and look at the camera's cable: contacts on the right side, pushed in all the way; "
    "camera_auto_detect=1 in /boot/firmware/config.txt; rpicam-hello --list-cameras tells what is found"
)
FROM_APT = "sudo apt install python3-picamera2, and make the venv with --system-site-packages"


def camera(root: Path, fittings: Iterable[Fitting]) -> Iterator[Finding]:
    """Look whether a robot's cameras are there: a sensor on the connector, the device file of any other one."""
    for fitting in fittings:
        for wire in fitting.connections:
            if wire.bus == CSI:
                yield _on_connector(root, fitting.name, wire.where)
            elif wire.where.startswith("/dev/"):
                yield _at(root, fitting.name, wire.where)


def _on_connector(root: Path, name: str, number: str) -> Finding:
    nodes = [told(file) for file in sorted(root.glob(NODES))]
    if found := next((node for node in nodes if node.startswith(RECEIVERS)), None):
        if number != "0":
            said = f"there is a sensor ({found}); whether it is camera {number}, for {name}, could not be checked"
            return Finding.warning(WHAT, said, "rpicam-hello --list-cameras tells their numbers")
        return Finding.ok(WHAT, f"a sensor for {name} is on the connector ({found})")
    return Finding.error(WHAT, f"no camera was found on the connector, and {name} needs one", NO_CAMERA)


def _at(root: Path, name: str, file: str) -> Finding:
    if (root / file.lstrip("/")).exists():
        return Finding.ok(WHAT, f"{file} is there, for {name}")
    return Finding.error(WHAT, f"{file} is not there, and {name} needs it", "Plug it in; v4l2-ctl --list-devices")


def picamera2(importing: Callable[[str], object] = import_module) -> Iterator[Finding]:
    """Look whether picamera2 can be imported together with this NumPy.

    Source of the fault that is expected: https://github.com/raspberrypi/picamera2/issues/1170.
    """
    try:
        importing("picamera2")
    except ImportError as error:
        yield Finding.error("picamera2", f"cannot be imported: {error}", FROM_APT)
    except ValueError as error:  # numpy.dtype size changed, may indicate binary incompatibility
        yield Finding.error("picamera2", f"was built for another NumPy: {error}", OTHER_NUMPY)
    else:
        yield Finding.ok("picamera2", "fits this NumPy")
