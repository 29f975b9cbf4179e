"""Contacts, and what the maker's plug-in tells of collisions and distances."""

from __future__ import annotations

from tests.doubles.coppeliasim.scene import SceneError
from tests.doubles.coppeliasim.zmq.functions.registry import function
from tests.doubles.coppeliasim.zmq.session import Session

HANDLE_ALL = -2


@function("getContactInfo")
def get_contact_info(
    session: Session, passes: int, thing: int, index: int
) -> tuple[list[int], list[float], list[float], list[float]]:
    """Return two shapes, the point, force and normal; empty lists after the last. One shape's come with it first."""
    contacts = session.simulator.contacts()
    if thing != HANDLE_ALL:
        both = [each if each.first == thing else each.swapped for each in contacts]
        contacts = [each for each in both if each.first == thing]
    if index >= len(contacts):
        return [], [], [], []
    found = contacts[index]
    return [found.first, found.second], list(found.point), list(found.force), list(found.normal)


@function("checkCollision")
def check_collision(session: Session, one: int, other: int) -> tuple[int, list[int]]:
    _require_no_plugin(session)
    return 0, [-1, -1]


@function("checkDistance")
def check_distance(
    session: Session, one: int, other: int, threshold: float = 0.0
) -> tuple[int, list[float], list[int]]:
    _require_no_plugin(session)
    return 0, [0.0] * 7, [-1, -1]


def _require_no_plugin(session: Session) -> None:
    """Without the plug-in the answer is a silent no; with it, it would have to be true."""
    if session.simulator.can_detect:
        raise SceneError("the double reckons neither collisions nor distances; ask getContactInfo.")
