"""The e-stop of the live page, in a real Chromium."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from playwright.sync_api import Page, expect

from robotcore.errors import EmergencyStopError
from robotcore.live.address import Address
from tests.robotcore.live.live_run import LiveRun, StartRun
from tests.robotcore.live.proxy import Proxy

pytestmark = pytest.mark.slow

PRESSES = ["button", "Enter", "assistive technology", "space bar"]


def press(page: Page, way: str) -> None:
    if way == "button":
        page.locator("#estop").click()
    elif way == "Enter":
        page.locator("#estop").press("Enter")
    elif way == "assistive technology":
        page.evaluate("document.getElementById('estop').click()")
    else:
        page.keyboard.press("Space")


def find_port(run: LiveRun) -> int:
    return int(run.view.link.partition("/#")[0].rstrip("/").rpartition(":")[2])


@pytest.fixture
def run(start_run: StartRun) -> LiveRun:
    return start_run()


@pytest.fixture
def proxy(run: LiveRun) -> Iterator[Proxy]:
    proxy = Proxy(find_port(run))
    yield proxy
    proxy.close()


@pytest.mark.parametrize("way", PRESSES)
def test_the_estop_stops_the_simulated_wheels_and_ends_the_run(page: Page, run: LiveRun, way: str) -> None:
    page.goto(run.view.link)
    expect(page.locator("#state")).to_have_text("turning")
    assert all(run.wheels)
    press(page, way)
    result = run.wait()
    assert isinstance(result.error, EmergencyStopError)
    assert run.wheels == [0, 0]
    expect(page.locator("#screen-title")).to_have_text("The run has ended: stopped")
    expect(page.locator("#screen-text")).to_contain_text("live page")
    expect(page.locator("#estop")).to_have_text("STOPthe run has ended")


def test_the_space_bar_does_not_press_the_focused_button_too(page: Page, run: LiveRun) -> None:
    page.goto(run.view.link)
    tab = page.locator("#camera-tabs [aria-selected=false]")
    name = tab.text_content()
    tab.focus()
    page.keyboard.press("Space")
    assert isinstance(run.wait().error, EmergencyStopError)
    expect(page.locator("#camera-tabs [aria-selected=true]")).not_to_have_text(str(name))


@pytest.mark.parametrize("part", ["#speed button >> nth=0", "#pause", "#limit", "#camera-tabs button >> nth=0"])
def test_the_space_bar_is_the_estop_after_a_click_on_any_part(page: Page, run: LiveRun, part: str) -> None:
    page.goto(run.view.link)
    page.locator("#take").click()
    page.locator(part).click()
    page.keyboard.press("Space")
    assert isinstance(run.wait().error, EmergencyStopError)


def test_a_press_without_a_socket_stops_the_run(page: Page, run: LiveRun) -> None:
    page.add_init_script("WebSocket.prototype.send = () => {}")
    page.goto(run.view.link)
    page.locator("#estop").click()
    assert isinstance(run.wait().error, EmergencyStopError)


def test_a_press_on_a_lost_connection_reaches_the_run_with_the_next_connection(
    page: Page, run: LiveRun, proxy: Proxy
) -> None:
    page.goto(f"http://127.0.0.1:{proxy.port}/")
    expect(page.locator("#state")).to_have_text("turning")
    proxy.cut()
    expect(page.locator("#screen-title")).to_have_text("Connection lost")
    page.keyboard.press("Space")
    page.wait_for_timeout(1500)
    expect(page.locator("#estop")).to_have_text("STOPnot confirmed")
    assert run.result is None
    proxy.mend()
    assert isinstance(run.wait().error, EmergencyStopError)
    expect(page.locator("#estop")).not_to_have_text("STOPnot confirmed")


def test_a_press_is_not_lost_if_the_socket_connects_before_it_is_confirmed(
    page: Page, run: LiveRun, proxy: Proxy
) -> None:
    page.route("**/estop", lambda route: route.abort())
    page.goto(f"http://127.0.0.1:{proxy.port}/")
    expect(page.locator("#state")).to_have_text("turning")
    proxy.cut()
    expect(page.locator("#screen-title")).to_have_text("Connection lost")
    page.keyboard.press("Space")
    proxy.mend()
    expect(page.locator("#screen")).to_be_hidden()
    expect(page.locator("#estop")).to_have_text("STOPnot confirmed")
    page.unroute("**/estop")
    assert isinstance(run.wait().error, EmergencyStopError)


def test_the_estop_of_an_open_page_stops_the_next_run_whose_token_it_lacks(page: Page, start_run: StartRun) -> None:
    run = start_run(Address("0.0.0.0"))  # noqa: S104
    page.goto(run.view.link)
    expect(page.locator("#state")).to_have_text("turning")
    run.stop()
    expect(page.locator("#estop")).to_have_text("STOPthe run has ended")
    following = start_run(Address("0.0.0.0", find_port(run)))  # noqa: S104
    expect(page.locator("#screen-title")).to_have_text("This page needs its whole link")
    expect(page.locator("#estop")).to_have_text("STOPspace bar")
    page.keyboard.press("Space")
    assert isinstance(following.wait().error, EmergencyStopError)


def test_a_press_after_the_end_says_that_no_run_answers(page: Page, run: LiveRun) -> None:
    page.goto(run.view.link)
    expect(page.locator("#state")).to_have_text("turning")
    run.stop()
    expect(page.locator("#estop")).to_have_text("STOPthe run has ended")
    page.wait_for_timeout(1000)  # the server ends after its run
    page.keyboard.press("Space")
    expect(page.locator("#estop")).to_have_text("STOPno run answers")
