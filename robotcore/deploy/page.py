"""The live page of a robot's app, through the ssh connection."""

from __future__ import annotations

from http.client import HTTPConnection, HTTPException

from robotcore.deploy.robot_answers import StatusAnswer
from robotcore.deploy.rpc import RobotLink
from robotcore.errors import DeployError

ANSWER_S = 10.0
"""The longest wait for the page's answer, in seconds."""

RUNNING = ("running", "starting", "restarting")
"""The states of an app whose page can be shown."""


def forward_page(link: RobotLink) -> str:
    """Forward a port of this machine to the page of the app on a robot, and return the link to it.

    The forwarding ends with the connection. Raises DeployError if no app runs, if it has no page, or if the page does
    not answer.
    """
    host, status = link.host, link.call("status", StatusAnswer)
    if status.state not in RUNNING:
        problem = f"no app runs ({status.release}: {status.state})" if status.release else "no release is on the robot"
        remedy = host.format_command("start" if status.release else "push --view")
        raise DeployError(f"{host}: {problem}, so there is no live page. Start it: {remedy}", kind="no-running-app")
    if status.view_port is None:
        raise DeployError(
            f"{host}: {status.release} has no live page. Push it with one: {host.format_command('push --view')}",
            kind="no-page",
        )
    port = link.forward(status.view_port)
    if not _has_page(port):
        raise DeployError(
            f"{host}: the live page does not answer at port {status.view_port} of the robot. Look whether the app has "
            f"just begun: {host.format_command('logs')}. If it runs, allow forwarding in the robot's sshd_config: "
            "AllowTcpForwarding local",
            kind="silent-page",
            port=status.view_port,
        )
    return f"http://127.0.0.1:{port}/"


def _has_page(port: int) -> bool:
    connection = HTTPConnection("127.0.0.1", port, timeout=ANSWER_S)
    try:
        connection.request("GET", "/")
        return connection.getresponse().status == 200
    except (OSError, HTTPException):
        return False
    finally:
        connection.close()
