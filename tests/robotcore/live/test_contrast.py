"""The contrast of the live page, in a real Chromium."""

from __future__ import annotations

from typing import Literal

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.robotcore.live.live_run import Battery, StartRun

pytestmark = pytest.mark.slow

MEASURE = """
    const context = new OffscreenCanvas(1, 1).getContext('2d', { willReadFrequently: true });
    const paint = (colours) => { // the lowest one first
        context.clearRect(0, 0, 1, 1);
        for (const colour of colours) { context.fillStyle = colour; context.fillRect(0, 0, 1, 1); }
        const parts = [...context.getImageData(0, 0, 1, 1).data].slice(0, 3).map((part) => part / 255);
        const [r, g, b] = parts.map((part) => part <= 0.03928 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4);
        return 0.2126 * r + 0.7152 * g + 0.0722 * b;
    };
    const measure = (colours, ink) => {
        const [low, high] = [paint(colours), paint([...colours, ink])].sort((a, b) => a - b);
        return (high + 0.05) / (low + 0.05);
    };
    const list = (element) => { // an element and those around it
        const chain = [];
        for (let each = element; each; each = each.parentElement) chain.unshift(each);
        return chain;
    };
    const background = (element) => list(element).map((each) => getComputedStyle(each).backgroundColor);
"""
CONTRASTS = f"""() => {{
    {MEASURE}
    const texts = {{}};
    for (const element of document.body.querySelectorAll('*')) {{
        const hasText = [...element.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim());
        if (!hasText || !element.checkVisibility() || element.closest(':disabled, [inert], noscript')) continue;
        const opacity = list(element).reduce((all, each) => all * Number(getComputedStyle(each).opacity), 1);
        const ink = `color-mix(in srgb, ${{getComputedStyle(element).color}} ${{100 * opacity}}%, transparent)`;
        texts[`${{element.closest('[id]').id}}: ${{element.textContent}}`] = measure(background(element), ink);
    }}
    return texts;
}}"""
"""The contrast of each visible text to its background, as WCAG 2.2 defines it."""
LINE_CONTRAST = f"""() => {{
    {MEASURE}
    const asked = getComputedStyle(document.documentElement).getPropertyValue('--asked').trim();
    return measure(background(document.getElementById('wheels')), asked);
}}"""


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_each_text_has_a_contrast_of_at_least_4_5(
    browser: Browser, start_run: StartRun, scheme: Literal["light", "dark"]
) -> None:
    page = browser.new_page(color_scheme=scheme)
    page.goto(start_run(app=Battery).view.link)
    expect(page.locator("#state")).not_to_be_empty()
    assert page.locator(".device.is-silent").count()
    require_contrasts(page)
    page.locator("#take").click()  # the run then reads each sensor
    expect(page.locator("#drive-state")).to_have_text("you drive")
    require_contrasts(page)
    assert page.evaluate(LINE_CONTRAST) >= 3.0
    page.close()


def require_contrasts(page: Page) -> None:
    contrasts = page.evaluate(CONTRASTS)
    assert len(contrasts) > 30
    assert {text: contrast for text, contrast in contrasts.items() if contrast < 4.5} == {}
