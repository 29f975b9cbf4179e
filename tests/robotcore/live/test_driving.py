"""Driving by hand from the live page, in a real Chromium."""

from __future__ import annotations

import math
import re
import signal
import socket
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from threading import Thread
from typing import Any
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Browser, Page, expect
from websockets.exceptions import ConnectionClosed

import robotcore
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.live.live_view import LOST_PAGE
from robotcore.runtime.operator_input import LEASE_S
from tests.robotcore.live.chromium import find_bottom, measure
from tests.robotcore.live.client import Client
from tests.robotcore.live.live_run import LiveRun, StartRun

pytestmark = pytest.mark.slow

GAMEPAD = "navigator.getGamepads = () => [{axes: window.axes ?? [0, 0, 0, 0], buttons: []}]"
HIDE = """() => {
    Object.defineProperty(document, 'hidden', {get: () => true});
    document.dispatchEvent(new Event('visibilitychange'));
}"""
LIGHTS = """
[[devices]]
kind = "led"
name = "lamp"
is_rgb = true

[[devices]]
kind = "buzzer"
name = "horn"
"""

STOP_S = 2.0
"""The longest wait for the stop of the wheels on a busy machine, in seconds. benchmarks/live_page.py measures it."""


def wait_for(condition: Callable[[], bool], seconds: float = 10.0) -> None:
    clock = MonotonicClock()
    while not condition():
        assert clock.now() < seconds, "it did not happen in time"
        clock.sleep_until(clock.now() + 0.01)


def drive_until(client: Client, condition: Callable[[], bool], **fields: float) -> None:
    def drive() -> bool:
        client.send(type="drive", linear=0.5, angular=0, **fields)
        return condition()

    wait_for(drive)


def is_forward(run: LiveRun) -> bool:
    return min(run.wheels) > 1.0


def is_standing(run: LiveRun) -> bool:
    return run.wheels == [0.0, 0.0]


def open_and_take(page: Page, run: LiveRun) -> None:
    page.goto(run.view.link)
    page.locator("#take").click()
    expect(page.locator("#drive-state")).to_have_text("you drive")


@pytest.fixture
def standing_run(start_run: StartRun) -> LiveRun:
    """Start a run whose app stands still."""
    return start_run(app="teleop")


@pytest.mark.parametrize("key", ["ArrowUp", "KeyW"])
def test_a_key_moves_the_robot_while_it_is_pressed(page: Page, standing_run: LiveRun, key: str) -> None:
    open_and_take(page, standing_run)
    page.keyboard.down(key)
    wait_for(lambda: is_forward(standing_run))
    page.keyboard.up(key)
    wait_for(lambda: is_standing(standing_run))


def test_the_left_key_turns_to_the_left(page: Page, standing_run: LiveRun) -> None:
    open_and_take(page, standing_run)
    page.keyboard.down("ArrowLeft")
    wait_for(lambda: standing_run.wheels[0] < 0 < standing_run.wheels[1])


def test_keys_without_taking_the_robot_do_nothing(page: Page, standing_run: LiveRun) -> None:
    page.goto(standing_run.view.link)
    page.locator("#take").wait_for()
    page.keyboard.down("ArrowUp")
    page.wait_for_timeout(500)
    assert is_standing(standing_run)


def test_the_page_of_teleop_says_how_to_begin(page: Page, standing_run: LiveRun) -> None:
    page.goto(standing_run.view.link)
    expect(page.locator("#drive-state")).to_have_text("press Drive first")
    page.locator("#take").click()
    expect(page.locator("#drive-state")).to_have_text("you drive")


@pytest.mark.parametrize("input_", ["key", "joystick"])
def test_a_viewer_who_does_not_drive_gets_a_hint(page: Page, start_run: StartRun, input_: str) -> None:
    page.goto(start_run().view.link)
    expect(page.locator("#drive-state")).to_have_text("the app drives")
    if input_ == "key":
        page.keyboard.press("KeyW")
    else:
        page.locator("#stick").click()
    expect(page.locator("#drive-state")).to_have_text("press Drive first")
    page.locator("#take").click()
    page.locator("#release").click()
    expect(page.locator("#drive-state")).to_have_text("the app drives")


def test_the_log_names_each_change_of_the_viewer_who_drives(
    browser: Browser, page: Page, standing_run: LiveRun
) -> None:
    open_and_take(page, standing_run)
    page.locator("#release").click()
    page.locator("#take").click()
    other = browser.new_context().new_page()
    open_and_take(other, standing_run)
    other.context.close()
    texts = ["a viewer drives", "has returned the robot to the app", "a viewer drives", "another viewer drives", "left"]
    expect(page.locator("#log li:not(:has-text('state'))")).to_have_text([re.compile(each) for each in texts])


