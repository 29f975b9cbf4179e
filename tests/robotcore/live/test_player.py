"""``robotcore view``: recordings on the live page, in a real Chromium."""

from __future__ import annotations

import json
import re
import shutil
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Literal

import pytest
from playwright.sync_api import Browser, FrameLocator, Page, expect
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect
from websockets.typing import Origin

from robotcore import Behaviour, Robot, Role, RunRequest, Status, run
from robotcore.recording.recorder import Recorder
from robotcore.runtime.observer import Observer, RunContext
from robotcore.runtime.result import RunResult
from robotcore.runtime.trace import TickRecord
from tests.robotcore.cli.conftest import Cli
from tests.robotcore.cli.conftest import cli as cli  # noqa: PLC0414  a fixture
from tests.robotcore.live.chromium import find_bottom, measure
from tests.robotcore.live.live_run import Circles
from tests.robotcore.live.test_page import LINK_HINT
from tests.texts import CheckText

pytestmark = pytest.mark.slow


class Watch:
    """Starts ``robotcore view`` with arguments, and returns the page's link. The end of the test ends the command."""

    def __init__(self, stack: ExitStack) -> None:
        self._stack = stack

    def __call__(self, *arguments: object) -> str:
        command = [sys.executable, "-m", "robotcore", "view", *map(str, arguments)]
        self._process = self._stack.enter_context(
            subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        )
        self._stack.callback(self._process.terminate)
        assert self._process.stdout
        return self._process.stdout.readline().rpartition(" ")[2].strip()

    def stop(self) -> None:
        self._process.terminate()
        self._process.wait(10)


class LatePicture(Behaviour):
    """Reads the camera after one second."""

    needs = frozenset({Role.CAMERA})

    def step(self, robot: Robot) -> Status:
        if robot.clock.now() > 1.0:
            robot.camera.read()
        return Status.RUNNING


class HandDriver:
    """Drives the robot by hand from 1 s to 2 s."""

    def begin(self, run: RunContext) -> None:
        assert run.operator
        self._operator = run.operator

    def tick(self, record: TickRecord) -> None:
        if 1.0 <= record.time < 2.0:
            self._operator.drive(0.1, 0.0)
        elif record.time >= 2.0:
            self._operator.release()

    def end(self, result: RunResult) -> None:
        pass


def record(file: Path, observers: Sequence[Observer] = (), *, is_jpeg: bool = False, **request: object) -> Path:
    recorder = Recorder(file, is_jpeg=is_jpeg)
    fields = {"app": Circles, "world": "arena", "timeout_s": 4.0, **request}
    run(RunRequest(**fields), [recorder, *observers], [recorder.layer])  # type: ignore[arg-type]
    return file


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record(tmp_path_factory.mktemp("recorded") / "run.mcap")


@pytest.fixture
def watch() -> Iterator[Watch]:
    with ExitStack() as stack:
        yield Watch(stack)


def open_frame(page: Page, number: int = 1) -> FrameLocator:
    return page.frame_locator(f"section:nth-of-type({number}) iframe")


def slide(page: Page, time: float) -> None:
    page.locator("#slider").evaluate(
        "(slider, time) => { slider.value = time; slider.dispatchEvent(new Event('input')); }", time
    )


def test_the_slider_shows_the_recorded_state_and_picture_of_its_time(page: Page, watch: Watch, recorded: Path) -> None:
    page.goto(watch(recorded))
    frame = open_frame(page)
    expect(frame.locator("#where")).to_have_text("kinematic · rover · arena")
    expect(frame.locator("#time")).to_have_text("0.0 s")
    box = page.locator("iframe").bounding_box()
    assert box
    assert (box["width"], box["height"] > 600) == (1280, True)
    slide(page, 3.0)
    expect(frame.locator("#time")).to_have_text("3.0 s")
    expect(frame.locator("#state")).to_have_text("turning")
    expect(frame.locator("#values dd")).to_contain_text(" m")
    expect(frame.locator("#camera")).to_have_attribute("data-count", re.compile("[2-9]"))
    shown = page.frames[1].evaluate("document.querySelector('#camera').toDataURL()")
    plot = page.frames[1].evaluate("document.querySelector('#wheels').toDataURL()")
    slide(page, 1.0)
    expect(frame.locator("#time")).to_have_text("1.0 s")
    assert page.frames[1].evaluate("document.querySelector('#wheels').toDataURL()") != plot
    page.wait_for_timeout(300)
    assert page.frames[1].evaluate("document.querySelector('#camera').toDataURL()") != shown
    expect(frame.locator("#estop")).to_be_hidden()
    expect(frame.locator("#log")).to_contain_text("milestone: turning")


