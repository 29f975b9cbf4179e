"""``robotcore`` whose guardian may be slow to start: python -m tests.system.guest.patient ARGUMENT..."""

from __future__ import annotations

from robotcore.cli.main import main
from robotcore.guardian import guardian
from tests.system.speed import scaled

if __name__ == "__main__":
    guardian.STARTING_S = scaled(guardian.STARTING_S)
    main()
