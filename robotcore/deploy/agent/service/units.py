"""The two units of systemd's that keep a release running: constant text, so that nothing of a user's gets into it.

See systemd.service(5) and systemd.unit(5); ``%h`` is the home, ``%t`` the folder of what lasts until a reboot.
"""

from __future__ import annotations

from pathlib import Path

from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.service import systemd
from robotcore.deploy.agent.system import durable

SERVICE, TRIAL = "robotcore.service", "robotcore-trial.service"

START_LIMIT_S = 120
"""How long a release may take until its app has made its first step."""

_STAND = "2 4 6"
"""Exit statuses of robotcore's after which somebody has to look: what can never run, what the safety stage stopped, and
what ended by itself with a failure (`robotcore.runtime.notify.FAILED`)."""

_SERVICE = f"""\
# Written by robotcore deploy. What you want otherwise goes into a drop-in: systemctl --user edit {SERVICE}
[Unit]
Description=The app of this robot
ConditionPathExists=%h/robotcore/current
StartLimitIntervalSec=300
StartLimitBurst=10

[Service]
Type=notify
ExecStart=/usr/bin/python3 -I %h/robotcore/aboard.pyz run
ExecStopPost=/usr/bin/python3 -I %h/robotcore/aboard.pyz off
Restart=on-failure
RestartSec=2
RestartPreventExitStatus={_STAND}
SuccessExitStatus=143
TimeoutStartSec={START_LIMIT_S}
TimeoutStopSec=20
TimeoutAbortSec=5
WatchdogSec=10
KillMode=control-group
RuntimeDirectory=robotcore
Environment=LG_WD=%t/robotcore
Environment=PYTHONUNBUFFERED=1
Environment=PYTHONFAULTHANDLER=1
EnvironmentFile=-%h/.config/robotcore/environment
LimitCORE=0
SyslogIdentifier=robotcore

[Install]
WantedBy=default.target
"""

_TRIAL = """\
# Written by robotcore deploy.
[Unit]
Description=Whether a new release of this robot's app lives, and the way back
ConditionPathExists=%h/robotcore/trial.json
StartLimitIntervalSec=60
StartLimitBurst=20

[Service]
Type=exec
ExecStart=/usr/bin/python3 -I %h/robotcore/aboard.pyz trial
Restart=on-failure
RestartForceExitStatus=SIGTERM SIGINT SIGHUP
RestartSec=1
SyslogIdentifier=robotcore-trial

[Install]
WantedBy=default.target
"""

TEXTS = {SERVICE: _SERVICE, TRIAL: _TRIAL}


def install(layout: Layout) -> None:
    """Put the units where they are not there like this, and let systemd start them with the robot."""
    layout.units.mkdir(parents=True, exist_ok=True)
    changed = {name: text for name, text in TEXTS.items() if not _is_there(layout.units / name, text)}
    for name, text in changed.items():
        durable.write(layout.units / name, text)
    if changed:
        systemd.reload()
    systemd.enable(*TEXTS)


def installed(layout: Layout) -> list[Path]:
    """Return the files of the units that are there: all, none, or what a removal that was cut short has left."""
    return [unit for name in TEXTS if (unit := layout.units / name).exists()]


def _is_there(path: Path, text: str) -> bool:
    return path.is_file() and path.read_bytes() == text.encode()