def test_a_finger_on_the_joystick_of_a_phone_moves_the_robot(browser: Browser, standing_run: LiveRun) -> None:
    context = browser.new_context(viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True)
    page = context.new_page()
    page.goto(standing_run.view.link)
    page.locator("#take").tap()
    page.locator("#stick").scroll_into_view_if_needed()
    box = page.locator("#stick").bounding_box()
    assert box
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    touch = context.new_cdp_session(page)
    touch.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": [{"x": x, "y": y}]})
    touch.send("Input.dispatchTouchEvent", {"type": "touchMove", "touchPoints": [{"x": x, "y": y - 70}]})
    wait_for(lambda: is_forward(standing_run))
    touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    wait_for(lambda: is_standing(standing_run))
    context.close()


def test_a_phone_shows_the_camera_and_the_whole_joystick_while_its_viewer_drives(
    browser: Browser, standing_run: LiveRun
) -> None:
    context = browser.new_context(viewport={"width": 360, "height": 640}, has_touch=True, is_mobile=True)
    page = context.new_page()
    page.goto(standing_run.view.link)
    page.locator("#take").tap()
    expect(page.locator("#drive-state")).to_have_text("you drive")
    parts = [page.locator(each) for each in (".bar", "#camera", "#drive-card")]
    assert find_bottom(parts[0]) <= measure(parts[1])["y"]
    assert find_bottom(parts[1]) <= measure(parts[2])["y"]
    assert find_bottom(page.locator("#stick")) <= measure(page.locator("#estop"))["y"]
    context.close()


def test_a_gamepad_moves_the_robot(page: Page, standing_run: LiveRun) -> None:
    page.add_init_script(GAMEPAD)
    open_and_take(page, standing_run)
    page.evaluate("() => { window.axes = [0, -1, 0, 0]; }")
    wait_for(lambda: is_forward(standing_run))
    page.evaluate("() => { window.axes = [0.05, 0.05, 0, 0]; }")
    wait_for(lambda: is_standing(standing_run))


def test_the_speed_limit_limits_the_velocity(page: Page, standing_run: LiveRun) -> None:
    open_and_take(page, standing_run)
    page.locator("#limit").fill("10")
    page.locator("h1").click()
    page.keyboard.down("KeyW")
    most = 0.1 * standing_run.context.robot.drive.max_linear / standing_run.context.robot.drive.geometry.wheel_radius
    wait_for(lambda: standing_run.wheels == pytest.approx([most, most], rel=0.01))


@pytest.mark.parametrize("end", ["close", "reload", "kill"])
def test_the_end_of_the_drivers_page_stops_the_robot_and_the_app_waits(
    browser: Browser, start_run: StartRun, end: str
) -> None:
    run = start_run()  # its app would drive in circles
    context = browser.new_context()
    page = context.new_page()
    open_and_take(page, run)
    page.keyboard.down("KeyW")
    wait_for(lambda: run.wheels[0] == pytest.approx(run.wheels[1]) and is_forward(run))
    if end == "kill":
        process = run.view._page._process
        assert process
        process.send_signal(signal.SIGSTOP)  # as a network that is cut
        wait_for(lambda: is_standing(run), LEASE_S + STOP_S)
        process.send_signal(signal.SIGCONT)
    elif end == "reload":
        page.reload()
    else:
        page.close()
    wait_for(lambda: is_standing(run), STOP_S)
    clock = MonotonicClock()
    clock.sleep_until(0.5)
    if end != "kill":
        assert is_standing(run), "the app must not continue by itself"
    context.close()


def test_a_hidden_page_lets_go(page: Page, standing_run: LiveRun) -> None:
    open_and_take(page, standing_run)
    page.keyboard.down("KeyW")
    wait_for(lambda: is_forward(standing_run))
    page.evaluate("() => window.dispatchEvent(new Event('blur'))")
    wait_for(lambda: is_standing(standing_run))


LOSSES = {
    "the focus moves": "document.querySelector('#limit').focus()",
    "a menu opens": "document.body.dispatchEvent(new MouseEvent('contextmenu', {bubbles: true, cancelable: true}))",
    "a key combination begins": "press('keydown', {code: 'MetaLeft', key: 'Meta', metaKey: true})",
    "a key combination ends": "press('keyup', {code: 'MetaLeft', key: 'Meta'})",
}
PRESS = "const press = (type, key) => document.body.dispatchEvent(new KeyboardEvent(type, {bubbles: true, ...key}))"


