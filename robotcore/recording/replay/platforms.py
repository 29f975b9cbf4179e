"""Whether a recording comes from a machine that reckons as this one does."""

from __future__ import annotations

from collections.abc import Mapping

from robotcore.recording.about import platform_of
from robotcore.runtime.versions import libraries

_MACHINE = ("machine", "system", "libc")


def differences(recorded: Mapping[str, str], backend: str) -> list[str]:
    """Return what of the machine and the libraries that compute is another one here, in words.

    The simulator does not count: a replay asks it nothing.
    """
    here = platform_of(backend)
    return [
        f"{name} {recorded.get(name, 'unknown')} there, {here[name]} here"
        for name in (*_MACHINE, *libraries([]))
        if recorded.get(name) != here[name]
    ]
