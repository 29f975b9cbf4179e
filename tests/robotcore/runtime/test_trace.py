from __future__ import annotations

import hashlib
import struct

from robotcore.geometry import Wheels
from robotcore.runtime.trace import TickRecord, Trace
from robotcore.safety.velocity_limits import Intervention


def record(state: str, asked: Wheels | None = None, *, tick: int = 0, interventions: int = 0) -> TickRecord:
    changed = Intervention(0.0, "range guard", Wheels(1.0, 1.0), Wheels(0.0, 0.0))
    return TickRecord(tick, tick / 20, state, asked, asked, (changed,) * interventions)


def digest(*records: TickRecord) -> str:
    trace = Trace(())
    for each in records:
        trace.add(each)
    return trace.sha256


def test_digest_is_as_documented() -> None:
    actual = digest(record("search", Wheels(1.5, -0.25)), record("zurück"), record("seen", Wheels(0.0, -0.0)))
    by_hand = b"".join(
        [
            b"search\x00\x02",
            struct.pack("<d", 1.5),
            struct.pack("<d", -0.25),
            "zurück".encode(),
            b"\x00\x00",
            b"seen\x00\x02",
            bytes(8),
            b"\x00" * 7 + b"\x80",
        ]
    )
    assert actual == hashlib.sha256(by_hand).hexdigest()


def test_digest_depends_on_the_request_only() -> None:
    asked = record("a", Wheels(1.0, 2.0))
    guarded = asked._replace(
        sent=Wheels(0.0, 0.0), time=7.0, tick=9, interventions=record("", interventions=1).interventions
    )
    assert digest(asked) == digest(guarded)


def test_milestone_is_reached_when_its_state_is_entered_first() -> None:
    trace = Trace(("search", "seen", "arrived"))
    for tick, state in enumerate(["start", "search", "seen", "search", "seen"]):
        trace.add(record(state, tick=tick))
    assert trace.milestones == {"search": 0.05, "seen": 0.1}


def test_milestones_are_rounded() -> None:
    trace = Trace(("seen",))
    trace.add(record("seen")._replace(time=sum([0.05] * 529)))
    assert sum([0.05] * 529) != 26.45
    assert trace.milestones == {"seen": 26.45}