@pytest.mark.parametrize("loss", LOSSES)
def test_a_key_whose_release_may_get_lost_is_released(page: Page, standing_run: LiveRun, loss: str) -> None:
    open_and_take(page, standing_run)
    page.keyboard.down("KeyW")
    wait_for(lambda: is_forward(standing_run))
    page.evaluate(f"() => {{ {PRESS}; {LOSSES[loss]}; }}")
    wait_for(lambda: is_standing(standing_run), STOP_S)


def test_no_part_of_the_page_opens_a_native_list_which_would_take_the_keys(page: Page, standing_run: LiveRun) -> None:
    open_and_take(page, standing_run)
    assert {*page.locator("input").evaluate_all("inputs => inputs.map((input) => input.type)")} == {"range"}
    expect(page.locator("select")).to_have_count(0)


def test_a_key_that_was_pressed_at_a_takeover_is_released(browser: Browser, page: Page, standing_run: LiveRun) -> None:
    open_and_take(page, standing_run)
    page.keyboard.down("KeyW")
    wait_for(lambda: is_forward(standing_run))
    other = browser.new_context().new_page()
    open_and_take(other, standing_run)
    expect(page.locator("#drive-state")).to_have_text("another viewer drives")
    page.evaluate("document.getElementById('take').click()")  # without a change of the focus
    expect(page.locator("#drive-state")).to_have_text("you drive")
    page.wait_for_timeout(500)
    assert is_standing(standing_run)
    other.context.close()


def test_only_the_left_button_of_a_mouse_moves_the_joystick(page: Page, standing_run: LiveRun) -> None:
    open_and_take(page, standing_run)
    box = measure(page.locator("#stick"))
    x, y = box["x"] + box["width"] / 2, box["y"] + 20
    page.mouse.move(x, y)
    page.mouse.down(button="right")
    page.wait_for_timeout(500)
    assert is_standing(standing_run)
    page.mouse.up(button="right")
    page.mouse.down()
    wait_for(lambda: is_forward(standing_run))
    page.mouse.down(button="right")
    page.mouse.up()
    wait_for(lambda: is_standing(standing_run), STOP_S)


def test_a_hidden_page_does_not_read_the_gamepad(page: Page, standing_run: LiveRun) -> None:
    page.add_init_script(GAMEPAD)
    open_and_take(page, standing_run)
    page.evaluate("() => { window.axes = [0, -1, 0, 0]; }")
    wait_for(lambda: is_forward(standing_run))
    page.evaluate(HIDE)
    wait_for(lambda: is_standing(standing_run))
    page.wait_for_timeout(1000 * 3 * LEASE_S)
    assert is_standing(standing_run)


def test_the_robot_returns_to_the_app(page: Page, start_run: StartRun) -> None:
    run = start_run()
    open_and_take(page, run)
    wait_for(lambda: is_standing(run))
    page.locator("#release").click()
    expect(page.locator("#drive-state")).to_have_text("the app drives")
    wait_for(lambda: is_forward(run))


def test_a_second_viewer_watches_and_can_take_over(browser: Browser, page: Page, standing_run: LiveRun) -> None:
    open_and_take(page, standing_run)
    other = browser.new_context().new_page()
    other.goto(standing_run.view.link)
    expect(other.locator("#drive-state")).to_have_text("another viewer drives")
    expect(other.locator("#viewers")).to_have_text("2 viewers")
    other.keyboard.down("KeyW")
    page.keyboard.down("KeyS")
    wait_for(lambda: max(standing_run.wheels) < -1.0)
    other.locator("#take", has_text="Take over").click()
    expect(other.locator("#drive-state")).to_have_text("you drive")
    expect(page.locator("#drive-state")).to_have_text("another viewer drives")
    wait_for(lambda: is_standing(standing_run))
    other.keyboard.down("ArrowUp")
    wait_for(lambda: is_forward(standing_run))
    other.context.close()
    expect(page.locator("#drive-state")).to_have_text("no viewer drives, the app waits")


def test_the_slider_of_a_servo_turns_it_only_for_the_driver(page: Page, start_run: StartRun) -> None:
    run = start_run(app="teleop", robot="scout")
    page.goto(run.view.link)
    slider = page.locator(".device[data-device=pan] input")
    expect(slider).to_be_disabled()
    page.locator("#take").click()
    slider.fill("0.5")
    expect(page.locator(".device[data-device=pan] .value")).to_have_text("0.50 rad")


