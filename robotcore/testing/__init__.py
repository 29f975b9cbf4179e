"""Tests without hardware: `MockRobot` tests apps, and the conformance kit tests drivers.

```python
from robotcore.testing import TestSupport, ConformanceSuite

class TestMine(ConformanceSuite):
    backend = MyBackend
    lacks = {TestSupport.WORLD: "the robot stands on a table"}
```

The package requires pytest. pytest loads the plug-in of this package in every project, so the package imports its other
modules only when they are first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from robotcore.testing.bench import TestSupport
    from robotcore.testing.conformance import ConformanceSuite
    from robotcore.testing.fakes import Gate
    from robotcore.testing.mock.devices import LOST
    from robotcore.testing.mock.robot import MockRobot

__all__ = ["LOST", "ConformanceSuite", "Gate", "MockRobot", "TestSupport"]

_MODULES = {
    "TestSupport": "bench",
    "ConformanceSuite": "conformance",
    "Gate": "fakes",
    "LOST": "mock.devices",
    "MockRobot": "mock.robot",
}


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
