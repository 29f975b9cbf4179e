"""States of ``robotcore.service`` from systemd 252, recorded during health checks on a Debian 12.

Each line is the answer to one query: ActiveState, SubState, Result, the first two characters of InvocationID,
NRestarts, ExecMainCode, ExecMainStatus, Job, and UnitFileState if it is not ``enabled``. A 0 at the end means that the
watchdog was never reset.
"""

from __future__ import annotations

OLD_RUNS = "active running success dd 0 0 0 -"
NEW_HANGS = "active running success 0c 0 0 0 - enabled 0"
OLD_STOPS = "deactivating stop-post success dd 0 1 143 2135"
OLD_WAITS = "activating auto-restart exit-code dd 0 1 1 -"
OLD_AGAIN = "active running success f7 1 0 0 2135"
OLD_STOPS_AGAIN = "deactivating stop-post success f7 1 2 15 2135"
NEW_STARTS = "activating start success 0c 0 0 0 2135"
NEW_RUNS = "active running success 0c 0 0 0 -"
NEW_FAILS = "deactivating stop-post exit-code 0c 0 1 1 2135"
NEW_WAITS = "activating auto-restart exit-code 0c 0 1 1 -"
AGAIN_RUNS = "active running success 6a 1 0 0 -"
KILLED = "activating auto-restart signal 0c 0 2 9 -"
HANGS = "deactivating stop-watchdog watchdog 0c 0 0 0 -"
HUNG = "activating auto-restart watchdog 0c 0 2 6 -"
TOO_SLOW = "deactivating stop-sigterm timeout 0c 0 0 0 2135"
WAS_TOO_SLOW = "activating auto-restart timeout 0c 0 1 143 -"
NEVER_READY = "deactivating stop-post protocol 0c 0 1 0 2135"
WAS_NEVER_READY = "activating auto-restart protocol 0c 0 1 0 -"
UNUSABLE = "failed failed exit-code 0c 0 1 2 -"
SUCCEEDS = "deactivating stop-post success 0c 0 1 0 -"
SUCCEEDED = "inactive dead success 0c 0 1 0 -"
BETWEEN = "inactive dead success 0c 0 1 143 625"
STOPPED = "inactive dead success 0c 0 1 143 -"
PUT_OFF = "inactive dead success dd 0 1 143 - disabled"
GAVE_UP = "failed failed exit-code dd 9 1 1 -"
PASSED_OVER = "inactive dead success dd 0 1 143 -"
BACK_STARTS = "activating start success e6 0 0 0 2140"
BACK_RUNS = "active running success e6 0 0 0 -"
BACK_FAILS = "activating auto-restart exit-code e6 0 1 1 -"
NEVER_WAS = "inactive dead success - 0 0 0 -"

NO_BUS = "Failed to connect to bus: No medium found"
LEFT = "Failed to get properties: Transport endpoint is not connected"
UNKNOWN = "Failed to restart robotcore.service: Unit robotcore.service not found."


def format_properties(line: str) -> str:
    """Return a query's answer in the format of ``systemctl show``."""
    active, sub, result, invocation, restarts, code, status, job, *more = line.replace(" -", " _").split()
    invocation, job, enabled = invocation.strip("_"), job.strip("_"), (*more, "enabled")[0]
    alive_at = more[1] if more[1:] else "9" * 18
    return (
        f"StatusText=searching, 30 s\nResult={result}\nNRestarts={restarts}\nExecMainCode={code}\n"
        f"ExecMainStatus={status}\nActiveState={active}\nSubState={sub}\nUnitFileState={enabled}\n"
        f"ActiveEnterTimestampMonotonic=69920658494\nWatchdogTimestampMonotonic={alive_at}\nJob={job}\n"
        f"InvocationID={invocation and invocation + '7fb2b1ea3440b5ae86df6299644aee'}\n"
    )
