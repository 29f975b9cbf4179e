"""Strings that make a file where somebody takes them for more than they are."""

from __future__ import annotations

CANARY = "pwned"
TOUCH = f"touch {CANARY}"

HOSTS = (
    f"-oProxyCommand={TOUCH}",
    f"-oLocalCommand={TOUCH}",
    f"-F/dev/stdin;{TOUCH}",
    f"$({TOUCH})",
    f"`{TOUCH}`",
    f"rover;{TOUCH}",
    f"rover|{TOUCH}",
    f"rover&{TOUCH}",
    f"rover\n{TOUCH}",
    f"rover {TOUCH}",
    f"pi@rover -oProxyCommand={TOUCH}",
    f"$({TOUCH})@rover",
    f"-l{TOUCH}@rover",
    f"pi@-oProxyCommand={TOUCH}",
    f"rover:22;{TOUCH}",
    f"rover:$({TOUCH})",
    f"[::1]:22;{TOUCH}",
    f"[$({TOUCH})]:22",
    f"ssh://rover/;{TOUCH}",
    f"rover'\"; {TOUCH}; \"'",
)

RELEASES = (
    f"$({TOUCH})",
    f"../../../tmp;{TOUCH}",
    "../../.ssh",
    f"-rf;{TOUCH}",
    f"2026-11-21T22-40-03Z;{TOUCH}",
)

NOTES = (
    f"$({TOUCH})",
    f"`{TOUCH}`",
    f"'; {TOUCH}; '",
    f'"; {TOUCH}; "',
    f"a\n{TOUCH}\nb",
    f"--record={CANARY}",
    f"%h %t $HOME ${{IFS}}{TOUCH}",
    f"\\'; {TOUCH} #",
    f"=; {TOUCH} && {TOUCH} || {TOUCH}",
    f"ü \u202e 🤖 \x1b]0;{CANARY}\x07 \x1e{{}}",
)

FILES = (
    f"$({TOUCH})",
    f"`{TOUCH}`.txt",
    f";{TOUCH};",
    f"'; {TOUCH}; '",
    f'"; {TOUCH}; "',
    f"a\n{TOUCH}\nb",
    "-e sh",
    "--rsh=sh",
    "-rf",
    "*",
    "~root",
    f"a folder/|{TOUCH}|",
    "host::module",
    "\\\\server",
    "ünï 🤖 \u202e.txt",
)
