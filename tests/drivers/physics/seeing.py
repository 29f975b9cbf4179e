from __future__ import annotations

import math
import time
from pathlib import Path

import numpy as np
import pytest

from robotcore.description import (
    Light,
    Mount,
    RobotDescription,
    Start,
    Texture,
    WorldDescription,
    draw_world,
    load_world,
    randomise,
)
from robotcore.description.texture import PATTERNS, Pattern
from robotcore.geometry import Pose
from robotcore.kinds.camera import CameraDescription
from robotcore.optics import CameraView, Image, Intrinsics
from robotcore.simulation import body_cameras
from robotcore.simulation.painter import Painter
from robotcore.simulation.render_worker import RenderWorker, picture_queue
from robotcore.simulation.render_worker.client import _Process
from tests.drivers.physics.worlds import (
    LOOKOUT,
    ROVER,
    EngineTests,
    ball,
    box,
    drive,
    get_camera,
    get_truth,
    post,
    setup,
    world,
)
from tests.robotcore.description.courses import COURSE, load_course

EYE = Mount(x_m=0.14, z_m=0.10)


class Seeing(EngineTests):
    """Tests of the camera, for every engine."""

    @pytest.mark.parametrize("aside", [0.1300, 0.1315, 0.1330])
    def test_box_covers_the_pixels_of_the_pinhole_projection(self, aside: float) -> None:
        start = Start(x_m=0.3, y_m=-0.2, yaw_rad=0.7)
        at = start.pose.to_world(1.2, aside)
        thing = box(*at, length=0.2, width=0.31, height=0.17, yaw=start.yaw_rad)
        with self.open_robot(thing, start=start, with_camera=True) as robot:
            camera = get_camera(robot)
            view = CameraView.of(camera.intrinsics, EYE, start.pose)
            rows, columns = np.nonzero(camera.segmentation(view) == camera.things["box"])
        front = [start.pose.to_world(1.1, aside + side) for side in (0.155, -0.155)]
        corners = np.array([(*point, height) for point in front for height in (0.0, 0.17)])
        pixels = view.to_pixels(view.to_camera(corners))
        (left, top), (right, bottom) = pixels.min(axis=0), pixels.max(axis=0)
        assert (columns.min(), columns.max()) == (np.ceil(left), np.floor(right))
        assert rows.max() == np.floor(bottom)
        assert rows.min() == pytest.approx(top, abs=2.0)

    @pytest.mark.parametrize(
        "light, shade",
        [
            (Light(ambient=0.5, diffuse=0.0), 0.5),
            (Light(ambient=0.5, diffuse=0.0, brightness=0.8), 0.4),
            (Light(ambient=0.2, diffuse=0.6, azimuth_rad=np.pi, elevation_rad=0.5), 0.2 + 0.6 * np.cos(0.5)),
            (Light(ambient=0.0, diffuse=1.0, azimuth_rad=np.pi, elevation_rad=0.5, brightness=0.6), 0.6 * np.cos(0.5)),
            (Light(ambient=0.2, diffuse=0.6, azimuth_rad=0.0, elevation_rad=0.5), 0.2),
        ],
        ids=["ambient", "dimmed", "lit", "lit and dimmed", "from behind"],
    )
    def test_a_face_shows_ambient_and_diffuse_light(self, light: Light, shade: float) -> None:
        thing = box(0.5, width=4.0, height=1.0)
        with self.open_in_world(world(thing, light=light)) as robot:
            image = robot.camera.read().image
        assert image[120, 160].tolist() == pytest.approx([part * shade for part in (20, 40, 200)], abs=1.5)

    @pytest.mark.parametrize("described", [ROVER, LOOKOUT], ids=["rover", "lookout"])
    def test_own_body_is_not_in_the_picture(self, described: RobotDescription) -> None:
        with self.open_robot(robot=described, with_camera=True) as robot:
            camera = get_camera(robot)
            behind = CameraView.of(camera.intrinsics, EYE, Pose(-1.0, 0.0, 0.0))
            numbers = camera.segmentation(behind)
        assert len(np.unique(numbers)) == 2
        assert not np.isin(numbers, list(camera.things.values())).any()

    def test_pitched_camera_shows_the_view_of_its_mount(self) -> None:
        devices = tuple(
            device.model_copy(update={"mount": Mount(x_m=0.14, z_m=0.10, pitch_rad=0.6)})
            if isinstance(device, CameraDescription)
            else device
            for device in ROVER.devices
        )
        with self.open_robot(ball(0.6), robot=ROVER.model_copy(update={"devices": devices}), with_camera=True) as robot:
            camera = get_camera(robot)
            view = CameraView.of(camera.intrinsics, Mount(x_m=0.14, z_m=0.10, pitch_rad=0.6), Pose(0.0, 0.0, 0.0))
            assert (robot.camera.read().image == camera.picture(view)).all()


