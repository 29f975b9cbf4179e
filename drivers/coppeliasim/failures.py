"""What can be wrong with a CoppeliaSim, in words: what, where, and what to do."""

from __future__ import annotations

from drivers.coppeliasim.address import Address
from robotcore.errors import BackendError


def nobody(address: Address, why: OSError) -> BackendError:
    """Return the error for an address where there is no server."""
    reason = "" if isinstance(why, ConnectionRefusedError) else f" ({why.strerror or why})"
    return BackendError(
        f"coppeliasim: nobody listens at {address}{reason}. Start CoppeliaSim, or name where it runs with --host and "
        "--port"
    )


def stranger(address: Address, said: bytes | None) -> BackendError:
    """Return the error for a server that greets otherwise than ZeroMQ, None being not at all."""
    spoken = f"begins with the byte {said.hex()}" if said else "hangs up"
    does = "says nothing" if said is None else spoken
    return BackendError(
        f"coppeliasim: who listens at {address} {does}; that is not CoppeliaSim's ZeroMQ remote API, or it is frozen. "
        "The legacy remote API is --backend vrep; else look which program listens there, and name the right port with "
        "--port: 23000 as CoppeliaSim is shipped"
    )


def gone(address: Address, function: str) -> BackendError:
    """Return the error for a server that has ended during a call."""
    return BackendError(
        f"coppeliasim: the CoppeliaSim at {address} is gone; it died or was closed in {function}. "
        "Start it again, and run again"
    )


def silent(address: Address, function: str, limit_s: float, *, is_known: bool) -> BackendError:
    """Return the error for a server that lets wait; one that ``is_known`` has answered before."""
    advice = (
        "Look whether it shows a dialogue or hangs; where it is only slow, raise safety.answer_s in the robot's "
        "description"
        if is_known
        else "Look whether a dialogue of CoppeliaSim's waits for somebody, or it is busy"
    )
    return BackendError(f"coppeliasim: {address} has not answered {function} for {limit_s:.1f} s. {advice}")


def garbled(address: Address, function: str, what: object) -> BackendError:
    """Return the error for an answer that is none of this protocol."""
    return BackendError(
        f"coppeliasim: {address} answered {function} with {what}; that is not CoppeliaSim's ZeroMQ remote API. "
        "Look which program listens there, and name the right one with --port"
    )


def too_old(address: Address) -> BackendError:
    """Return the error for a server of the first protocol."""
    return BackendError(
        f"coppeliasim: {address} speaks the first protocol of the ZeroMQ remote API, as CoppeliaSim up to 4.5 does. "
        "Install CoppeliaSim 4.6 or newer, or use --backend vrep"
    )


def lacking(address: Address, function: str) -> BackendError:
    """Return the error for a function that a server does not offer, nor an older one that does the same."""
    return BackendError(
        f"coppeliasim: the CoppeliaSim at {address} has no {function}. Install a newer one; 4.10 is what this was "
        "made with"
    )
