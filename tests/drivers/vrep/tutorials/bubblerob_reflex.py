"""The first tutorial's program: bubbleRob drives, and backs up while turning when its nose detects something.

Start the simulator with the tutorial's scene, then this. One line is changed: the import.
"""

from __future__ import annotations

import math
import sys

from drivers.vrep import simx as vrep  # was: import vrep

SPEED_RAD_S = 4.0
BACK_UP_S = 1.5
NEAR_M = 0.2


def main(port: int, duration_s: float, patience_ms: int = 5000) -> list[tuple[float, float]]:
    """Drive for ``duration_s``, and return the time and the distance of each detection that made bubbleRob back up."""
    vrep.simxFinish(-1)
    client = vrep.simxStart("127.0.0.1", port, True, True, patience_ms, 5)
    if client == -1:
        sys.exit("The simulator does not answer. Start it, and the simulation's scene, then this program again.")
    try:
        vrep.simxSynchronous(client, True)
        vrep.simxStartSimulation(client, vrep.simx_opmode_oneshot_wait)
        return drive(client, duration_s)
    finally:
        vrep.simxStopSimulation(client, vrep.simx_opmode_oneshot_wait)
        vrep.simxFinish(client)


def drive(client: int, duration_s: float, patience_ms: int = 5000) -> list[tuple[float, float]]:
    left, right, nose = (
        vrep.simxGetObjectHandle(client, name, vrep.simx_opmode_oneshot_wait)[1]
        for name in ("bubbleRob_leftMotor", "bubbleRob_rightMotor", "bubbleRob_sensingNose")
    )
    vrep.simxReadProximitySensor(client, nose, vrep.simx_opmode_streaming)
    seen: list[tuple[float, float]] = []
    now_s, back_up_until_s = 0.0, -1.0
    while now_s < duration_s and vrep.simxGetConnectionId(client) != -1:
        vrep.simxSynchronousTrigger(client)
        vrep.simxGetPingTime(client)
        code, is_detected, point, _, _ = vrep.simxReadProximitySensor(client, nose, vrep.simx_opmode_buffer)
        now_s = vrep.simxGetLastCmdTime(client) / 1000
        if code == vrep.simx_return_ok and is_detected and math.hypot(*point) < NEAR_M and now_s > back_up_until_s:
            seen.append((now_s, math.hypot(*point)))
            back_up_until_s = now_s + BACK_UP_S
        is_backing_up = now_s < back_up_until_s
        speeds = (-SPEED_RAD_S / 2, -SPEED_RAD_S / 8) if is_backing_up else (SPEED_RAD_S, SPEED_RAD_S)
        vrep.simxPauseCommunication(client, True)
        vrep.simxSetJointTargetVelocity(client, left, speeds[0], vrep.simx_opmode_oneshot)
        vrep.simxSetJointTargetVelocity(client, right, speeds[1], vrep.simx_opmode_oneshot)
        vrep.simxPauseCommunication(client, False)
    return seen
