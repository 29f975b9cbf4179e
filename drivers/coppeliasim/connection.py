"""The connection to a CoppeliaSim: its functions by name, a time limit for each call, and its errors as ours."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

from drivers.coppeliasim.address import (
    Address,
    _require_greeting,
    function_missing,
    is_listening,
    server_gone,
    server_too_old,
    timed_out,
    unexpected_answer,
)
from robotcore.errors import BackendError
from robotcore.simulation.executor import SerialExecutor

if TYPE_CHECKING:
    from drivers.coppeliasim.client import Client


T = TypeVar("T")

LOADING_S = 30.0
"""What starts, stops, loads or renders for the first time may take so long."""

HURRIED_S = 2.0
"""What is under way when somebody wants to end it takes no longer, if it hangs."""

IDLE_S = 5.0
"""A server forgets a client that says nothing for so long, so that a killed one does not freeze the simulation."""

OLDER = {
    "sim.getObject": "sim.getObjectHandle",
    "sim.createPrimitiveShape": "sim.createPureShape",
    "sim.setJointTargetForce": "sim.setJointMaxForce",
    "sim.getVisionSensorImg": "sim.getVisionSensorCharImage",
    "sim.setVisionSensorImg": "sim.setVisionSensorCharImage",
    "sim.writeCustomStringData": "sim.writeCustomDataBlock",
    "sim.readCustomStringData": "sim.readCustomDataBlock",
    "sim.getNamedStringParam": "sim.getStringNamedParam",
    "sim.setNamedStringParam": "sim.setStringNamedParam",
}
"""What functions were called before 4.4, or 4.7; results are the same, and arguments but for `_REARRANGED`."""

_REARRANGED: dict[str, Callable[..., tuple[Any, ...]]] = {
    "sim.createPureShape": lambda kind, sizes, options: (kind, options, sizes, 1.0),
}


class RefusedError(BackendError):
    """The server's own error about a call; the next one may do better."""


class Connection:
    """Calls to one CoppeliaSim; ``answer_s`` is how long it may let wait.

    Once it has not answered it is not asked again: every further call raises the same BackendError at once. A signal
    interrupts who waits for an answer, never the call: it is over when the next one begins.
    """

    def __init__(self, address: Address, client: Client, answer_s: float) -> None:
        self.address, self.answer_s = address, answer_s
        self._client = client
        self._failure: BackendError | None = None
        self._executor = SerialExecutor("zmq remote api")
        self._known: Mapping[str, Any] = {}

    @classmethod
    def open(cls, address: Address, answer_s: float) -> Connection:
        """Connect, and learn what the server offers; raises BackendError, with what to do, where nobody answers."""
        _require_greeting(address)
        from drivers.coppeliasim.client import Client

        connection = cls(address, _connected(Client, address), answer_s)
        try:
            connection.call("zmqRemoteApi.require", "sim", within_s=LOADING_S)
            connection._learn(connection.call("zmqRemoteApi.info", "sim", within_s=LOADING_S))
            connection._client.watch_disconnects()
        except BaseException:  # a signal too
            connection.close()
            raise
        return connection

    @property
    def is_lost(self) -> bool:
        """Whether nothing more can be asked."""
        return self._failure is not None

    def give_up(self, failure: BackendError) -> None:
        """Ask nothing more: from now on every call raises this."""
        self._failure = self._failure or failure

    def sim(self, name: str, *arguments: Any, within_s: float | None = None) -> Any:
        """Call ``sim.NAME``, or what it was called before; return its result, a tuple where it has several."""
        function = self._offered(name)
        if function in _REARRANGED:
            arguments = _REARRANGED[function](*arguments)
        return self.call(function, *arguments, within_s=within_s)

    def has(self, name: str) -> bool:
        """Return whether the server offers ``sim.NAME``, under that name."""
        return name in self._known

    def constant(self, name: str) -> int:
        """Return the value of ``sim.NAME``; raises BackendError where the server has none."""
        entry = self._known.get(name)
        if isinstance(entry, Mapping) and isinstance(entry.get("const"), (int, float)):
            return int(entry["const"])
        raise function_missing(self.address, f"sim.{name}")

    def call(self, function: str, *arguments: Any, within_s: float | None = None) -> Any:
        """Call any function of the server; raises BackendError. Threads may call it: one call at a time."""
        limit = self.answer_s if within_s is None else max(within_s, self.answer_s)
        try:
            return self._executor.run(partial(self._ask, function, arguments, limit))
        except Exception:
            raise
        except BaseException:  # Ctrl-C: nobody waits for as long as loading may take
            self._client.shorten_deadline(max(HURRIED_S, self.answer_s))
            raise

    def run_batch(self, work: Callable[[], T]) -> T:
        """Return what work comes to that makes several calls; whoever waits for it is woken once for all of them."""
        return self._executor.run(work)

    def _ask(self, function: str, arguments: Sequence[Any], limit: float) -> Any:
        from drivers.coppeliasim.client import (
            CallRefused,
            CallTimeout,
            Disconnected,
            FirstProtocolReply,
            ProtocolViolation,
        )

        if self._failure:
            raise self._failure
        try:
            return self._client.ask(function, arguments, limit)
        except CallRefused as error:
            raise RefusedError(f"coppeliasim: {self.address} refused {function}: {error}") from error
        except CallTimeout as error:
            is_there = is_listening(self.address)
            silent = timed_out(self.address, function, limit, is_known=bool(self._known))
            self._failure = silent if is_there else server_gone(self.address, function)
            raise self._failure from error
        except Disconnected as error:
            self._failure = server_gone(self.address, function)
            raise self._failure from error
        except FirstProtocolReply as error:
            self._failure = server_too_old(self.address)
            raise self._failure from error
        except ProtocolViolation as error:
            self._failure = unexpected_answer(self.address, function, error)
            raise self._failure from error

    def call_as(self, convert: Callable[[Any], T], name: str, *arguments: Any) -> T:
        """Return what ``sim.NAME`` tells, converted; raises BackendError where that is not possible."""
        answer = self.sim(name, *arguments)
        try:
            return convert(answer)
        except (TypeError, ValueError, LookupError) as error:
            raise unexpected_answer(self.address, f"sim.{name}", f"{answer!r:.80}") from error

    def close(self) -> None:
        """Say goodbye where somebody listens, and let go. May be called again; never raises."""
        if not self._failure:
            with suppress(BackendError):  # it has gone before us
                self.call("_*end*_")
            self._failure = BackendError(f"coppeliasim: the connection to {self.address} is closed")
        self._executor.run(self._client.close)
        self._executor.close()

    def _learn(self, info: Any) -> None:
        if not isinstance(info, Mapping) or "getObjectPosition" not in info:
            self._failure = unexpected_answer(self.address, "zmqRemoteApi.info", "no list of functions")
            raise self._failure
        self._known = info

    def _offered(self, name: str) -> str:
        function = f"sim.{name}"
        if name in self._known:
            return function
        older = OLDER.get(function)
        if older and older.removeprefix("sim.") in self._known:
            return older
        raise function_missing(self.address, function)


def _connected(client: type[Client], address: Address) -> Client:
    import zmq

    try:
        return client(address.host, address.port, IDLE_S)
    except zmq.ZMQError as error:
        raise BackendError(f"coppeliasim: {address} is no address to connect to: {error}. Correct --host") from error
