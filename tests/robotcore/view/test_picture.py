from __future__ import annotations

from pathlib import Path

import cv2
import pytest

from robotcore import RunRequest, run
from robotcore.errors import UsageError
from robotcore.runtime.layers.devices import LayeredCamera, LayeredDisplay
from robotcore.runtime.session import Run
from robotcore.view.picture import PictureRecorder, last_seen, require_writable

REQUEST = RunRequest("avoid-obstacles", world="open", settings={"duration_s": 1})


class Looker(PictureRecorder):
    """Keeps the run to look at what was recorded of it."""

    def begin(self, run: Run) -> None:
        super().begin(run)
        self.run = run


def test_records_the_true_pose_of_every_tick() -> None:
    recorder = Looker()
    result = run(REQUEST, [recorder])
    assert recorder.run.world
    steps = recorder._track.steps
    assert len(steps) == result.ticks
    assert steps[0].pose == recorder.run.world.start.pose
    assert steps[-1].pose.distance_to(*steps[0].pose[:2]) > 0.1


def test_reads_no_camera_that_the_app_does_not_read() -> None:
    recorder = Looker()
    run(REQUEST, [recorder])
    assert last_seen(recorder.run.robot) is None


def test_shows_the_apps_own_picture_before_the_cameras() -> None:
    recorder = Looker()
    run(RunRequest("mark-green", world="open", seed=3, settings={"duration_s": 0.2}), [recorder])
    display, camera = recorder.run.robot.display, recorder.run.robot.camera
    assert isinstance(display, LayeredDisplay)
    assert isinstance(camera, LayeredCamera)
    assert camera.latest is not None
    assert last_seen(recorder.run.robot) is display.latest is not camera.latest.image


def test_a_robot_without_truth_has_a_picture_without_a_path(tmp_path: Path) -> None:
    recorder = Looker()
    run(RunRequest("avoid-obstacles", backend="mock", settings={"duration_s": 0.2}), [recorder])
    recorder.save(tmp_path / "run.png")
    picture = cv2.imread(str(tmp_path / "run.png"))
    assert picture is not None
    assert picture.shape == (1000, 1600, 3)


def test_saving_says_why_it_cannot(tmp_path: Path) -> None:
    recorder = Looker()
    run(REQUEST, [recorder])
    with pytest.raises(UsageError, match="No such file or directory"):
        recorder.save(tmp_path / "missing" / "run.png")


def test_asking_whether_a_file_can_be_written_leaves_nothing_behind(tmp_path: Path) -> None:
    require_writable(tmp_path / "run.png")
    assert not list(tmp_path.iterdir())
