"""Sweeps: run one app on every backend, in every world, with every seed, on all cores or on a cluster.

Importing this package does not import NumPy, because `__getattr__` imports each name at its first use. NumPy reads the
limit of its threads when it is imported, and a worker process must set the limit before.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from robotcore.sweep.cluster import ClusterEngine as ClusterEngine
    from robotcore.sweep.engine import LocalEngine as LocalEngine
    from robotcore.sweep.engine import run_sweep as run_sweep
    from robotcore.sweep.record import Record as Record
    from robotcore.sweep.results import Results as Results
    from robotcore.sweep.spec import Sweep as Sweep


_HOMES = {
    "ClusterEngine": "cluster",
    "LocalEngine": "engine",
    "Record": "record",
    "Results": "results",
    "Sweep": "spec",
    "run_sweep": "engine",
}

__all__ = ["ClusterEngine", "LocalEngine", "Record", "Results", "Sweep", "run_sweep"]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'robotcore.sweep' has no attribute {name!r}")
    return getattr(import_module(f"robotcore.sweep.{_HOMES[name]}"), name)
