from __future__ import annotations

import pytest

from robotcore.deploy.agent.actions import logs
from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.telling import RefusalError
from tests.robotcore.deploy.agent.scripted import Scripted

LINE = "2026-11-21T22:58:38+0000 rover robotcore[9244]: found it"


def test_what_the_app_wrote_is_passed_on_as_it_is(
    layout: Layout, systemd: Scripted, capfd: pytest.CaptureFixture[str]
) -> None:
    systemd.writes(LINE)
    assert logs.act(layout, lines=7) == {}
    assert capfd.readouterr().out == f"{LINE}\n"
    assert systemd.asked == "--no-pager --quiet --output=short-iso --lines=7 --user-unit=robotcore.service\n"


def test_what_it_writes_from_now_on_is_followed(layout: Layout, systemd: Scripted) -> None:
    logs.act(layout, follow=True)
    assert systemd.asked.endswith(" --follow\n")


def test_journal_that_nobody_may_read_is_refused_with_the_remedy(layout: Layout, systemd: Scripted) -> None:
    systemd.folder.joinpath("unreadable").write_text("insufficient permissions\n")
    with pytest.raises(RefusalError, match="sudo usermod -aG systemd-journal"):
        logs.act(layout)
