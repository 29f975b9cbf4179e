"""Tests that install packages while they run."""

from __future__ import annotations

from robotcore import plugins


def forget_packages() -> None:
    """Let robotcore read the installed packages again at the next use."""
    for cached in (plugins._scan_packages, plugins._list_points, plugins._points, plugins._find_rivals):
        cached.cache_clear()
