"""The two systemd units of a deploy, and the program that they start.

One unit keeps the app running, the other one runs the health check of a new release. The units are constant text, so
that they contain no user input. In them, ``%h`` is the home folder, and ``%t`` the runtime folder: see systemd.unit(5).
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from pathlib import Path

from robotcore.deploy.agent import files, robot_facts, sources
from robotcore.deploy.agent import systemctl as systemd
from robotcore.deploy.agent.files import Layout

SERVICE, HEALTH_CHECK = "robotcore.service", "robotcore-health-check.service"

START_LIMIT_S = 120
"""The greatest time limit for an app's first tick, in s: systemd's limit for the start of the service."""

_FINAL_STATUSES = "2 4 6"
"""The exit statuses of the app after which systemd does not restart it.

2: the app cannot run. 4: the safety stage stopped it. 6: it ended by itself without success.
"""

_SERVICE = f"""\
# Written by robotcore deploy. Put changes into a drop-in: systemctl --user edit {SERVICE}
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
RestartPreventExitStatus={_FINAL_STATUSES}
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

_HEALTH_CHECK = """\
# Written by robotcore deploy.
[Unit]
Description=Health check of a new release of this robot's app
ConditionPathExists=%h/robotcore/health-check.json
StartLimitIntervalSec=60
StartLimitBurst=20

[Service]
Type=exec
ExecStart=/usr/bin/python3 -I %h/robotcore/aboard.pyz health-check
Restart=on-failure
RestartForceExitStatus=SIGTERM SIGINT SIGHUP
RestartSec=1
SyslogIdentifier=robotcore-health-check

[Install]
WantedBy=default.target
"""

UNIT_TEXTS = {SERVICE: _SERVICE, HEALTH_CHECK: _HEALTH_CHECK}

_MAIN = "from robotcore.deploy.agent.service import main\n\nraise SystemExit(main())\n"
_EPOCH = (1980, 1, 1, 0, 0, 0)
"""The time stamp of all files in the ZIP file. It is constant so that equal sources give equal ZIP files."""


def install_service(layout: Layout) -> None:
    """Install the program and the units. Raises the AgentError of `require_lingering`."""
    robot_facts.require_lingering()
    install_program(layout, sources)
    install_units(layout)


def install_units(layout: Layout) -> None:
    """Write the unit files that are new or have changed, and make systemd start the units at each boot."""
    layout.units.mkdir(parents=True, exist_ok=True)
    changed = [_write_if_changed(layout.units / name, text.encode()) for name, text in UNIT_TEXTS.items()]
    if any(changed):
        systemd.systemctl("daemon-reload")
    systemd.systemctl("enable", *UNIT_TEXTS)


def list_installed_units(layout: Layout) -> list[Path]:
    """Return the paths of the existing unit files. After an interrupted removal, there may be only one."""
    return [unit for name in UNIT_TEXTS if (unit := layout.units / name).exists()]


def install_program(layout: Layout, sources: Mapping[str, str]) -> None:
    """Write the program, a ZIP file that Python can run, if it is new or has changed.

    sources: the source text of each module by its path, such as ``robotcore/deploy/agent/files.py``.
    """
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as file:
        for path, text in sorted({**sources, "__main__.py": _MAIN}.items()):
            file.writestr(zipfile.ZipInfo(path, _EPOCH), text)
    _write_if_changed(layout.program, content.getvalue())


def _write_if_changed(path: Path, content: bytes) -> bool:
    if path.is_file() and path.read_bytes() == content:
        return False
    files.write_file(path, content)
    return True
