"""The two wires of the loopback test: the choice of their pins, and the check that they are connected."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from contextlib import ExitStack, suppress
from threading import Event
from typing import Any, NamedTuple

from drivers.raspberrypi.header import GPIOS, find_pads
from drivers.raspberrypi.pins import translate_pin_errors
from robotcore.errors import DeviceError, UsageError
from robotcore.hardware import DeviceBinding

RESERVED = {
    **dict.fromkeys((0, 1), "the Pi identifies a HAT by it"),
    **dict.fromkeys((2, 3), "a resistor on the board holds it high"),
    **dict.fromkeys((14, 15), "the serial console may use it"),
}
"""The GPIOs that the test does not use, with the reason."""

_PAIRS = ((20, 21), (19, 26), (23, 24), (17, 27), (5, 6), (12, 16), (13, 25), (22, 10), (9, 11), (18, 4))
"""The default wires in the order of preference. Most of them connect neighbouring pads."""

COUNT = 2
SETTLE_S = 0.003
"""The time for the level of a wire to settle after a change of a pull, in seconds. A pull has about 50 kΩ."""


class LoopbackWire(NamedTuple):
    """A wire from an output to an input of the same Pi.

    >>> print(LoopbackWire(1, 20, 21))
    wire 1 from GPIO 20 (pad 38) to GPIO 21 (pad 40)
    """

    number: int
    output: int
    input: int

    def __str__(self) -> str:
        return f"wire {self.number} from {format_gpio(self.output)} to {format_gpio(self.input)}"


def format_gpio(gpio: int) -> str:
    """Return a GPIO with its pad on the header, such as ``GPIO 20 (pad 38)``."""
    (pad,) = find_pads({0: "ID_SD", 1: "ID_SC"}.get(gpio, f"GPIO {gpio}"))
    return f"GPIO {gpio} (pad {pad})"


def find_used_gpios(bindings: Iterable[DeviceBinding]) -> dict[int, str]:
    """Return the names of the devices of a robot by the GPIOs that they use."""
    return {
        int(wire.where): binding.name
        for binding in bindings
        for wire in binding.driver.connections()
        if wire.bus == "GPIO"
    }


def choose_wires(given: Sequence[tuple[int, int]], used: dict[int, str]) -> tuple[LoopbackWire, ...]:
    """Return the two wires of the test.

    given: the output and the input of each wire, as the user names them; empty for the default.
    used: the devices of the robot by their GPIOs.

    Raises UsageError for pins that cannot be used, and if too few pins are free.
    """
    pairs = tuple(given) or _find_free_pairs(used)
    if len(pairs) != COUNT:
        text = f"the test needs {COUNT} wires, got {len(pairs)}. Name both: --wire 20:21 --wire 19:26"
        raise UsageError(text, kind="wire-count", wires=len(pairs))
    seen: set[int] = set()
    for gpio in (gpio for pair in pairs for gpio in pair):
        _require_usable(gpio, used)
        if gpio in seen:
            text = f"GPIO {gpio} is named twice. Each end of a wire needs a pin of its own"
            raise UsageError(text, kind="wire-same-pin", gpio=gpio)
        seen.add(gpio)
    return tuple(LoopbackWire(number, *pair) for number, pair in enumerate(pairs, start=1))


def _find_free_pairs(used: Collection[int]) -> tuple[tuple[int, int], ...]:
    pairs = [pair for pair in _PAIRS if not set(pair) & set(used)]
    left = [gpio for gpio in GPIOS if gpio not in (*used, *RESERVED, *(pin for pair in pairs for pin in pair))]
    pairs += zip(left[::2], left[1::2], strict=False)
    if len(pairs) < COUNT:
        text = "the robot leaves fewer than four GPIOs free. Disconnect a device, and name its pins with --wire"
        raise UsageError(text, kind="no-free-pins")
    return tuple(pairs[:COUNT])


def _require_usable(gpio: int, used: dict[int, str]) -> None:
    if gpio not in GPIOS:
        text = f"there is no GPIO {gpio} on the header. Use 4 to 27, the numbers of the chip (BCM)"
        raise UsageError(text, kind="wire-unknown-pin", gpio=gpio)
    if gpio in RESERVED:
        text = f"GPIO {gpio} cannot be used: {RESERVED[gpio]}. Use another GPIO"
        raise UsageError(text, kind="wire-reserved-pin", gpio=gpio)
    if gpio in used:
        text = f"GPIO {gpio} belongs to {used[gpio]} of the robot. Use another GPIO, or leave --robot out"
        raise UsageError(text, kind="wire-robot-pin", gpio=gpio, device=used[gpio])


def find_problem(wire: LoopbackWire, pins: Any, others: Iterable[int] = ()) -> str:
    """Return the problem of a wire and its remedy; an empty text if it connects its two pins.

    Only the weak pull of the output's pin drives the wire. So a wire on a supply pad does no harm.

    pins: gpiozero's pin factory.
    others: free GPIOs on which the other end of a misplaced wire may be.

    Raises DeviceError if a pin cannot be used.
    """
    with ExitStack() as opened:
        source = _open_input(wire.output, pins, opened)
        target = _open_input(wire.input, pins, opened)
        match _read_levels(source, target):
            case (True, False):
                return ""
            case (True, True):
                found = f"{format_gpio(wire.input)} stays high, as on a pad of 3.3 V"
            case (False, False):
                found = f"{format_gpio(wire.input)} stays low, as on a ground pad"
            case _:
                found = f"no wire connects {format_gpio(wire.output)} and {format_gpio(wire.input)}"
        for gpio in others:
            with suppress(DeviceError), ExitStack() as tried:
                if _read_levels(source, _open_input(gpio, pins, tried)) == (True, False):
                    return f"{found}. The wire from {format_gpio(wire.output)} is on {format_gpio(gpio)}: move it"
        return f"{found}. Check both ends of wire {wire.number}"


def _open_input(gpio: int, pins: Any, opened: ExitStack) -> Any:
    from gpiozero import InputDevice

    with translate_pin_errors("loopback", (gpio,)):
        return opened.enter_context(InputDevice(gpio, pull_up=None, active_state=True, pin_factory=pins)).pin


def _read_levels(source: Any, target: Any) -> tuple[bool, bool]:
    """Return the levels of ``target`` while the pull of ``source`` is up, and while it is down.

    Before that, the target's own pull is the opposite one. Without a wire, the floating target keeps that level.
    """
    levels = []
    for pull, opposite in (("up", "down"), ("down", "up")):
        source.pull = "floating"
        target.pull = opposite
        Event().wait(SETTLE_S)
        target.pull = "floating"
        source.pull = pull
        Event().wait(SETTLE_S)
        levels.append(bool(target.state))
    source.pull = target.pull = "down"
    return levels[0], levels[1]
