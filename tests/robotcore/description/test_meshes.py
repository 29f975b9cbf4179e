from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from robotcore.description.meshes import Mesh, ball_mesh, prism_mesh
from tests.drivers.physics.worlds import box, post

POST = prism_mesh(post(1.0, 2.0))


def triangles(mesh: Mesh) -> NDArray[np.float64]:
    vertices = np.array(mesh.vertices, dtype=np.float64)
    return vertices[mesh.indices].reshape(-1, 3, 3)


def enclosed(mesh: Mesh) -> float:
    """Return the volume of a mesh by the divergence theorem. It is negative if the faces point inwards."""
    a, b, c = triangles(mesh).transpose(1, 0, 2)
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def test_prism_mesh_has_the_volume_of_the_prism_and_outward_normals() -> None:
    assert enclosed(prism_mesh(box(0.0, length=0.4, width=0.6, height=0.5))) == pytest.approx(0.4 * 0.6 * 0.5)
    assert enclosed(POST) == pytest.approx(12 * 0.01 * math.sin(math.tau / 24) * 0.3)


def test_ball_mesh_has_nearly_the_volume_of_the_ball() -> None:
    assert enclosed(ball_mesh(0.1)) == pytest.approx(4 / 3 * math.pi * 0.001, rel=0.03)


@pytest.mark.parametrize("mesh", [POST, ball_mesh(0.1)], ids=["post", "ball"])
def test_normals_are_unit_vectors_and_point_outwards(mesh: Mesh) -> None:
    normals = np.array(mesh.normals)
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1.0)
    a, b, c = triangles(mesh).transpose(1, 0, 2)
    faces = np.cross(b - a, c - a)
    at_first = normals[np.array(mesh.indices)[::3]]
    areas = np.linalg.norm(faces, axis=1)
    real = areas > 1e-9
    assert (np.einsum("ij,ij->i", faces, at_first)[real] / areas[real] > 0.95).all()


def test_faces_of_a_prism_share_no_normal() -> None:
    normals = {tuple(np.round(normal, 9)) for normal in POST.normals}
    assert len(normals) == 24 + 2
