"""Calls the functions of a running CoppeliaSim's remote API. Its failures become robotcore's errors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

from drivers.coppeliasim.address import Address, RefusedError, build_answer_error, build_error, require_greeting
from robotcore.errors import BackendError
from robotcore.simulation.executor import SerialExecutor

if TYPE_CHECKING:
    from drivers.coppeliasim.client import Client


T = TypeVar("T")

LOADING_S = 30.0
"""Time limit, in seconds, of calls that load a plug-in, start or stop a simulation, or render the first picture."""

INTERRUPTED_S = 2.0
"""After a signal such as Ctrl-C, the time limit of the call in progress, in seconds."""

IDLE_S = 5.0
"""The time without a call after which the server drops a client, in seconds.

In lockstep, the simulation waits for the client. After a client was killed, the simulation thus waits for 5 s only.
"""

OLDER_NAMES = {
    "sim.writeCustomStringData": "sim.writeCustomDataBlock",
    "sim.readCustomStringData": "sim.readCustomDataBlock",
}
"""The names that functions had before CoppeliaSim 4.7, by their present names. Their arguments have not changed."""


class SimulatorConnection:
    """A connection to one CoppeliaSim, which calls functions of its remote API.

    address: the address of the server.
    answer_s: the default time limit of a call, in seconds.

    After a call has timed out, each further call raises the same BackendError at once. A signal such as Ctrl-C
    interrupts the wait for an answer, but not the call itself. The next call begins after the interrupted call has
    ended.
    """

    def __init__(self, address: Address, client: Client, answer_s: float) -> None:
        self.address = address
        self.answer_s = answer_s
        self._client = client
        self._failure: BackendError | None = None
        self._executor = SerialExecutor("zmq remote api")
        self._functions: Mapping[str, Any] = {}

    def __repr__(self) -> str:
        return f"<SimulatorConnection to {self.address}, {'lost' if self.is_lost else 'open'}>"

    @classmethod
    def open(cls, address: Address, answer_s: float) -> SimulatorConnection:
        """Connect to a server, and read the list of its functions.

        answer_s: the default time limit of a call, in seconds.

        Raises BackendError if no CoppeliaSim answers at the address.
        """
        require_greeting(address)
        from drivers.coppeliasim.client import Client

        connection = cls(address, Client(address, IDLE_S), answer_s)
        try:
            connection.call("zmqRemoteApi.require", "sim", within_s=LOADING_S)
            connection._set_functions(connection.call("zmqRemoteApi.info", "sim", within_s=LOADING_S))
            connection._client.watch_disconnects()
        except BaseException:  # a signal too
            connection.close()
            raise
        return connection

    @property
    def is_lost(self) -> bool:
        """Whether the connection is broken or closed. Each call then raises an error."""
        return self._failure is not None

    def fail(self, failure: BackendError) -> None:
        """Make each further call raise this error, unless the connection has already failed with another error."""
        self._failure = self._failure or failure

    def sim(self, name: str, *arguments: Any, within_s: float | None = None) -> Any:
        """Call the function ``sim.NAME`` of the API, and return its result, or a tuple of its results.

        within_s: time limit in seconds. The greater of ``within_s`` and ``answer_s`` counts.

        If a CoppeliaSim 4.6 has the function under an older name, this name is used.
        """
        return self.call(self._find_function(name), *arguments, within_s=within_s)

    def constant(self, name: str) -> int:
        """Return the value of the constant ``sim.NAME``. Raises BackendError if the server does not have it."""
        entry = self._functions.get(name)
        if isinstance(entry, Mapping) and isinstance(entry.get("const"), (int, float)):
            return int(entry["const"])
        raise self._build_missing_error(f"sim.{name}")

    def call(self, function: str, *arguments: Any, within_s: float | None = None) -> Any:
        """Call a function of the server by its full name, and return its result. Calls from several threads take turns.

        within_s: time limit in seconds. The greater of ``within_s`` and ``answer_s`` counts.

        Raises BackendError if the server refuses the call, does not answer in time, or sends an invalid reply.
        """
        limit_s = self.answer_s if within_s is None else max(within_s, self.answer_s)
        try:
            return self._executor.run(partial(self._call, function, arguments, limit_s))
        except Exception:
            raise
        except BaseException:  # Ctrl-C must not wait for LOADING_S
            self._client.shorten_deadline(max(INTERRUPTED_S, self.answer_s))
            raise

    def run_batch(self, work: Callable[[], T]) -> T:
        """Run a function that calls this connection several times, and return the function's result.

        The function runs in the thread that exchanges messages. So the calling thread waits once, not once for each
        call.
        """
        return self._executor.run(work)

    def call_as(self, convert: Callable[[Any], T], name: str, *arguments: Any) -> T:
        """Call the function ``sim.NAME`` of the API, convert its result, and return it.

        convert: converts the result. It raises TypeError, ValueError or LookupError if the result is invalid.

        Raises BackendError if the result is invalid, and the errors of `call`.
        """
        answer = self.sim(name, *arguments)
        try:
            return convert(answer)
        except (TypeError, ValueError, LookupError) as error:
            raise build_answer_error(self.address, f"sim.{name}", f"{answer!r:.80}") from error

    def queue(self, name: str, *arguments: Any) -> None:
        """Send a call of ``sim.NAME`` to a server that has not answered in time. It executes the call once it answers.

        This method does nothing if the connection has no failure, or another failure than a time-out.
        """
        if self._failure and self._failure.kind == "timeout":
            self._executor.run(partial(self._client.queue, f"sim.{name}", arguments))

    def close(self) -> None:
        """End the session on the server, and disconnect. No error is raised. A second call does nothing."""
        if not self._failure:
            with suppress(BackendError):  # the server has ended
                self.call("_*end*_")
            self._failure = build_error(
                self.address, "connection-closed", f"the connection to {self.address} is closed"
            )
        self._executor.run(self._client.close)
        self._executor.close()

    def _call(self, function: str, arguments: Sequence[Any], limit_s: float) -> Any:
        if self._failure:
            raise self._failure
        try:
            return self._client.call_within(function, arguments, limit_s)
        except RefusedError:
            raise
        except BackendError as failure:
            self._failure = failure
            raise

    def _set_functions(self, info: Any) -> None:
        if not isinstance(info, Mapping) or "getObjectPosition" not in info:
            self._failure = build_answer_error(self.address, "zmqRemoteApi.info", "no list of functions")
            raise self._failure
        self._functions = info

    def _find_function(self, name: str) -> str:
        function = f"sim.{name}"
        if name in self._functions:
            return function
        older = OLDER_NAMES.get(function)
        if older and older.removeprefix("sim.") in self._functions:
            return older
        raise self._build_missing_error(function)

    def _build_missing_error(self, function: str) -> BackendError:
        return build_error(
            self.address,
            "function-missing",
            f"the CoppeliaSim at {self.address} has no {function}. Install a newer one; this driver was tested with "
            "4.10",
            function=function,
        )
