"""Trees of files in place of the file system of a board, as texts by their paths."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from robotcore.description import DeviceDescription, StrictModel, load_robot
from robotcore.hal.device import Device
from robotcore.hardware import Connection, DeviceBinding, DeviceContext, DeviceDriver

Tree = Mapping[str, str | bytes]

PI_4_BOOKWORM: Tree = {
    "proc/device-tree/model": "Raspberry Pi 4 Model B Rev 1.4\0",
    "sys/module/pinctrl_bcm2835/parameters/persist_gpio_outputs": "N\n",
    "sys/class/video4linux/video0/name": "unicam-image\n",
    "sys/class/video4linux/video10/name": "bcm2835-codec-decode\n",
    "run/systemd/timesync/synchronized": "",
    "dev/gpiochip0": "",
    "dev/i2c-1": "",
    "dev/video0": "",
}

PI_5_TRIXIE: Tree = {
    "proc/device-tree/model": "Raspberry Pi 5 Model B Rev 1.0\0",
    "sys/module/pinctrl_bcm2835/parameters/persist_gpio_outputs": "N\n",
    "sys/module/pinctrl_rp1/parameters/persist_gpio_outputs": "N\n",
    "sys/class/video4linux/video0/name": "rp1-cfe-csi2_ch0\n",
    "sys/class/video4linux/video20/name": "pispbe-input\n",
    "run/systemd/timesync/synchronized": "",
    "dev/gpiochip0": "",
    "dev/i2c-1": "",
    "dev/video0": "",
}

BROKEN: Tree = {
    "proc/device-tree/model": "Raspberry Pi 3 Model B Plus Rev 1.3\0",
    "sys/module/pinctrl_bcm2835/parameters/persist_gpio_outputs": "Y\n",
    "sys/class/video4linux/video10/name": "bcm2835-codec-decode\n",
    "dev/gpiochip0": "",
    "dev/video10": "",
}
"""An older 32-bit system, whose user is in one group only, without camera, I2C and network."""


def create_tree(root: Path, tree: Tree) -> Path:
    """Write a tree of files below ``root``; return ``root``."""
    for path, content in tree.items():
        file = root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content if isinstance(content, bytes) else content.encode())
    return root


def create_chip(root: Path, number: int, driver: str) -> None:
    """Add a GPIO chip with its driver to a tree's sysfs."""
    device = root / "sys/devices/platform" / f"{number}.gpio"
    made, known = device / f"gpiochip{number}", root / "sys/bus/platform/drivers" / driver
    for folder in (made, known, root / "sys/bus/gpio/devices"):
        folder.mkdir(parents=True, exist_ok=True)
    device.joinpath("driver").symlink_to(known)
    (root / "sys/bus/gpio/devices" / made.name).symlink_to(made)


class ConnectedDriver(DeviceDriver):
    """A driver whose connections are given at its construction."""

    name = "plugged"
    summary = "for tests"
    described = StrictModel
    wires: tuple[Connection, ...] = ()
    hints: tuple[str, ...] = ()

    def open(self, description: DeviceDescription, context: DeviceContext) -> Device:
        raise NotImplementedError

    def connections(self) -> tuple[Connection, ...]:
        return self.wires

    def notes(self, description: DeviceDescription) -> tuple[str, ...]:
        return self.hints


class SuppliedDriver(ConnectedDriver):
    """A driver with a supply of 3.3 V from the board."""

    supply = ("3.3 V", "ground")


def binding(
    name: str, *wires: Connection, notes: tuple[str, ...] = (), kind: type[ConnectedDriver] = ConnectedDriver
) -> DeviceBinding:
    """Return the binding of a rover's device on these wires."""
    description = next(device for device in load_robot("rover").devices if device.name == name)
    return DeviceBinding(description, kind(wires=wires, hints=notes))