class Painting(EngineTests):
    """Tests of the painted camera, for every engine."""

    def test_a_painted_camera_shows_the_view_from_the_body_of_the_engine(self) -> None:
        ground = world(ball(0.8, 0.1), box(1.6, yaw=0.3), start=Start(x_m=0.1, y_m=-0.2, yaw_rad=0.3))
        with self.open_in_world(ground, camera="painted") as robot:
            drive(robot, 4.0, 6.0, 0.3)
            painted, truth = robot.camera.read().image, get_truth(robot).pose()
        view = CameraView.of(load_eye().intrinsics, EYE, truth)
        expected = Painter(ground).picture(view)
        assert (painted != expected).any(axis=2).mean() < 0.01  # the body sinks into the floor, and tilts a little
        assert (painted != Painter(ground).picture(CameraView.of(load_eye().intrinsics, EYE, HERE))).any()

    def test_the_segmentation_of_a_painted_camera_names_the_things_the_floor_and_the_sky(self) -> None:
        thing = box(1.2, 0.0, width=0.3, height=0.15)
        masks = []
        for choice in ("painted", "rendered"):
            with self.open_in_world(world(ball(0.8, 0.3), thing), camera=choice) as robot:
                camera = get_camera(robot)
                numbers = camera.segmentation(CameraView.of(camera.intrinsics, EYE, Pose(0.2, 0.0, 0.1)))
            assert set(camera.things) == {"ball", "box"}
            masks.append([numbers == camera.things["ball"], numbers == camera.things["box"], numbers == -1])
        for ours, theirs in zip(*masks, strict=True):
            assert (ours != theirs).mean() < 0.002
            assert ours.any()
            assert not ours.all()

    def test_painting_changes_no_motion(self) -> None:
        poses = []
        for choice in ("painted", "rendered"):
            with self.open_in_world(world(ball(0.8, 0.3)), camera=choice) as robot:
                drive(robot, 8.0, 5.0, 0.5)
                robot.camera.read()
                poses.append(get_truth(robot).pose())
        assert poses[0] == poses[1]


