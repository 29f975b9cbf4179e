from __future__ import annotations

import threading

from robotcore.recording.backlog import Backlog


def test_entries_come_out_in_their_order() -> None:
    backlog: Backlog[int] = Backlog()
    for entry in range(3):
        backlog.put(entry, 1, waits=False)
    assert [backlog.get() for _ in range(4)] == [0, 1, 2, None]


def test_there_is_no_room_while_too_much_waits_but_nothing_is_refused() -> None:
    backlog: Backlog[int] = Backlog(room=10)
    backlog.put(1, 9, waits=False)
    assert backlog.has_room()
    backlog.put(2, 9, waits=False)
    assert not backlog.has_room()
    backlog.put(3, 9, waits=False)
    assert [backlog.get() for _ in range(3)] == [1, 2, 3]
    assert backlog.has_room()


def test_who_waits_for_room_goes_on_when_there_is_some() -> None:
    backlog: Backlog[int] = Backlog(room=10)
    putting = threading.Thread(target=lambda: backlog.put(1, 10, waits=True))
    putting.start()
    while not backlog._entries:
        pass
    assert putting.is_alive()
    assert backlog.get() == 1
    putting.join(20.0)
    assert not putting.is_alive()


def test_an_end_lets_go_of_who_waits_for_room_and_takes_no_more() -> None:
    backlog: Backlog[int] = Backlog(room=10)
    putting = threading.Thread(target=lambda: backlog.put(1, 10, waits=True))
    putting.start()
    backlog.end()
    putting.join(20.0)
    assert not putting.is_alive()
    backlog.put(2, 1, waits=True)
    rest = [backlog.get(), backlog.get()]
    assert 2 not in rest
    assert backlog.is_over


def test_what_is_abandoned_leaves_room_and_nothing_to_take() -> None:
    backlog: Backlog[int] = Backlog(room=10)
    for entry in range(3):
        backlog.put(entry, 9, waits=False)
    backlog.abandon()
    backlog.put(4, 9, waits=True)
    assert (backlog.has_room(), backlog.is_over, backlog.get()) == (True, True, None)
