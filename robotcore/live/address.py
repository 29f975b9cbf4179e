"""The address at which the live page listens, and the link to the page."""

from __future__ import annotations

import errno
import secrets
import socket
from contextlib import suppress
from ipaddress import ip_address
from typing import NamedTuple

from robotcore.errors import UsageError
from robotcore.system import HAS_POSIX, LOOPBACK

TOKEN_BYTES = 16


class Address(NamedTuple):
    """The host and the port at which the page listens.

    >>> Address.parse("8080")
    Address(host='127.0.0.1', port=8080)
    >>> Address.parse("rover.local:8080").is_loopback, Address.parse("[::1]:8080").is_loopback
    (False, True)
    """

    host: str = LOOPBACK
    port: int = 0
    """The port. With 0, the system chooses a free one."""

    @classmethod
    def parse(cls, text: str) -> Address:
        """Return the address in a text: ``HOST:PORT``, a port or a host. Raises UsageError for another text.

        An IPv6 address with a port needs brackets.
        """
        host, colon, port = text.rpartition(":")
        if not colon:
            host, port = ("", text) if text.isdecimal() else (text, "0")
        elif text.endswith("]") or _is_ipv6(text):
            host, port = text, "0"
        host = host.removeprefix("[").removesuffix("]") or LOOPBACK
        is_port = port.isascii() and port.isdecimal() and int(port) < 2**16
        if not is_port or any(each.isspace() or each in "/@#?" for each in host) or host.endswith(".py"):
            hint = ". If it is the app, write --view after it" if host.endswith(".py") else ""
            raise UsageError(
                f"{text!r} is not an address. Give HOST:PORT, such as 0.0.0.0:8080, or only a port{hint}",
                kind="not-an-address",
                address=text,
            )
        return cls(_complete(host), int(port))

    @property
    def is_loopback(self) -> bool:
        """Whether only programs on this machine can connect."""
        if self.host == "localhost":
            return True
        with suppress(ValueError):
            return ip_address(self.host).is_loopback
        return False

    @property
    def is_any(self) -> bool:
        """Whether the page listens at each of the machine's addresses."""
        with suppress(ValueError):
            return ip_address(self.host).is_unspecified
        return False

    def listen(self) -> socket.socket:
        """Return a socket that listens at the address. Raises UsageError if the system refuses it."""
        try:
            family, kind, protocol, _, where = socket.getaddrinfo(self.host, self.port, type=socket.SOCK_STREAM)[0]
            listener = socket.socket(family, kind, protocol)
        except OSError as error:
            raise self._build_error(error) from error
        try:
            if HAS_POSIX:  # on Windows another program could take the port with this option
                listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listener.bind(where)
            listener.listen()
        except OSError as error:
            listener.close()
            raise self._build_error(error) from error
        return listener

    def list_hosts(self) -> list[str]:
        """Return the names by which a browser may reach the page, besides IP addresses."""
        if self.is_loopback:
            return ["localhost", self.host]
        return [self.host, "localhost", socket.gethostname(), f"{socket.gethostname()}.local"]

    def build_link(self, port: int, token: str) -> str:
        """Return the link to the page.

        port: the port at which the page listens.
        token: the token, which follows ``#`` and so stays in the browser; empty without one.
        """
        host = find_own_address() if self.is_any else self.host
        host = f"[{host}]" if ":" in host else host
        return f"http://{host}:{port}/" + (f"#token={token}" if token else "")

    def _build_error(self, error: OSError) -> UsageError:
        is_host_wrong = isinstance(error, socket.gaierror) or error.errno == errno.EADDRNOTAVAIL
        host_remedy = "Give an address of this machine, or 0.0.0.0 for all of them"
        remedy = host_remedy if is_host_wrong else "Choose another port, or leave it out for a free one"
        return UsageError(
            f"the page cannot listen at {self.host}:{self.port}: {error.strerror or error}. {remedy}",
            kind="cannot-listen",
            host=self.host,
            port=self.port,
        )


def _is_ipv6(text: str) -> bool:
    with suppress(ValueError):
        return ip_address(text).version == 6
    return False


def _complete(host: str) -> str:
    """Return a short IPv4 address, such as 0 or 127.1, with its four numbers, and any other host unchanged."""
    with suppress(OSError):
        return socket.inet_ntoa(socket.inet_aton(host))
    return host


def build_token(address: Address) -> str:
    """Return a new token for a page that other machines can reach; an empty text for a page on loopback."""
    return "" if address.is_loopback else secrets.token_urlsafe(TOKEN_BYTES)


def find_own_address() -> str:
    """Return the address of this machine on its network; its name if it has no network."""
    with suppress(OSError), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.connect(("192.0.2.1", 9))  # no packet is sent: 192.0.2.0/24 is for documentation, RFC 5737
        return str(probe.getsockname()[0])
    return socket.gethostname()
