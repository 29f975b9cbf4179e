"""The second tutorial's program: v1 shows the picture of camera v0, with a yellow rectangle around the green ball.

Start the simulator with a scene that has both vision sensors, then this. One line is changed: the import.
"""

from __future__ import annotations

import sys

import cv2
import numpy as np

from drivers.vrep import simx as vrep  # was: import vrep

GREENEST_HSV, LEAST_GREEN_HSV = (80, 255, 255), (40, 80, 40)
YELLOW_RGB = (255, 255, 0)


def main(port: int, frames: int, patience_ms: int = 5000) -> list[tuple[int, int, int, int]]:
    """Relay ``frames`` pictures, and return the ball's left, top, width and height in each picture, in pixels."""
    vrep.simxFinish(-1)
    client = vrep.simxStart("127.0.0.1", port, True, True, patience_ms, 5)
    if client == -1:
        sys.exit("The simulator does not answer. Start it, and the simulation's scene, then this program again.")
    vrep.simxStartSimulation(client, vrep.simx_opmode_oneshot_wait)
    try:
        return relay(client, frames)
    finally:
        vrep.simxStopSimulation(client, vrep.simx_opmode_oneshot_wait)
        vrep.simxFinish(client)


def relay(client: int, frames: int) -> list[tuple[int, int, int, int]]:
    _, eye = vrep.simxGetObjectHandle(client, "v0", vrep.simx_opmode_oneshot_wait)
    _, screen = vrep.simxGetObjectHandle(client, "v1", vrep.simx_opmode_oneshot_wait)
    vrep.simxGetVisionSensorImage(client, eye, 0, vrep.simx_opmode_streaming)
    marks: list[tuple[int, int, int, int]] = []
    while len(marks) < frames and vrep.simxGetConnectionId(client) != -1:
        code, resolution, image = vrep.simxGetVisionSensorImage(client, eye, 0, vrep.simx_opmode_buffer)
        if code == vrep.simx_return_ok and any(image):
            width, height = resolution
            picture = np.array(image, np.int8).view(np.uint8).reshape(height, width, 3)
            upright = np.ascontiguousarray(picture[::-1])
            marks.append(mark_ball(upright))
            vrep.simxSetVisionSensorImage(client, screen, upright[::-1].ravel(), 0, vrep.simx_opmode_oneshot)
        vrep.simxGetPingTime(client)
    return marks


def mark_ball(picture: np.ndarray) -> tuple[int, int, int, int]:
    """Draw a rectangle around the green pixels of an RGB picture, and return its left, top, width and height."""
    green = cv2.inRange(cv2.cvtColor(picture, cv2.COLOR_RGB2HSV), np.array(LEAST_GREEN_HSV), np.array(GREENEST_HSV))
    left, top, width, height = cv2.boundingRect(green)
    if width:
        cv2.rectangle(picture, (left, top), (left + width - 1, top + height - 1), YELLOW_RGB, 1)
    return left, top, width, height