def test_each_press_of_a_key_is_one_tick_also_if_the_person_types_fast(
    page: Page, watch: Watch, recorded: Path
) -> None:
    page.goto(watch(recorded))
    expect(page.locator("#clock")).to_have_text("0.00 s of 4.00 s")
    for _ in range(30):
        page.keyboard.press("ArrowRight")
    expect(page.locator("#clock")).to_have_text("1.50 s of 4.00 s")
    for _ in range(10):
        page.keyboard.press("ArrowLeft")
    expect(page.locator("#clock")).to_have_text("1.00 s of 4.00 s")


def test_play_pause_and_one_tick_at_a_time(page: Page, watch: Watch, recorded: Path) -> None:
    page.goto(watch(recorded))
    frame = open_frame(page)
    expect(frame.locator("#time")).to_have_text("0.0 s")
    page.locator("#forward").click()
    expect(page.locator("#clock")).to_have_text("0.05 s of 4.00 s")
    page.locator("#forward").click()
    expect(page.locator("#clock")).to_have_text("0.10 s of 4.00 s")
    page.locator("#back").click()
    expect(page.locator("#clock")).to_have_text("0.05 s of 4.00 s")
    frame.locator("h1").click()
    page.keyboard.press("ArrowRight")  # in the frame, which passes the keys of the player
    expect(page.locator("#clock")).to_have_text("0.10 s of 4.00 s")
    page.keyboard.press("ArrowLeft")
    expect(page.locator("#clock")).to_have_text("0.05 s of 4.00 s")
    page.keyboard.press("Control+ArrowRight")
    page.wait_for_timeout(200)
    expect(page.locator("#clock")).to_have_text("0.05 s of 4.00 s")
    page.keyboard.press("Space")  # no e-stop
    expect(page.locator("#play")).to_have_text("Pause")
    expect(frame.locator("#time")).to_have_text("4.0 s", timeout=15_000)
    expect(page.locator("#play")).to_have_text("Play")
    expect(frame.locator("#log")).to_contain_text("timeout, 81 ticks")
    page.locator("#forward").focus()
    page.keyboard.press("Space")  # plays from the beginning; the focused button is not pressed
    expect(page.locator("#play")).to_have_text("Pause")
    page.keyboard.press("Space")
    expect(page.locator("#play")).to_have_text("Play")
    slide(page, 2.0)
    page.locator("#slider").focus()
    page.keyboard.press("ArrowRight")
    expect(page.locator("#clock")).to_have_text("2.05 s of 4.00 s")


def test_home_and_end_show_the_first_and_the_last_tick(page: Page, watch: Watch, recorded: Path) -> None:
    page.goto(watch(recorded))
    frame = open_frame(page)
    expect(frame.locator("#time")).to_have_text("0.0 s")
    page.keyboard.press("End")
    expect(frame.locator("#time")).to_have_text("4.0 s")
    expect(page.locator("#clock")).to_have_text("4.00 s of 4.00 s")
    frame.locator("h1").click()
    page.keyboard.press("Home")  # in the frame, which passes the keys of the player
    expect(frame.locator("#time")).to_have_text("0.0 s")
    expect(page.locator("#clock")).to_have_text("0.00 s of 4.00 s")


