from __future__ import annotations

import pytest

from robotcore.deploy.connection.host import Host
from robotcore.errors import UsageError

HOSTILE = (
    "",
    " ",
    "-oProxyCommand=touch canary",
    "-l",
    "pi@-oProxyCommand=touch canary",
    "-E@rover",
    "rover;touch canary",
    "rover&touch canary",
    "rover|touch canary",
    "rover\ntouch canary",
    "rover\n",
    "$(touch canary)",
    "`touch canary`",
    "pi@$(touch${IFS}canary)",
    "pi$(touch${IFS}canary)@rover",
    "pi;touch@rover",
    "${HOME}",
    "$HOME@rover",
    "%h",
    "pi@%h",
    "%r@rover",
    "~root",
    "~@rover",
    "rover>canary",
    "rover<canary",
    "'rover'",
    '"rover"',
    "ro ver",
    "ro\tver",
    "ro\0ver",
    "ro\\ver",
    "r*ver",
    "r?ver",
    "!rover",
    "rover,other",
    "(rover)",
    "{rover}",
    "#rover",
    "rover=canary",
    "ssh://rover",
    "rover/canary",
    "../canary",
    "rover:/canary",
    "rover::canary",
    "rover:",
    "rover:0",
    "rover:65536",
    "rover:-1",
    "rover:22 -oProxyCommand=x",
    "rover:2²",
    "@rover",
    "pi@",
    "pi@@rover",
    "pi@rover@other",
    "rover.",
    ".rover",
    "röver",
    "rov\u202eer",
    "::1",
    "[::1",
    "[::1]]",
    "[rover]",
    "[1]",
    "[::1%$(touch canary)]",
    "[::1%-o]:22x",
    "a" * 254,
    "u" * 65 + "@rover",
)


@pytest.mark.parametrize("text", HOSTILE)
def test_what_a_shell_or_ssh_could_take_for_more_than_a_name_is_no_host(text: str) -> None:
    with pytest.raises(UsageError, match="is no host"):
        Host.parse(text)


@pytest.mark.parametrize(
    "text, host",
    [
        ("rover", Host("rover")),
        ("pi@rover.local", Host("rover.local", "pi")),
        ("rover_2:2222", Host("rover_2", "", 2222)),
        ("pi.zero-2@192.168.1.20:22", Host("192.168.1.20", "pi.zero-2", 22)),
        ("[::1]", Host("::1")),
        ("pi@[fe80::1%wlan0]:2222", Host("fe80::1%wlan0", "pi", 2222)),
    ],
)
def test_a_host_is_told_as_it_was_written(text: str, host: Host) -> None:
    assert Host.parse(text) == host
    assert str(host) == text
