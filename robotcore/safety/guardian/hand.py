"""A cutoff at work in a thread of its own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from queue import SimpleQueue
from threading import Event
from typing import Literal

from robotcore.errors import RobotcoreError
from robotcore.hal.clock import Clock
from robotcore.hal.cutoff import Cutoff, CutoffSpec, Unsure
from robotcore.safety.guardian.link import Report
from robotcore.threads import start_thread

Deed = Literal["open", "arm", "rest", "stop", "close"]
"""What a cutoff can be asked for."""

RETRYING_S = 0.5
"""So long a stop that fails is tried again."""

_PAUSE_S = 0.02


class Hand:
    """Works one cutoff, so that one that fails or hangs holds up no other. Its thread waits ready for a stop.

    If ``in_place`` is set, it has no thread, and `ask` does each deed in the caller's thread. No deed follows a close.
    Raises ResourceError if the system refuses the thread.
    """

    def __init__(self, spec: CutoffSpec, clock: Clock, *, in_place: bool = False) -> None:
        self.device = spec.device
        self._spec, self._clock = spec, clock
        self._cutoff: Cutoff | None = None
        self._is_at_work = True
        self._tasks = SimpleQueue[_Task]()
        self._in_place = in_place
        if not in_place:
            start_thread(self._work, spec.device)

    def ask(self, deed: Deed) -> _Task:
        """Have a deed done after those that were asked for before."""
        task = _Task(getattr(self, f"_{deed}"))
        if self._in_place:
            task.do()
        else:
            self._tasks.put(task)
        return task

    def _open(self) -> None:
        self._cutoff = self._spec.make()
        self._cutoff.open()

    def _arm(self) -> None:
        self._opened.arm()

    def _rest(self) -> None:
        self._opened.rest()

    def _stop(self) -> str | None:
        """Stop; again where it fails, for a while."""
        end = self._clock.now() + RETRYING_S
        while True:
            try:
                return self._opened.stop()
            except Exception:
                if self._clock.now() >= end:
                    raise
            self._clock.sleep_until(self._clock.now() + _PAUSE_S)

    def _close(self) -> None:
        self._is_at_work = False
        if self._cutoff:
            self._cutoff.close()

    @property
    def _opened(self) -> Cutoff:
        assert self._cutoff, "open comes first"
        return self._cutoff

    def _work(self) -> None:
        while self._is_at_work:
            self._tasks.get().do()


class _Task:
    """A deed that was asked for, and what became of it."""

    def __init__(self, deed: Callable[[], str | None]) -> None:
        self._deed = deed
        self._is_over = Event()
        self._fault: str | None = None
        self.told: str | None = None

    def do(self) -> None:
        try:
            self.told = self._deed()
        except RobotcoreError as error:
            self._fault = str(error)
        except Exception as error:  # noqa: BLE001  whatever a driver or its vendor's library raises
            self._fault = f"{type(error).__name__}: {error}"
        self._is_over.set()

    def fault_within(self, seconds: float) -> str | None:
        """Return what went wrong, None where nothing did; a deed that is not done in this time hangs."""
        return self._fault if self._is_over.wait(max(0.0, seconds)) else "does not answer"


def together(hands: Sequence[Hand], deed: Deed, limit: float, clock: Clock) -> Report:
    """Have all hands do a deed at once, and tell within ``limit`` seconds what became of it."""
    tasks = [hand.ask(deed) for hand in hands]
    end = clock.now() + limit
    faults = [task.fault_within(end - clock.now()) for task in tasks]
    failed = tuple(f"{hand.device}: {fault}" for hand, fault in zip(hands, faults, strict=True) if fault)
    over = [(hand.device, task.told) for hand, task, fault in zip(hands, tasks, faults, strict=True) if not fault]
    done = tuple(device for device, told in over if not isinstance(told, Unsure))
    words = (f"{device}: {told}" if isinstance(told, Unsure) else told for device, told in over if told)
    return Report(deed, done, failed, tuple(dict.fromkeys(words)))
