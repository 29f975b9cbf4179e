"""A program that turns a motor under a guardian: ``python -m tests.drivers.raspberrypi.turning CUTOFF ACTION``."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import warnings
from contextlib import suppress
from select import select

from drivers.raspberrypi import chip
from robotcore.hal.cutoff import CutoffSpec
from robotcore.safety.guardian.client import Guardian

FORWARD, BACKWARD, STANDBY = 17, 27, 22
DUTY = 60
LEASE_S = 0.3


class Motor:
    """A motor with lgpio's software PWM on its forward line."""

    def __init__(self, guardian: Guardian) -> None:
        self._lgpio, self._guardian = chip.load(), guardian
        self._chip = self._lgpio.gpiochip_open(0)
        for gpio in (FORWARD, BACKWARD):
            self._lgpio.gpio_claim_output(self._chip, gpio)

    def turn(self) -> None:
        self._guardian.renew_lease()
        self._lgpio.tx_pwm(self._chip, FORWARD, 100, DUTY)

    def stop(self) -> None:
        self._lgpio.tx_pwm(self._chip, FORWARD, 0, 0)
        self._lgpio.gpio_write(self._chip, FORWARD, 0)
        self._guardian.end_lease()

    def close(self) -> None:
        self._lgpio.gpiochip_close(self._chip)


class _UnhandledError(Exception):
    pass


class Actions:
    """The actions of the program after its motor turns. The argument ACTION is the name of a method."""

    def drive(self, motor: Motor) -> None:
        while not _is_end_requested(0.02):
            motor.turn()
        motor.stop()

    def block(self, motor: Motor) -> None:
        """Hold the interpreter lock for four leases, like a slow call into a library in C."""
        ctypes.PyDLL(None).usleep(int(4 * LEASE_S * 1e6))

    def suspend(self, motor: Motor) -> None:
        """Suspend this process."""
        os.kill(os.getpid(), signal.SIGSTOP)

    def block_at_rest(self, motor: Motor) -> None:
        motor.stop()
        self.block(motor)

    def raise_error(self, motor: Motor) -> None:
        """Raise an error while the motor turns."""
        raise _UnhandledError

    def raise_at_rest(self, motor: Motor) -> None:
        motor.stop()
        raise _UnhandledError

    def fork_and_die(self, motor: Motor) -> None:
        """Fork a process that lives until stdin is closed, and kill this process."""
        warnings.simplefilter("ignore", DeprecationWarning)  # of forks of a process that has threads
        if os.fork() == 0:
            _is_end_requested(None)
            os._exit(0)
        os.kill(os.getpid(), signal.SIGKILL)


def _is_end_requested(seconds: float | None) -> bool:
    return bool(select([sys.stdin], [], [], seconds)[0])


def _print_line(word: str) -> None:
    sys.stdout.write(f"{word}\n")
    sys.stdout.flush()


def main() -> None:
    """Turn the motor, and run the action."""
    cutoff, action = sys.argv[1:]
    chip.LINE = os.environ["FAKE_DEV"]  # the kernel's name of a line's handle
    parameters: dict[str, dict[str, object]] = {
        "StandbyLine": {"line": STANDBY},
        "MotorLines": {"lines": [FORWARD, BACKWARD], "owner": os.getpid()},
    }
    spec = CutoffSpec("left_motor", f"drivers.raspberrypi.cutoff:{cutoff}", parameters[cutoff])
    with suppress(_UnhandledError), Guardian([spec], LEASE_S) as guardian:
        motor = Motor(guardian)
        motor.turn()
        _print_line("turning")
        getattr(Actions(), action)(motor)
        motor.close()
    _print_line("lives")


if __name__ == "__main__":
    main()
