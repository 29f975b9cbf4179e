"""Replay the recorded ZeroMQ sessions on a double, and print the differences.

python -m tests.doubles.coppeliasim.replaying
"""

from __future__ import annotations

import sys

from tests.doubles.coppeliasim.replaying.replay import SESSIONS, replay_on_double


def main() -> int:
    """Print the differences, and return 1 if there are any."""
    found = {file: replay_on_double(file) for file in SESSIONS}
    for file, lines in found.items():
        sys.stdout.write(f"{file}: {len(lines)} differences\n" + "".join(f"  {line}\n" for line in lines))
    return int(any(found.values()))


if __name__ == "__main__":
    sys.exit(main())