def test_the_speed_of_playing(page: Page, watch: Watch, recorded: Path) -> None:
    page.goto(watch(recorded))
    expect(open_frame(page).locator("#time")).to_have_text("0.0 s")
    took = []
    for speed in ("10×", "2×"):
        page.locator("#speed button", has_text=speed).last.click()
        slide(page, 0.0)
        begin = page.evaluate("performance.now()")
        page.locator("#play").click()
        expect(page.locator("#play")).to_have_text("Pause")
        expect(page.locator("#play")).to_have_text("Play", timeout=15_000)
        took.append(page.evaluate("performance.now()") - begin)
    assert took[0] < 1_600, "4 s at 10 times real time"
    assert took[1] > 1_900, "4 s at 2 times real time"


def test_each_viewer_sees_the_time_that_another_chooses(page: Page, watch: Watch, recorded: Path) -> None:
    link = watch(recorded)
    page.goto(link)
    other = page.context.new_page()
    other.goto(link)
    slide(page, 2.0)
    expect(other.locator("#clock")).to_have_text("2.00 s of 4.00 s")
    expect(open_frame(other).locator("#time")).to_have_text("2.0 s")


def test_prints_and_hand_driving_are_shown_at_their_ticks(page: Page, watch: Watch, tmp_path: Path) -> None:
    page.goto(watch(record(tmp_path / "driven.mcap", [HandDriver()], has_operator=True)))
    frame = open_frame(page)
    expect(frame.locator("#log")).to_contain_text("the circles begin")
    slide(page, 1.5)
    expect(frame.locator("#notices")).to_have_text("a person drives the robot")
    page.wait_for_timeout(1500)
    expect(frame.locator("#notices")).to_have_text("a person drives the robot")
    slide(page, 0.5)
    expect(frame.locator("#notices")).to_have_text("")


def test_a_picture_is_not_shown_before_its_time(page: Page, watch: Watch, tmp_path: Path) -> None:
    page.goto(watch(record(tmp_path / "late.mcap", app=LatePicture, timeout_s=2.0)))
    slide(page, 2.0)
    frame = open_frame(page)
    expect(frame.locator("#camera")).to_have_attribute("data-count", re.compile("[1-9]"))
    count = "document.querySelector('#camera').dataset.count"
    before = page.frames[1].evaluate(count)
    slide(page, 0.5)
    expect(frame.locator("#camera")).not_to_have_attribute("data-count", before)
    corner = "[...document.querySelector('#camera').getContext('2d').getImageData(0, 0, 1, 1).data]"
    assert page.frames[1].evaluate(corner) == pytest.approx([128, 128, 128, 255], abs=2)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_window_of_a_phone_shows_two_recordings_and_the_slider(
    browser: Browser, watch: Watch, recorded: Path, scheme: Literal["light", "dark"]
) -> None:
    context = browser.new_context(
        viewport={"width": 360, "height": 640}, has_touch=True, is_mobile=True, color_scheme=scheme
    )
    page = context.new_page()
    page.goto(watch(recorded, recorded))
    expect(open_frame(page, 2).locator("#time")).to_have_text("0.0 s")
    assert page.evaluate("[document.documentElement.scrollWidth, document.documentElement.scrollHeight]") == [360, 640]
    box = page.locator("footer").bounding_box()
    assert box
    assert box["y"] + box["height"] == pytest.approx(640, abs=1)
    page.locator("#forward").tap()
    expect(open_frame(page, 2).locator("#time")).to_have_text("0.1 s")
    light = page.evaluate("getComputedStyle(document.querySelector('footer')).backgroundColor") == "rgb(255, 255, 255)"
    assert light == (scheme == "light")
    context.close()


def test_the_page_loads_only_its_own_files(page: Page, watch: Watch, recorded: Path) -> None:
    link, urls = watch(recorded), []
    page.on("request", lambda request: urls.append(request.url))
    page.goto(link)
    expect(open_frame(page).locator("#time")).to_have_text("0.0 s")
    assert len(urls) > 5
    assert all(url.startswith(link) for url in urls)