class RenderingAhead(EngineTests):
    """Tests that a process renders the pictures of a camera with a latency, for every engine."""

    @pytest.mark.slow
    @pytest.mark.linux("a worker needs Linux")
    @pytest.mark.parametrize("choice", ["rendered", "painted"])
    def test_pictures_of_another_process_are_equal_to_the_bit(
        self, choice: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        course = load_course(tmp_path, text=COURSE + LINES)
        course = course.model_copy(update={"obstacles": (box(2.0, width=0.4),), "targets": (ball(1.2, 0.3),)})
        taken = wait_for_workers(monkeypatch)
        pictures = []
        for has_core in (True, False):
            monkeypatch.setattr(body_cameras, "has_free_core", lambda has_core=has_core: has_core)
            pictures.append(self.watch(course, 0.05, choice))
            assert len(taken) == 6  # those that were captured after the first read
        for ours, theirs in zip(*pictures, strict=True):
            assert np.array_equal(ours, theirs)
        assert len({picture.tobytes() for picture in pictures[0]}) == 9

    @pytest.mark.parametrize(
        "latency_s, rate_hz",
        [(0.04, None), (0.05, 30.0), (4.0, None)],
        ids=["less than a tick", "many pictures a tick", "much memory"],
    )
    def test_a_camera_that_gains_nothing_starts_no_process(
        self, latency_s: float, rate_hz: float | None, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(picture_queue, "FIRST_PICTURES", 0)
        monkeypatch.setattr(body_cameras, "has_free_core", lambda: True)
        monkeypatch.setattr(body_cameras, "RenderWorker", None)
        assert len(self.watch(world(ball(0.8)), latency_s, "painted", rate_hz)) == 10

    def watch(
        self, described: WorldDescription, latency_s: float, choice: str, rate_hz: float | None = None
    ) -> list[np.ndarray]:
        """Return the pictures of ten ticks of a robot that turns, with a camera of this latency and rate."""
        late_eye = {"latency_s": latency_s, "rate_hz": rate_hz}
        devices = [
            device.model_copy(update=late_eye) if isinstance(device, CameraDescription) else device
            for device in ROVER.devices
        ]
        late = ROVER.model_copy(update={"devices": tuple(devices)})
        names = ["left_motor", "right_motor", "eye"]
        pictures = []
        with self.backend().open(setup(described, robot=late, devices=names, options={"camera": choice})) as robot:
            robot.motors["left_motor"].set_velocity(5.0)
            robot.motors["right_motor"].set_velocity(8.0)
            for tick in range(10):
                pictures.append(robot.camera.read().image)
                robot.clock.sleep_until((tick + 1) / 20)
        return pictures


def wait_for_workers(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Let each worker be ready for its first view. Return a list to which the numbers of taken pictures are added."""
    taken: list[int] = []
    is_ready, take = _Process.is_ready, RenderWorker.take

    def wait_until_ready(process: _Process) -> bool:
        while not is_ready(process):
            time.sleep(0.01)
        return True

    def take_noted(worker: RenderWorker, number: int, lens: Intrinsics, patience_s: float) -> Image | None:
        taken.append(number)
        return take(worker, number, lens, patience_s)

    monkeypatch.setattr(picture_queue, "FIRST_PICTURES", 1)
    monkeypatch.setattr(picture_queue, "MIN_PATIENCE_S", 30.0)
    monkeypatch.setattr(picture_queue, "MAX_CREDIT", 1e9)
    monkeypatch.setattr(_Process, "is_ready", wait_until_ready)
    monkeypatch.setattr(RenderWorker, "take", take_noted)
    return taken


def load_eye() -> CameraDescription:
    eye = ROVER.first_of(CameraDescription)
    assert eye
    return eye


MIN_PIXELS = 150
HERE = Pose(0.0, 0.0, 0.0)
LINES = """
[[lines]]
width_m = 0.05
points_m = [[-0.5, -0.4], [0.6, 0.0], [0.8, 0.6]]

[[lines]]
width_m = 0.02
points_m = [[-0.4, 0.3], [1.6, 0.3]]
colour = "red"
"""

Mask = np.ndarray


class Texturing(EngineTests):
    """Tests that an engine shows textures as the built-in simulator does."""

    @pytest.mark.parametrize("pattern", PATTERNS)
    def test_textures_equal_those_of_the_built_in_simulator(self, pattern: Pattern) -> None:
        texture = Texture(pattern=pattern, scale_m=0.8, contrast=0.5)
        plain = box(1.2, 0.5, width=0.4, yaw=0.4), post(0.9, -0.2)
        things = [thing.model_copy(update={"texture": texture}) for thing in plain]
        ground = world(*things, ball(0.8, 0.15))
        ground = ground.model_copy(update={"floor": ground.floor.model_copy(update={"texture": texture})})
        ours, theirs, _ = self.render_both(ground, HERE)
        is_near = np.arange(240) > 140
        differences = np.abs(ours.astype(int) - theirs).max(axis=2)
        assert (differences[is_near] <= 2).mean() > 0.98
        assert (differences <= 2).mean() > 0.9

    @pytest.mark.slow
    @pytest.mark.parametrize(
        "texture", [None, Texture(pattern="checker", scale_m=0.8, contrast=0.5)], ids=["plain", "pattern"]
    )
    @pytest.mark.parametrize("pose", [Pose(-0.6, -0.3, 0.2), Pose(0.3, -0.3, 2.0)], ids=["beside", "on it"])
    def test_picture_and_lines_on_the_floor_equal_those_of_the_built_in_simulator(
        self, tmp_path: Path, texture: Texture | None, pose: Pose
    ) -> None:
        course = load_course(tmp_path, text=COURSE + LINES)
        floor = course.floor.model_copy(update={"texture": texture})
        lit = Light(ambient=0.3, diffuse=0.6, brightness=1.2)
        things = (box(2.0, width=0.4),)
        ground = course.model_copy(update={"floor": floor, "light": lit, "obstacles": things})
        ours, theirs, _ = self.render_both(ground, pose)
        is_near = np.arange(240) > 140
        differences = np.abs(ours.astype(int) - theirs).max(axis=2)
        assert (differences[is_near] <= 2).mean() > (0.98 if texture else 0.995)
        assert len(np.unique(theirs[is_near].reshape(-1, 3), axis=0)) >= 3

    @pytest.mark.slow
    def test_picture_and_lines_on_the_floor_change_no_motion(self, tmp_path: Path) -> None:
        course = load_course(tmp_path, text=COURSE + LINES)
        bare = course.model_copy(update={"lines": (), "floor": course.floor.model_copy(update={"image": None})})
        poses = []
        for described in (course, bare):
            with self.open_in_world(described) as robot:
                drive(robot, 8.0, 5.0, 2.0)
                robot.range.read()
                poses.append((get_truth(robot).pose(), robot.range.read().distance))
        assert poses[0] == poses[1]

    def test_overexposed_texture_equals_that_of_the_built_in_simulator(self) -> None:
        texture = Texture(pattern="planks", scale_m=0.3, contrast=0.5)
        wall = box(1.2, width=3.0, height=1.0).model_copy(update={"texture": texture, "colour": (250, 240, 230)})
        facing = Light(azimuth_rad=math.pi, elevation_rad=0.3, brightness=1.4)
        ours, theirs, masks = self.render_both(world(wall, light=facing), HERE)
        mine, other = masks["box"]
        assert ours[mine].mean(axis=0) == pytest.approx(theirs[other].mean(axis=0), abs=2.0)

    @pytest.mark.slow
    @pytest.mark.parametrize("name, seed", [("arena", 1), ("arena", 9), ("clutter", 4), ("open", 10), ("occluded", 11)])
    def test_colours_of_a_randomised_world_equal_the_built_in_simulator(self, name: str, seed: int) -> None:
        drawn = randomise(draw_world(load_world(name), ROVER, seed), seed).world
        ours, theirs, masks = self.render_both(drawn, drawn.start.pose)
        assert masks
        for thing, (mine, other) in masks.items():
            assert ours[mine].mean(axis=0) == pytest.approx(theirs[other].mean(axis=0), abs=3.0), thing

    def render_both(
        self, described: WorldDescription, pose: Pose
    ) -> tuple[np.ndarray, np.ndarray, dict[str, tuple[Mask, Mask]]]:
        """Return the pictures of the painter and of the engine, and the masks of each thing in both, by name.

        Things with few pixels in one of the pictures are left out.
        """
        painter = Painter(described)
        start = Start(x_m=pose.x, y_m=pose.y, yaw_rad=pose.heading)
        with self.open_in_world(described.model_copy(update={"start": start})) as robot:
            camera = get_camera(robot)
            view = CameraView.of(camera.intrinsics, EYE, pose)
            theirs, numbers, labels = camera.picture(view), camera.segmentation(view), painter.labels(view)
        masks = {thing: (labels == n, numbers == camera.things[thing]) for n, thing in enumerate(painter.things, 1)}
        is_below = np.arange(len(labels))[:, None] >= 121
        masks["floor"] = ((labels == 0) & is_below, ~np.isin(numbers, list(camera.things.values())) & is_below)
        return painter.picture(view), theirs, {n: m for n, m in masks.items() if min(x.sum() for x in m) > MIN_PIXELS}