def test_a_light_and_a_buzzer_have_controls(page: Page, start_run: StartRun, tmp_path: Path) -> None:
    robot = tmp_path / "lit.toml"
    rover = Path(robotcore.__file__).parent / "description" / "robots" / "rover.toml"
    robot.write_text(rover.read_text() + LIGHTS)
    run = start_run(app="teleop", robot=str(robot))
    page.goto(run.view.link)
    page.locator("#take").click()
    page.get_by_label("red of lamp").fill("1")
    expect(page.locator(".device[data-device=lamp] .value")).to_have_text("1.00 0.00 0.00")
    page.locator(".device[data-device=horn] button").hover()
    page.mouse.down()
    expect(page.locator(".device[data-device=horn] .value")).to_have_text("440.00 Hz")
    page.mouse.up()
    expect(page.locator(".device[data-device=horn] .value")).to_have_text("0.00 Hz")
    page.keyboard.down("Enter")
    expect(page.locator(".device[data-device=horn] .value")).to_have_text("440.00 Hz")
    page.keyboard.up("Enter")
    expect(page.locator(".device[data-device=horn] .value")).to_have_text("0.00 Hz")


def test_a_simulation_pauses_steps_and_changes_its_speed(page: Page, start_run: StartRun) -> None:
    run = start_run(timeout_s=3600.0)  # without a limit, simulated time passes fast
    page.goto(run.view.link)
    page.locator("#pause").click()
    expect(page.locator("#pace-state")).to_have_text("paused")
    page.wait_for_timeout(300)
    count = len(run.watcher.calls)
    page.locator("#step").click()
    wait_for(lambda: len(run.watcher.calls) == count + 1)
    page.wait_for_timeout(300)
    assert len(run.watcher.calls) == count + 1
    page.locator("#pause").click()
    wait_for(lambda: len(run.watcher.calls) > count + 3)
    pace = run.context.pace
    assert pace
    for label, speed in (("no limit", math.inf), ("0.1×", 0.1)):
        page.locator("#speed button", has_text=label).click()
        wait_for(lambda: pace.speed == speed)  # noqa: B023
        expect(page.locator("#speed [aria-pressed=true]")).to_have_text(label)
    page.keyboard.press("Space")
    assert run.wait().exit_status == 4


def test_the_estop_ends_a_paused_run(page: Page, start_run: StartRun) -> None:
    run = start_run()
    page.goto(run.view.link)
    page.locator("#pause").click()
    expect(page.locator("#pace-state")).to_have_text("paused")
    page.keyboard.press("Space")
    assert run.wait().exit_status == 4
    assert is_standing(run)


def test_the_times_of_the_ticks_are_shown(page: Page, start_run: StartRun) -> None:
    page.goto(start_run().view.link)
    expect(page.locator("#timing tr")).to_have_count(6)
    expect(page.locator("#overruns")).to_contain_text("overrun")


def test_a_viewer_who_does_not_drive_moves_nothing(standing_run: LiveRun) -> None:
    driver, other = Client(standing_run), Client(standing_run)
    driver.send(type="take")
    while other.receive("viewers")["operator"] != "other":
        pass
    clock = MonotonicClock()
    while clock.now() < 1.0:
        for message in ({"type": "drive", "linear": 1, "angular": 0}, {"type": "pace", "is_paused": True}):
            other.send(**message)
        other.send(type="release")
        driver.send(type="drive", linear=0, angular=0)
        clock.sleep_until(clock.now() + 0.05)
    assert is_standing(standing_run)
    assert standing_run.context.pace
    assert not standing_run.context.pace.is_paused
    for client in (driver, other):
        client.close()


def test_a_silent_driver_stands_after_the_lease(standing_run: LiveRun) -> None:
    client = Client(standing_run)
    client.send(type="take")
    clock = MonotonicClock()
    while not is_forward(standing_run):
        client.send(type="drive", linear=0.5, angular=0)
        clock.sleep_until(clock.now() + 0.05)
    wait_for(lambda: is_standing(standing_run), LEASE_S + STOP_S)
    client.close()


class Channel:
    """A proxy to a page. While ``is_held``, it keeps what the viewer sends."""

    def __init__(self, run: LiveRun) -> None:
        self.is_held, self._kept = False, b""
        self._page = int(urlsplit(run.view.link).port or 0)
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.link = f"http://127.0.0.1:{self._listener.getsockname()[1]}/"
        Thread(target=self._serve, daemon=True).start()

    def _serve(self) -> None:
        viewer = self._listener.accept()[0]
        self._server = socket.create_connection(("127.0.0.1", self._page))
        Thread(target=self._pass_back, args=(viewer,), daemon=True).start()
        with viewer, suppress(OSError):
            while data := viewer.recv(65_536):
                self._kept += data
                if not self.is_held:
                    self.deliver(len(self._kept))

    def _pass_back(self, viewer: socket.socket) -> None:
        with suppress(OSError):
            while data := self._server.recv(65_536):
                viewer.sendall(data)

    def deliver(self, size: int) -> None:
        """Send the first bytes that were kept."""
        self._server.sendall(self._kept[:size])
        self._kept = self._kept[size:]

    @property
    def size(self) -> int:
        return len(self._kept)

    def close(self) -> None:
        self._listener.close()
        self._server.close()


