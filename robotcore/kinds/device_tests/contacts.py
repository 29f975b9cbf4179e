"""Tests buttons and bumpers: a person presses each of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from robotcore.hal.device_tester import INVERTED, DeviceTester
from robotcore.hal.simulation_state import SimulationState

PRESS_S = 10.0
"""The longest wait for the person to press, in seconds."""

HOLD_S = 0.2
"""The time for which other contacts may react to the same press, in seconds."""


def test_contacts(tester: DeviceTester, contacts: Sequence[Any]) -> None:
    """Let the person press each button or bumper, and find out which of them reacts."""
    source: dict[str, str] = {}
    for contact in contacts:
        reacted = _press(tester, contact, contacts)
        if reacted:
            source[contact.name] = reacted
    swapped = {name: other for name, other in source.items() if name != other}
    if swapped and set(swapped) == set(swapped.values()):
        text = ", ".join(f"pressing {name} is a press of {other}" for name, other in swapped.items())
        tester.reconnect(swapped, text, remedy="Swap their wires", kind="contacts-swapped")
        return
    for name, other in swapped.items():
        remedy = f"Correct the pins of {name} and {other}"
        tester.fail(name, f"pressing it is a press of {other}", remedy, "contact-on-other-pin")


def _press(tester: DeviceTester, contact: Any, contacts: Sequence[Any]) -> str | None:
    """Return the name of the contact that reacts when the person presses one; None without a result."""
    before = _read(tester, contacts)
    if before[contact.name]:
        text = "is pressed before a person touches it"
        remedy = "Check that nothing presses it, and that its wire is not connected to ground"
        tester.correct(contact.name, text, INVERTED, remedy=remedy, kind="contact-pressed")
        return None

    def hold(state: SimulationState) -> None:
        state.touches[contact.name] = 0

    if not tester.instruct(contact.name, "press", f"Press Enter, and then press {contact.name} for a moment", hold):
        tester.skip(contact.name, "no person presses it")
        return None
    reacted: set[str] = set()

    def has_reacted() -> bool:
        reacted.update(name for name, is_pressed in _read(tester, contacts).items() if is_pressed and not before[name])
        return bool(reacted)

    timeout = HOLD_S if tester.state else PRESS_S
    tester.wait_until(has_reacted, timeout)
    tester.wait_until(lambda: has_reacted() and False, HOLD_S)
    if tester.state:
        tester.state.touches.clear()
        tester.wait(HOLD_S)
    if not reacted:
        tester.fail(contact.name, "does not react to a press", "Check its wires and its pin", "contact-dead")
        return None
    if reacted == {contact.name}:
        tester.confirm(contact.name, "reacts to a press")
    elif contact.name in reacted:
        others = ", ".join(sorted(reacted - {contact.name}))
        tester.warn(contact.name, f"reacts to a press together with {others}", "Check their wires", "contacts-together")
        return None
    return contact.name if contact.name in reacted else min(reacted)


def _read(tester: DeviceTester, contacts: Sequence[Any]) -> Mapping[str, bool]:
    devices: dict[str, Any] = {contact.name: tester.robot[contact.name] for contact in contacts}
    return {name: bool(device.read().is_pressed) for name, device in devices.items()}
