"""The live page in a real Chromium, with real runs."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Browser, Page, expect

from robotcore.errors import EmergencyStopError
from robotcore.live.address import Address
from tests.robotcore.live.chromium import measure
from tests.robotcore.live.live_run import Battery, Circles, StartRun

pytestmark = pytest.mark.slow

MAX_PAGE_BYTES = 150_000
LINK_HINT = "Open the whole link that the command printed, with its #token=…"


def read_canvas(page: Page, selector: str) -> str:
    """Return the pixels of a canvas as a data URL."""
    return str(page.locator(selector).evaluate("canvas => canvas.toDataURL()"))


def test_the_picture_and_the_path_move(page: Page, start_run: StartRun) -> None:
    run = start_run(world="arena")
    page.goto(run.view.link)
    expect(page.locator("#camera")).to_have_attribute("data-count", re.compile("[2-9]"))
    before = [read_canvas(page, canvas) for canvas in ("#camera", "#map", "#wheels")]
    page.wait_for_timeout(500)
    after = [read_canvas(page, canvas) for canvas in ("#camera", "#map", "#wheels")]
    assert all(old != new for old, new in zip(before, after, strict=True))


def test_it_shows_the_names_the_state_the_milestones_the_values_and_every_device(
    page: Page, start_run: StartRun
) -> None:
    run = start_run(seed=3)
    page.goto(run.view.link)
    expect(page.locator("#app")).to_have_text("Circles")
    expect(page.locator("#where")).to_have_text("kinematic · rover · open · seed 3")
    expect(page.locator("#state")).to_have_text("turning")
    expect(page.locator("#milestones li.is-reached")).to_have_count(1)
    expect(page.locator("#values dt")).to_have_text("gap")
    expect(page.locator("#values dd")).to_contain_text(" m")
    assert {*page.locator(".device h3").all_text_contents()} == {*run.context.robot.devices} - {"operator"}
    expect(page.locator(".device.is-silent")).to_have_count(0)
    expect(page.locator("#log")).to_contain_text("the circles begin")
    expect(page.locator("#log")).to_contain_text("state: turning")
    expect(page.locator(".device[data-device=nose] .value")).to_contain_text(re.compile("[0-9] m$|nothing in range"))


def test_a_milestone_may_have_the_name_of_a_property_of_every_object(page: Page, start_run: StartRun) -> None:
    class Oddly(Circles):
        milestones = ("constructor", "__proto__", "turning")

    page.goto(start_run(app=Oddly).view.link)
    expect(page.locator("#milestones li")).to_have_text(["constructor", "__proto__", re.compile("turning.* s")])


@pytest.mark.parametrize("width", [1000, 1600])
def test_a_robot_without_a_camera_leaves_no_empty_column(page: Page, start_run: StartRun, width: int) -> None:
    page.set_viewport_size({"width": width, "height": 900})
    page.goto(start_run(app="bump-and-turn", robot="tracer").view.link)
    expect(page.locator("#state")).to_have_text("drive")
    parts = ("#wheels-card", "#drive-card", "#map-card", "#pace-card")
    wheels, drive, overhead, pace = (measure(page.locator(each)) for each in parts)
    assert wheels["x"] == drive["x"] < overhead["x"]
    assert wheels["y"] == overhead["y"]
    assert wheels["y"] + wheels["height"] + 14 == pytest.approx(drive["y"], abs=1)
    is_beside = pace["x"] >= overhead["x"] + overhead["width"]
    assert is_beside if width == 1600 else pace["y"] >= overhead["y"] + overhead["height"]


def test_no_device_is_alone_in_the_last_row(page: Page, start_run: StartRun) -> None:
    page.goto(start_run().view.link)  # 7 devices, and 6 have the place in a row of 1280 pixels
    expect(page.locator(".device")).to_have_count(7)
    rows = page.locator(".device").evaluate_all("cards => cards.map((card) => card.getBoundingClientRect().top)")
    assert [rows.count(row) for row in sorted({*rows})] == [4, 3]


def test_a_range_guard_and_a_fault_are_named(page: Page, start_run: StartRun) -> None:
    run = start_run(app="bump-and-turn", robot="tracer", world="arena", faults=("left_motor weak=0.9",))
    page.goto(run.view.link)
    expect(page.locator("#notices")).to_contain_text("fault: left_motor weak=0.9")


def test_a_lost_connection_says_so_and_the_page_comes_back_with_the_next_run(page: Page, start_run: StartRun) -> None:
    run = start_run()
    page.goto(run.view.link)
    expect(page.locator("#state")).to_have_text("turning")
    port = int(run.view.link.rstrip("/").rpartition(":")[2])
    run.view._page.kill()
    expect(page.locator("#screen-title")).to_have_text("Connection lost")
    ticks = len(run.watcher.calls)
    page.wait_for_timeout(300)
    assert len(run.watcher.calls) > ticks, "the run continues without its page"
    run.stop()
    start_run(Address(port=port))
    expect(page.locator("#screen")).to_be_hidden()
    expect(page.locator("#state")).to_have_text("turning")


def test_a_finished_run_says_so_and_its_last_state_can_be_seen(page: Page, start_run: StartRun) -> None:
    run = start_run(timeout_s=3.0)
    page.goto(run.view.link)
    expect(page.locator("#screen-title")).to_have_text("The run has ended: timeout")
    run.wait()
    page.wait_for_timeout(1500)
    expect(page.locator("#screen-title")).to_have_text("The run has ended: timeout")
    page.locator("#screen-close").click()
    expect(page.locator("#screen")).to_be_hidden()
    expect(page.locator("#time")).to_have_text("3.0 s")


def test_the_last_state_of_a_finished_run_keeps_the_result_and_has_no_active_control(
    page: Page, start_run: StartRun
) -> None:
    run = start_run(timeout_s=3.0)
    page.goto(run.view.link)
    page.locator("#screen-close").click()
    page.wait_for_timeout(500)
    page.set_viewport_size({"width": 1200, "height": 800})  # the page draws again
    expect(page.locator("#state")).to_have_text("ended: timeout")
    expect(page.locator("#estop")).to_have_text("STOPthe run has ended")
    expect(page.locator("#drive-state")).to_have_text("the run has ended")
    assert page.evaluate("['drive-card', 'pace-card'].every((id) => document.getElementById(id).inert)")
    expect(page.locator(".control:enabled")).to_have_count(0)
    label = "getComputedStyle(document.querySelector('[data-device=left_motor] .value'), '::before').content"
    assert page.evaluate(label) == '"last: "'


class Heat(Battery):
    name = "heat"


def test_the_next_run_shows_nothing_of_the_one_before(page: Page, start_run: StartRun) -> None:
    run = start_run(app=Battery)
    page.goto(run.view.link)
    expect(page.locator("#values dt")).to_have_text("battery")
    expect(page.locator("#pose")).to_contain_text("heading")
    page.evaluate(
        """() => new MutationObserver((records) => {
            window.texts = [...(window.texts ?? []), document.getElementById('pose').textContent];
        }).observe(document.getElementById('pose'), {childList: true})"""
    )
    port = int(run.view.link.rstrip("/").rpartition(":")[2])
    run.stop()
    start_run(Address(port=port), app=Heat)
    expect(page.locator("#values dt")).to_have_text("heat")
    assert "" in page.evaluate("window.texts")


def test_the_plot_keeps_one_point_for_each_time_and_draws_any_number_of_them(page: Page, start_run: StartRun) -> None:
    page.goto(start_run().view.link)
    counts = page.evaluate(
        """async () => {
            const { WheelPlot } = await import('/page/plot.js');
            const plot = new WheelPlot(document.getElementById('wheels'));
            const add = (time) => plot.add({ time, asked: [0, 0], sent: [0, 0], measured: [0, 0] });
            for (let index = 0; index < 9; index++) add(5);
            const counts = [plot.points.length];
            for (let index = 0; index < 50000; index++) add(6 + index / 10000);
            plot.draw();
            return [...counts, plot.points.length];
        }"""
    )
    assert counts == [1, 50_001]


def test_rays_after_a_seek_have_a_pose_after_the_seek(page: Page, start_run: StartRun) -> None:
    page.goto(start_run().view.link)
    found = page.evaluate(
        """async () => {
            const { Overhead } = await import('/page/overhead.js');
            const overhead = new Overhead(document.getElementById('map'));
            const add = (time) => overhead.add({ time, pose: [time, 0, 0], truth: null, path: [] });
            for (let time = 0; time < 60; time++) add(time);
            overhead.setPath([]);
            const before = overhead.findPose(0.05, [7, 0, 0])[0];
            add(10);
            return [before, overhead.findPose(0.05)[0]];
        }"""
    )
    assert found == [7, 10]


def test_the_screen_gets_the_focus_and_enter_closes_it(page: Page, start_run: StartRun) -> None:
    run = start_run()
    page.goto(run.view.link)
    expect(page.locator("#state")).to_have_text("turning")
    run.stop()
    expect(page.locator("#screen-close")).to_be_focused()
    page.keyboard.press("Enter")
    expect(page.locator("#screen")).to_be_hidden()


def test_the_controls_are_active_in_the_next_run(page: Page, start_run: StartRun) -> None:
    run = start_run()
    page.goto(run.view.link)
    expect(page.locator("#state")).to_have_text("turning")
    run.stop()
    expect(page.locator("#state")).to_have_text("ended: stopped")
    start_run(Address(port=int(run.view.link.rstrip("/").rpartition(":")[2])))
    expect(page.locator("#state")).to_have_text("turning")
    page.locator("#take").click()
    expect(page.locator("#drive-state")).to_have_text("you drive")
    expect(page.locator("#estop")).to_have_text("STOPspace bar")


@pytest.mark.parametrize("ending", ["", "#token=wrong"])
def test_a_viewer_without_the_token_sees_nothing(page: Page, start_run: StartRun, ending: str) -> None:
    run = start_run(Address("0.0.0.0"))  # noqa: S104
    link = run.view.link
    page.goto(link.partition("#")[0] + ending)
    expect(page.locator("#screen-text")).to_have_text(LINK_HINT)
    expect(page.locator("#app")).to_have_text("robotcore")
    assert page.locator(".device").count() == 0
    page.goto(link)
    page.reload()
    expect(page.locator("#state")).to_have_text("turning")
    assert "token" not in page.url


def test_the_window_of_a_phone_shows_all_with_the_estop_in_reach(browser: Browser, start_run: StartRun) -> None:
    run = start_run()
    context = browser.new_context(viewport={"width": 360, "height": 640}, has_touch=True, is_mobile=True)
    page = context.new_page()
    page.goto(run.view.link)
    expect(page.locator("#state")).to_have_text("turning")
    assert page.evaluate("document.documentElement.scrollWidth") <= 360
    for _ in range(4):
        box = page.locator("#estop").bounding_box()
        assert box
        assert box["width"] == 360
        assert box["y"] + box["height"] == pytest.approx(640, abs=1)
        page.mouse.wheel(0, 500)
        page.wait_for_timeout(50)
    page.locator("#estop").tap()
    assert isinstance(run.wait().error, EmergencyStopError)
    context.close()


def test_the_page_loads_only_its_own_files_and_they_are_small(page: Page, start_run: StartRun) -> None:
    run = start_run()
    sizes: dict[str, int] = {}
    page.on("response", lambda response: sizes.update({response.url: len(response.body())}))
    page.goto(run.view.link, wait_until="networkidle")
    expect(page.locator("#state")).to_have_text("turning")
    assert all(url.startswith(run.view.link) for url in sizes)
    assert len(sizes) > 5
    assert sum(sizes.values()) <= MAX_PAGE_BYTES