def test_commands_that_the_network_held_back_have_no_effect(standing_run: LiveRun) -> None:
    channel, clock = Channel(standing_run), MonotonicClock()
    client = Client(standing_run, link=channel.link)
    client.send(type="take")
    drive_until(client, lambda: is_forward(standing_run))
    channel.is_held = True
    for _ in range(10):
        client.send(type="drive", linear=1, angular=0)
    wait_for(lambda: is_standing(standing_run))
    driven = channel.size
    assert driven
    clock.sleep_until(clock.now() + 5 * LEASE_S)
    channel.deliver(driven)  # what the viewer sent before it let go
    since, moved = clock.now(), []
    while clock.now() < since + 3 * LEASE_S:
        moved.append(not is_standing(standing_run))
        clock.sleep_until(clock.now() + 0.01)
    assert not any(moved)
    channel.is_held = False
    drive_until(client, lambda: is_forward(standing_run))
    client.close()
    channel.close()


def test_a_viewer_whose_clock_stood_still_is_disconnected(standing_run: LiveRun) -> None:
    client = Client(standing_run)
    client.send(type="take")
    client.send(type="drive", linear=1, angular=0, sent=1e9)
    with pytest.raises(ConnectionClosed):
        drive_until(client, lambda: False, sent=0)
    client.close()


@pytest.mark.parametrize("is_driven", [True, False])
def test_a_run_says_that_its_page_has_ended_and_goes_on(
    start_run: StartRun, capfd: pytest.CaptureFixture[str], *, is_driven: bool
) -> None:
    run = start_run()
    client = Client(run)
    if is_driven:
        client.send(type="take")
        client.send(type="drive", linear=1, angular=0)
        wait_for(lambda: bool(run.context.operator and run.context.operator.is_driving))
    client.send(type="pace", is_paused=True)
    wait_for(lambda: bool(run.context.pace and run.context.pace.is_paused))
    process, ticks = run.view._page._process, len(run.watcher.calls)
    assert process
    process.kill()
    wait_for(lambda: len(run.watcher.calls) > ticks + 20)
    assert is_standing(run) == is_driven
    assert capfd.readouterr().err.count(LOST_PAGE) == 1
    run.stop()
    assert run.wait().notes.count(LOST_PAGE) == 1
    client.close()


def test_a_run_whose_page_is_closed_at_its_end_has_no_note_of_it(start_run: StartRun) -> None:
    run = start_run()
    run.stop()
    assert LOST_PAGE not in run.wait().notes


def test_a_paused_run_sends_its_tick_only_for_a_change(standing_run: LiveRun) -> None:
    client = Client(standing_run)
    client.send(type="take")
    client.send(type="drive", linear=0, angular=0)
    client.send(type="pace", is_paused=True)
    while not client.receive("tick")["pace"]["is_paused"]:
        pass
    clock = MonotonicClock()
    for number in range(20):
        client.send(type="drive", linear=0, angular=0)
        clock.sleep_until(number * 0.05)
    late = Client(standing_run)
    times = [each["time"] for each in late.receive("history")["wheels"]]
    assert len(times) - len(set(times)) < 5
    for each in (client, late):
        each.close()


def test_commands_that_waited_while_the_run_was_suspended_have_no_effect(start_run: StartRun) -> None:
    standing_run = start_run(app="teleop", robot="scout")
    client, clock, moved = Client(standing_run), MonotonicClock(), []
    client.send(type="take")
    with standing_run.view._changed:  # the loop and the thread with the actions wait for this lock
        client.send(type="pace", speed=1.0)
        for _ in range(10):
            client.send(type="drive", linear=1.0, angular=0.0)
            client.send(type="actuate", device="pan", value=[0.5])
        clock.sleep_until(3 * LEASE_S)
    while clock.now() < 6 * LEASE_S:
        moved.append(not is_standing(standing_run))
    assert not any(moved)
    pan: Any = standing_run.context.robot.devices["pan"]
    assert pan.latest != 0.5
    client.send(type="drive", linear=1.0, angular=0.0)
    wait_for(lambda: is_forward(standing_run))
    client.send(type="actuate", device="pan", value=[0.5])
    wait_for(lambda: pan.latest == 0.5)
    client.close()
