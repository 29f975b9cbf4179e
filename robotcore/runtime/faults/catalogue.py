"""Faults by name: an effect, and what it is on."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress

from robotcore.errors import BackendMissingError, UnknownNameError
from robotcore.plugins import FAULTS, fault_names, load_registered
from robotcore.runtime.faults.fault import Fault, Kind


def effects() -> list[str]:
    """Return the names of all effects, each once."""
    return sorted({effect_of(name) for name in fault_names()})


def effect_of(name: str) -> str:
    """Return the effect that a registered name is for: what stands behind its dot tells two of one effect apart."""
    return name.partition(".")[0]


def load_fault(name: str) -> type[Fault]:
    """Return the fault of a registered name; BackendMissingError where it cannot be loaded, or is none."""
    found = load_registered("fault", FAULTS, name)
    if not (isinstance(found, type) and issubclass(found, Fault)):
        raise BackendMissingError(
            f"the fault {name!r} is no class that inherits robotcore.runtime.faults.Fault. Mend its entry point"
        )
    return found


def faults_called(effect: str) -> list[type[Fault]]:
    """Return what has this effect: one fault, or one for each of several kinds of device.

    Raises UnknownNameError, with the nearest name; UsageError where no fault at all is registered.
    """
    names = [name for name in fault_names() if effect_of(name) == effect]
    if not names and (known := effects()):
        raise UnknownNameError("effect", effect, known)
    return [load_fault(name) for name in names or [effect]]


def effects_on(kind: Kind) -> list[str]:
    """Return the effects that there are on a kind of device; what cannot be loaded has none."""
    return sorted({effect_of(name) for name in fault_names() if kind in _kinds_of(name)})


def modules_of(specs: Iterable[str]) -> list[str]:
    """Return the modules whose code specs run; those of a spec that is none are left out, it runs nothing."""
    names = {word.partition("=")[0].replace("-", "_") for spec in specs for word in spec.split()[1:2]}
    return sorted(load_fault(name).__module__ for name in fault_names() if effect_of(name) in names)


def _kinds_of(name: str) -> frozenset[Kind]:
    with suppress(BackendMissingError):
        return load_fault(name).on
    return frozenset()
