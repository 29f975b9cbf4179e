"""Joints, in the official binding's words: rad and N·m, or m and N where they slide."""
# ruff: noqa: N802, N803, N816, D103  the official binding's names; its manual says what they do

from __future__ import annotations

from collections.abc import Sequence

from drivers.vrep.simx.calls import read, read_list, send
from drivers.vrep.wire import requests
from drivers.vrep.wire.requests import of_handle
from drivers.vrep.wire.values import floats, packed_floats, read_float, read_nothing


def simxGetJointPosition(clientID: int, jointHandle: int, operationMode: int) -> tuple[int, float]:
    return read(clientID, requests.joint_position(jointHandle), operationMode, 0.0)


def simxSetJointPosition(clientID: int, jointHandle: int, position: float, operationMode: int) -> int:
    return _set(clientID, 0x1002, jointHandle, [position], operationMode)


def simxSetJointTargetVelocity(clientID: int, jointHandle: int, targetVelocity: float, operationMode: int) -> int:
    return send(clientID, requests.joint_target_velocity(jointHandle, targetVelocity), operationMode)


def simxSetJointTargetPosition(clientID: int, jointHandle: int, targetPosition: float, operationMode: int) -> int:
    return _set(clientID, 0x100C, jointHandle, [targetPosition], operationMode)


def simxGetJointMatrix(clientID: int, jointHandle: int, operationMode: int) -> tuple[int, list[float]]:
    return read_list(
        clientID, of_handle("tell the matrix of joint", 0x100A, jointHandle, floats(12)), operationMode, 12
    )


def simxSetSphericalJointMatrix(clientID: int, jointHandle: int, matrix: Sequence[float], operationMode: int) -> int:
    return _set(clientID, 0x100B, jointHandle, matrix, operationMode)


def simxGetJointForce(clientID: int, jointHandle: int, operationMode: int) -> tuple[int, float]:
    return read(clientID, of_handle("tell the force of joint", 0x100D, jointHandle, read_float), operationMode, 0.0)


def simxGetJointMaxForce(clientID: int, jointHandle: int, operationMode: int) -> tuple[int, float]:
    return read(clientID, of_handle("tell the force of joint", 0x1038, jointHandle, read_float), operationMode, 0.0)


def simxSetJointMaxForce(clientID: int, jointHandle: int, force: float, operationMode: int) -> int:
    return _set(clientID, 0x100E, jointHandle, [force], operationMode)


simxJointGetForce = simxGetJointForce
simxSetJointForce = simxSetJointMaxForce


def _set(client: int, command: int, joint: int, values: Sequence[float], mode: int) -> int:
    return send(client, of_handle("set joint", command, joint, read_nothing, packed_floats(*values)), mode)