def test_two_recordings_of_different_length_side_by_side(
    page: Page, watch: Watch, recorded: Path, tmp_path: Path
) -> None:
    short = record(tmp_path / "short.mcap", timeout_s=1.0)
    page.goto(watch(recorded, short))
    slide(page, 2.5)
    expect(open_frame(page, 1).locator("#time")).to_have_text("2.5 s")
    expect(open_frame(page, 2).locator("#time")).to_have_text("1.0 s")
    expect(page.locator("section:nth-of-type(2) h2")).to_have_text("short.mcapended at 1.00 s")


@pytest.mark.parametrize("width, height", [(1280, 900), (390, 844)])
def test_two_recordings_show_their_cameras_and_their_paths_without_scrolling(
    browser: Browser, watch: Watch, recorded: Path, width: int, height: int
) -> None:
    page = browser.new_page(viewport={"width": width, "height": height})
    page.goto(watch(recorded, recorded))
    for number in (1, 2):
        frame = open_frame(page, number)
        expect(frame.locator("#camera")).to_have_attribute("data-count", re.compile("[1-9]"))
        bottom = find_bottom(page.locator(f"section:nth-of-type({number}) iframe"))
        for canvas in map(frame.locator, ("#camera", "#map")):
            assert measure(canvas)["width"] > 120
            assert find_bottom(canvas) <= bottom
    page.close()


def test_a_notice_in_a_recording_moves_nothing(page: Page, watch: Watch, tmp_path: Path) -> None:
    page.goto(watch(record(tmp_path / "driven.mcap", [HandDriver()], has_operator=True)))
    frame = open_frame(page)
    expect(frame.locator("#camera")).to_have_attribute("data-count", re.compile("[1-9]"))
    before = measure(frame.locator("#map"))
    slide(page, 1.5)
    expect(frame.locator("#notices li")).to_be_visible()
    assert measure(frame.locator("#map")) == before


def test_a_jpeg_recording_and_one_without_pictures(page: Page, watch: Watch, tmp_path: Path) -> None:
    jpeg = record(tmp_path / "jpeg.mcap", is_jpeg=True, timeout_s=1.0)
    plain = record(tmp_path / "plain.mcap", app="avoid-obstacles", timeout_s=1.0)
    page.goto(watch(jpeg, plain))
    expect(open_frame(page, 1).locator("#camera")).to_have_attribute("data-count", re.compile("[1-9]"))
    expect(open_frame(page, 2).locator("#time")).to_have_text("0.0 s")
    expect(open_frame(page, 2).locator("#camera-card")).to_be_hidden()


