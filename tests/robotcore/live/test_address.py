from __future__ import annotations

import socket
from urllib.parse import urlsplit

import pytest

from robotcore.errors import BackendMissingError, UsageError
from robotcore.live.address import Address, build_token, find_own_address
from robotcore.live.live_view import LiveView
from tests.texts import Raises

EVERYWHERE = "0.0.0.0"  # noqa: S104  pages for other machines are tested too


@pytest.mark.parametrize(
    "text, address",
    [
        ("8080", ("127.0.0.1", 8080)),
        (":8080", ("127.0.0.1", 8080)),
        ("rover.local", ("rover.local", 0)),
        ("0.0.0.0:80", (EVERYWHERE, 80)),
        ("[::]:80", ("::", 80)),
        ("[::1]", ("::1", 0)),
        ("::", ("::", 0)),
        ("::1", ("::1", 0)),
        ("0:80", (EVERYWHERE, 80)),
        ("127.1:80", ("127.0.0.1", 80)),
    ],
)
def test_an_address_is_a_host_a_port_or_both(text: str, address: tuple[str, int]) -> None:
    assert Address.parse(text) == address


@pytest.mark.parametrize(
    "text", ["app.py", "localhost:x", "localhost:70000", "http://localhost:80", "a b:80", ":-1", "[::1]x", "1 2:80"]
)
def test_another_text_is_no_address(text: str, raises: Raises) -> None:
    with raises(UsageError, "not-an-address", address=text):
        Address.parse(text)


def test_only_a_page_on_loopback_needs_no_token() -> None:
    assert not any(build_token(Address(host)) for host in ("127.0.0.1", "127.0.0.9", "::1", "localhost"))
    tokens = {build_token(Address(host)) for host in (EVERYWHERE, "::", "192.168.0.7", "rover.local")}
    assert all(len(token) >= 20 for token in tokens)
    assert len(tokens) == 4


def test_the_link_of_a_page_at_each_address_names_this_machine() -> None:
    assert Address(EVERYWHERE).build_link(80, "secret") == f"http://{find_own_address()}:80/#token=secret"
    assert Address("::1").build_link(80, "") == "http://[::1]:80/"


def test_a_port_that_is_taken_is_an_error(raises: Raises) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with raises(UsageError, "cannot-listen", hide=[port], host="127.0.0.1", port=port):
            Address(port=port).listen()


def test_a_host_of_another_machine_is_an_error(raises: Raises) -> None:
    with raises(UsageError, "cannot-listen", host="192.0.2.1", port=0):
        Address("192.0.2.1").listen()


def test_the_link_has_a_token_and_a_qr_code_only_for_other_machines() -> None:
    private, public = LiveView(Address()), LiveView(Address(EVERYWHERE))
    assert not urlsplit(private.link).fragment
    assert private.describe_link() == f"The live page: {private.link}"
    assert urlsplit(public.link).fragment.startswith("token=")
    assert public.link in public.describe_link()
    assert "█" in public.describe_link()
    for view in (private, public):
        view.close()


def test_a_missing_library_is_named(monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    monkeypatch.setattr("robotcore.extras.find_spec", lambda name: None if name == "segno" else name)
    with raises(BackendMissingError, "library-missing", extra="view", modules=["segno"]):
        LiveView(Address())
