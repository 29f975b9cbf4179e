"""Tests buttons and bumpers: a person presses each of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from robotcore.hal.device_test import INVERTED, DeviceTest
from robotcore.hal.simulation_state import SimulationState

PRESS_S = 10.0
"""The longest wait for the person to press, in seconds."""

HOLD_S = 0.2
"""The time for which other contacts may react to the same press, in seconds."""


def test_contacts(test: DeviceTest, contacts: Sequence[Any]) -> None:
    """Let the person press each button or bumper, and find out which of them reacts."""
    source: dict[str, str] = {}
    for contact in contacts:
        reacted = _press(test, contact, contacts)
        if reacted:
            source[contact.name] = reacted
    swapped = {name: other for name, other in source.items() if name != other}
    if swapped and set(swapped) == set(swapped.values()):
        text = ", ".join(f"pressing {name} is a press of {other}" for name, other in swapped.items())
        test.swap_tables(swapped, text, remedy="Swap their wires", kind="contacts-swapped")
        return
    for name, other in swapped.items():
        remedy = f"Correct the pins of {name} and {other}"
        test.fail(name, f"pressing it is a press of {other}", remedy, "contact-on-other-pin")


def _press(test: DeviceTest, contact: Any, contacts: Sequence[Any]) -> str | None:
    """Return the name of the contact that reacts when the person presses one; None without a result."""
    before = _read(test, contacts)
    if before[contact.name]:
        text = "is pressed before a person touches it"
        remedy = "Check that nothing presses it, and that its wire is not connected to ground"
        test.correct(contact.name, text, INVERTED, remedy=remedy, kind="contact-pressed")
        return None

    def hold(state: SimulationState) -> None:
        state.touches[contact.name] = 0

    if not test.instruct(contact.name, "press", f"Press Enter, and then press {contact.name} for a moment", hold):
        test.skip(contact.name, "no person presses it")
        return None
    reacted: set[str] = set()

    def has_reacted() -> bool:
        reacted.update(name for name, is_pressed in _read(test, contacts).items() if is_pressed and not before[name])
        return bool(reacted)

    timeout = HOLD_S if test.state else PRESS_S
    test.wait_until(has_reacted, timeout)
    test.wait_until(lambda: has_reacted() and False, HOLD_S)
    if test.state:
        test.state.touches.clear()
        test.wait(HOLD_S)
    if not reacted:
        test.fail(contact.name, "does not react to a press", "Check its wires and its pin", "contact-dead")
        return None
    if reacted == {contact.name}:
        test.confirm(contact.name, "reacts to a press")
    elif contact.name in reacted:
        others = ", ".join(sorted(reacted - {contact.name}))
        test.warn(contact.name, f"reacts to a press together with {others}", "Check their wires", "contacts-together")
        return None
    return contact.name if contact.name in reacted else min(reacted)


def _read(test: DeviceTest, contacts: Sequence[Any]) -> Mapping[str, bool]:
    devices: dict[str, Any] = {contact.name: test.robot[contact.name] for contact in contacts}
    return {name: bool(device.read().is_pressed) for name, device in devices.items()}