@pytest.mark.parametrize("damage", ["cut", "changed"])
def test_the_intact_part_of_a_bad_file_is_shown_with_what_is_missing(
    page: Page, watch: Watch, recorded: Path, tmp_path: Path, damage: str
) -> None:
    content, file = bytearray(recorded.read_bytes()), tmp_path / "bad.mcap"
    if damage == "cut":
        del content[len(content) // 2 :]
    else:
        middle = len(content) // 2
        content[middle : middle + 40] = bytes(40)
    file.write_bytes(content)
    page.goto(watch(file))
    expect(page.locator(".problems li").first).to_contain_text("cut" if damage == "cut" else "damaged")
    slide(page, 0.5)
    expect(open_frame(page).locator("#time")).to_have_text("0.5 s")


def test_the_page_needs_its_token_and_its_own_origin(watch: Watch, recorded: Path) -> None:
    link = watch(recorded, "--listen", "0.0.0.0:0")
    place, _, token = link.removeprefix("http://").partition("/#token=")
    place = f"127.0.0.1:{place.rpartition(':')[2]}"
    for path in ("player", "1/live"):
        with connect(f"ws://{place}/{path}", origin=Origin(f"http://{place}")) as client:
            client.send(json.dumps({"type": "hello", "token": "wrong"}))
            with pytest.raises(ConnectionClosed) as closed:
                client.recv(10)
            assert closed.value.rcvd
            assert closed.value.rcvd.code == 4401
        with (
            pytest.raises(InvalidStatus),
            connect(f"ws://{place}/{path}", origin=Origin("http://evil.example")),
        ):
            pass
    with connect(f"ws://{place}/player", origin=Origin(f"http://{place}")) as client:
        client.send(json.dumps({"type": "hello", "token": token}))
        assert json.loads(client.recv(10))["type"] == "player"
        client.send('{"type": "seek", "time": NaN}')
        with pytest.raises(ConnectionClosed):
            client.recv(10)


def test_ctrl_c_ends_the_command_without_a_traceback(recorded: Path) -> None:
    command = [sys.executable, "-m", "robotcore", "view", str(recorded)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout
        link = process.stdout.readline().rpartition(" ")[2].strip()
        place = link.removeprefix("http://").rstrip("/")
        with connect(f"ws://{place}/player", origin=Origin(f"http://{place}")) as client:
            client.send('{"type": "hello"}')
            assert json.loads(client.recv(10))["recordings"][0]["name"] == "run.mcap"
            process.send_signal(signal.SIGINT)
            assert process.communicate(timeout=10) == ("", "")
    assert process.returncode == 0


def test_the_end_of_the_command_is_shown_as_the_end_of_the_viewer(page: Page, watch: Watch, recorded: Path) -> None:
    page.goto(watch(recorded))
    frame = open_frame(page)
    expect(frame.locator("#time")).to_have_text("0.0 s")
    watch.stop()
    expect(frame.locator("#screen-title")).to_have_text("The viewer has ended")
    expect(frame.locator("#screen-text")).to_have_text("Start robotcore view again.")
    expect(page.locator("#clock")).to_have_text("not connected")


def test_a_second_command_at_the_same_port_shows_its_own_recordings(
    page: Page, watch: Watch, recorded: Path, tmp_path: Path
) -> None:
    other = record(tmp_path / "other.mcap", timeout_s=1.0)
    link = watch(recorded, recorded)
    page.goto(link)
    expect(page.locator("section")).to_have_count(2)
    watch.stop()
    watch(other, "--listen", link.rstrip("/").rpartition(":")[2])
    expect(page.locator("h2 span:first-child")).to_have_text(["other.mcap"])
    expect(open_frame(page).locator("#time")).to_have_text("0.0 s")


def test_a_recording_has_no_stop_button_also_while_it_connects(page: Page, watch: Watch, recorded: Path) -> None:
    page.route("**/*.js", lambda route: route.abort())  # the page stays as it is before the connection
    page.goto(watch(recorded) + "1/")
    expect(page.locator("#where")).to_have_text("connecting …")
    expect(page.locator("#estop")).to_be_hidden()


def test_the_player_without_its_token_says_what_to_open(page: Page, watch: Watch, recorded: Path) -> None:
    port = watch(recorded, "--listen", "0.0.0.0:0").partition("/#token=")[0].rpartition(":")[2]
    page.goto(f"http://127.0.0.1:{port}/")
    expect(page.locator("#screens")).to_have_text(LINK_HINT)


def test_recordings_of_the_same_name_are_shown_with_their_folders(watch: Watch, recorded: Path, tmp_path: Path) -> None:
    other = Path(shutil.copy(recorded, tmp_path))
    place = watch(recorded, other).removeprefix("http://").rstrip("/")
    with connect(f"ws://{place}/player", origin=Origin(f"http://{place}")) as client:
        client.send('{"type": "hello"}')
        names = [each["name"] for each in json.loads(client.recv(10))["recordings"]]
    assert names == [str(recorded), str(other)]


def test_bad_input_is_wrong_usage(cli: Cli, recorded: Path, tmp_path: Path, check_text: CheckText) -> None:
    text, empty = tmp_path / "text.mcap", tmp_path / "empty.mcap"
    text.write_text("no recording")
    empty.write_bytes(b"")
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        for arguments in (
            [str(tmp_path / "missing.mcap")],
            [str(text)],
            [str(empty)],
            [str(tmp_path)],
            [str(recorded)] * 3,
            [str(recorded), "--listen", port],
        ):
            answer = cli("view", *arguments)
            assert answer.status == 2
            check_text(answer.err, hide=[port, recorded])
