"""Checks of the GPIOs: their library, their holders, and their levels after a program was killed."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from drivers.raspberrypi.doctor.board import read_text
from drivers.raspberrypi.lg import find_header_driver
from drivers.raspberrypi.pins import open_pins
from robotcore.errors import BackendError
from robotcore.hal.check_finding import Finding
from robotcore.hardware import Connection, DeviceBinding

PINS = "pins"
IN_USE = 1
"""The flag of a GPIO line that a program or the kernel holds. Source: lgpio's manual, gpio_get_line_info."""

FindHolders = Callable[[Collection[int]], Mapping[int, str]]
"""A function that returns the holders of the given GPIOs, such as ``process 12 (python3)``. Free GPIOs are left out."""


def find_holders(gpios: Collection[int]) -> dict[int, str]:
    """Return the holders of the given GPIOs, as the kernel reports them. Free GPIOs are left out."""
    from drivers.raspberrypi.chip import find_holder
    from drivers.raspberrypi.lg import find_chip_number, load

    lgpio = load()
    chip = lgpio.gpiochip_open(find_chip_number())
    try:
        return {gpio: find_holder(gpio) for gpio in gpios if lgpio.gpio_get_line_info(chip, gpio)[2] & IN_USE}
    finally:
        lgpio.gpiochip_close(chip)


def check_pins(bindings: Iterable[DeviceBinding], find_holders: FindHolders = find_holders) -> Iterator[Finding]:
    """Check that no program holds a GPIO of these devices.

    The GPIOs of I2C devices are not checked, because the kernel holds the lines of the bus.
    """
    owners = {int(wire.where): binding.name for binding in bindings for wire in _gpio_wires(binding)}
    held = find_holders(sorted(owners)) if owners else {}
    for gpio, holder in held.items():
        message = f"GPIO {gpio} ({owners[gpio]}) is held by {holder}"
        yield Finding.error(PINS, message, "End that program, or connect the device elsewhere", kind="gpio-held")
    if owners and not held:
        yield Finding.ok(PINS, f"free: GPIO {', '.join(map(str, sorted(owners)))}", kind="gpios-free")


def _gpio_wires(binding: DeviceBinding) -> Iterator[Connection]:
    wires = binding.connections
    if not any(wire.bus == "I2C" for wire in wires):
        yield from (wire for wire in wires if wire.bus == "GPIO")


PIN_FACTORY = "pin factory"
EMPTY_STUB = "0.0.0.2"
"""The version of lgpio that pip installs for Python 3.13 on a Pi. It is empty, and in a venv it hides the lgpio of
apt."""

OLDEST_GPIOZERO = (2, 0, 1)
"""The oldest supported version of gpiozero, the same as in the extra ``pi`` of pyproject.toml."""


def check_library() -> Iterator[Finding]:
    """Check that lgpio and gpiozero are installed and work. No pin is changed."""
    if find_version("lgpio") == EMPTY_STUB:
        remedy = "pip uninstall lgpio; sudo apt install python3-lgpio, and a venv made with --system-site-packages"
        yield Finding.error(PIN_FACTORY, f"lgpio {EMPTY_STUB} is an empty stub", remedy, kind="lgpio-stub")
        return
    gpiozero = find_version("gpiozero") or "0"
    if _parse_version(gpiozero) < OLDEST_GPIOZERO:
        yield Finding.error(
            PIN_FACTORY,
            f"gpiozero {gpiozero} is too old",
            "pip install --upgrade 'gpiozero>=2.0.1'",
            kind="gpiozero-too-old",
        )
    try:
        open_pins().close()
    except BackendError as error:
        problem, _, remedy = str(error).partition(". ")
        yield Finding.error(PIN_FACTORY, problem, remedy, kind="pin-factory-fails")
    else:
        yield Finding.ok(
            PIN_FACTORY,
            f"lgpio {find_version('lgpio') or ''}".strip() + f", under gpiozero {gpiozero}",
            kind="pin-factory-ok",
        )


def find_version(package: str) -> str | None:
    """Return the version of an installed package; None if it is not installed."""
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _parse_version(version: str) -> tuple[int, ...]:
    return tuple(int(part) for part in version.split(".")[:3] if part.isdecimal())


KILLED_RUNS = "killed runs"
PARAMETERS = "sys/module/{module}/parameters/persist_gpio_outputs"
ANY_CONTROLLER = "pinctrl_*"
PERSISTENCE_REMEDY = (
    "Add the line dtparam=strict_gpiod to /boot/firmware/config.txt and restart; "
    "and pull the motor board's enable or standby pin down by a resistor of 10 kΩ"
)


def check_persistence(root: Path) -> Iterator[Finding]:
    """Check that the kernel releases the outputs of a killed program. Otherwise its motors continue to turn.

    Only the kernel driver of the header's GPIO chip is checked. A kernel may have GPIO drivers for other boards too.
    """
    module = (find_header_driver(root) or ANY_CONTROLLER).replace("-", "_")
    settings = {file.parts[-3]: read_text(file) for file in sorted(root.glob(PARAMETERS.format(module=module)))}
    if keeping := [module for module, value in settings.items() if value.upper() in ("Y", "1")]:
        setting = f"{', '.join(keeping)}.persist_gpio_outputs=Y"
        yield Finding.warning(
            KILLED_RUNS,
            f"GPIO outputs keep their level after their program was killed ({setting}). Then only the guardian "
            "stops a turning motor",
            PERSISTENCE_REMEDY,
            kind="outputs-persist",
        )
    elif settings:
        yield Finding.ok(KILLED_RUNS, "the kernel releases the outputs of a killed program", kind="outputs-released")
    else:
        message = "this kernel has no parameter persist_gpio_outputs: it may be too old"
        yield Finding.unchecked(KILLED_RUNS, message, f"sudo apt full-upgrade. {PERSISTENCE_REMEDY}")
