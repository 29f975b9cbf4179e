"""Connecting, time and the simulation: the official binding's functions about the simulator as a whole."""
# ruff: noqa: N802, N803, D103  the official binding's names; its manual says what the short ones do

from __future__ import annotations

from drivers.vrep.simx import constants as c
from drivers.vrep.simx.clients import CLIENTS, REPLY_TIMEOUT_S, Terms, read, send
from drivers.vrep.wire import requests
from drivers.vrep.wire.messages import VERSION, Header
from drivers.vrep.wire.values import read_nothing
from robotcore.hal.wall_clock import MonotonicClock

_CLOCK = MonotonicClock()
_CONNECT_TIMEOUT_MS = 5000


def simxStart(
    connectionAddress: str | bytes,
    connectionPort: int,
    waitUntilConnected: bool,  # noqa: FBT001
    doNotReconnectOnceDisconnected: bool,  # noqa: FBT001
    timeOutInMs: int,
    commThreadCycleInMs: int,
) -> int:
    """Return the number of a new client; -1 if none could connect, or another one has that address.

    A negative time-out is that of blocking calls. Ports below zero, shared memory, are not served.
    """
    host = connectionAddress.decode() if isinstance(connectionAddress, bytes) else str(connectionAddress)
    terms = Terms(
        period_s=max(commThreadCycleInMs, 1) / 1000,
        patience_s=(timeOutInMs if timeOutInMs >= 0 else _CONNECT_TIMEOUT_MS) / 1000,
        reply_timeout_s=-timeOutInMs / 1000 if timeOutInMs < 0 else REPLY_TIMEOUT_S,
        reconnects=not doNotReconnectOnceDisconnected,
    )
    client = CLIENTS.start((host, int(connectionPort)), terms) if 0 <= connectionPort <= 0xFFFF else -1
    known = CLIENTS.get(client)
    if waitUntilConnected and known and not known.mailbox.wait_connected(terms.patience_s):
        CLIENTS.finish(client)
        return -1
    return client


def simxFinish(clientID: int) -> None:
    """End a client, or with -1 all, once the server has done what it was told."""
    CLIENTS.finish(clientID)


def simxGetConnectionId(clientID: int) -> int:
    """Return which connection of this client's it is, from 1; -1 while there is none."""
    client = CLIENTS.get(clientID)
    return client.mailbox.connections if client and client.mailbox.is_connected else -1


def simxGetPingTime(clientID: int) -> tuple[int, int]:
    """Return the code and how many ms the server took over a command, a step of the simulation included."""
    if CLIENTS.get(clientID) is None:
        return c.simx_return_ok, 0
    start = _CLOCK.now()
    code, _ = read(clientID, requests.CLOCK, c.simx_opmode_blocking, 0)
    return code & ~c.simx_return_remote_error_flag, round((_CLOCK.now() - start) * 1000)


def simxGetLastCmdTime(clientID: int) -> int:
    """Return the simulation's time in ms at which the command was done whose answer was last looked at."""
    client = CLIENTS.get(clientID)
    return client.last_command_ms if client else 0


def simxGetInMessageInfo(clientID: int, infoType: int) -> tuple[int, int]:
    """Return 1 and what the newest message says at `simx_headeroffset_…`; -1 and 0 if nothing does."""
    client = CLIENTS.get(clientID)
    if client is None or (server := client.mailbox.server) is None:
        return -1, 0
    info = _info(server).get(infoType)
    return (-1, 0) if info is None else (1, info)


def simxGetOutMessageInfo(clientID: int, infoType: int) -> tuple[int, int]:
    """Return 1 and what the next message will say at `simx_headeroffset_…`; -1 and 0 if nothing does."""
    if infoType == c.simx_headeroffset_version:
        return 1, VERSION
    if infoType == c.simx_headeroffset_client_time:
        return 1, int(_CLOCK.now() * 1000)
    client = CLIENTS.get(clientID)
    return (1, client.mailbox.number) if client and infoType == c.simx_headeroffset_message_id else (-1, 0)


def simxPauseCommunication(clientID: int, enable: bool) -> int:  # noqa: FBT001
    """Hold back what is sent, so that it goes out in one message when communication goes on."""
    if (client := CLIENTS.get(clientID)) is None:
        return c.simx_return_initialize_error_flag
    client.mailbox.hold(held=bool(enable))
    return c.simx_return_ok


def simxSynchronous(clientID: int, enable: bool) -> int:  # noqa: FBT001
    """Let the simulation wait for a trigger before each step, or go on by itself."""
    return send(clientID, requests.SYNCHRONOUS_ON if enable else requests.SYNCHRONOUS_OFF, c.simx_opmode_blocking)


def simxSynchronousTrigger(clientID: int) -> int:
    """Let the simulation take one step. It has been taken when a later command is answered."""
    return send(clientID, requests.TRIGGER, c.simx_opmode_blocking)


def simxStartSimulation(clientID: int, operationMode: int) -> int:
    return send(clientID, requests.START, operationMode)


def simxPauseSimulation(clientID: int, operationMode: int) -> int:
    return send(clientID, requests.PAUSE, operationMode)


def simxStopSimulation(clientID: int, operationMode: int) -> int:
    return send(clientID, requests.STOP, operationMode)


def simxGetLastErrors(clientID: int, operationMode: int) -> tuple[int, list[str]]:
    """Return what went wrong at the server since the last time this was asked, 50 messages at most."""
    return read(clientID, requests.LAST_ERRORS, operationMode, [])


def simxAddStatusbarMessage(clientID: int, message: str | bytes, operationMode: int) -> int:
    return send(clientID, requests.statusbar_message(message), operationMode)


def simxLoadScene(clientID: int, scenePathAndName: str | bytes, options: int, operationMode: int) -> int:
    """Load a scene from the server's disk; scenes of the client's (option bit 0) are not transferred."""
    if options & 1:
        return c.simx_return_local_error_flag
    return send(clientID, requests.of_name("load", 0x3002, scenePathAndName, read_nothing), operationMode)


def simxCloseScene(clientID: int, operationMode: int) -> int:
    return send(clientID, requests.of_nothing("close the scene", 0x0005, read_nothing), operationMode)


def _info(server: Header) -> dict[int, int]:
    return {
        c.simx_headeroffset_version: server.version,
        c.simx_headeroffset_message_id: server.message,
        c.simx_headeroffset_client_time: server.client_time_ms,
        c.simx_headeroffset_server_time: server.server_time_ms,
        c.simx_headeroffset_scene_id: server.scene,
        c.simx_headeroffset_server_state: server.state,
    }
