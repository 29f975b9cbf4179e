"""The checks of the host, the origin and the token of a request, and the headers of each answer."""

from __future__ import annotations

import hmac
import re
from collections.abc import Sequence
from dataclasses import dataclass
from ipaddress import ip_address
from typing import Any

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

ESTOP_HEADER = ("x-robotcore", "estop")
"""The header that a press of the e-stop needs. A page of another site cannot send it without a permission."""

MAX_TOKEN_CHARACTERS = 200


@dataclass(frozen=True)
class Access:
    """The rules for requests to the page.

    A page of another site may let a name of its own point at this machine (DNS rebinding). So the host of a request
    must be an IP address or a name of this machine, and its origin must be the page itself.

    >>> access = Access("", ("localhost",))
    >>> [access.is_host_allowed(host) for host in ("localhost:8080", "127.0.0.1", "[::1]:8080")]
    [True, True, True]
    >>> [access.is_host_allowed(host) for host in ("evil.example", "192.168.0.7:8080", "[::1]evil", "127.0.0.1:x@evil")]
    [False, False, False, False]
    """

    token: str
    """The token that a viewer needs; empty for a page on loopback, which needs none."""
    names: Sequence[str]
    """The names of this machine that a browser may use."""
    has_frames: bool = False
    """Whether a page of the server contains other pages of the server."""

    def is_host_allowed(self, host: str) -> bool:
        """Return whether the header ``Host`` of a request names this machine."""
        name = _split_port(host).lower()
        try:
            address = ip_address(name)
        except ValueError:
            return name in {each.lower() for each in self.names}
        return bool(self.token) or address.is_loopback

    def is_same_origin(self, headers: Headers) -> bool:
        """Return whether the page itself has sent a request, by its headers ``Origin`` and ``Host``."""
        return headers.get("origin") in {f"http://{headers.get('host')}", f"https://{headers.get('host')}"}

    def is_token_right(self, token: object) -> bool:
        """Return whether a viewer has the right token."""
        if not self.token:
            return True
        text = token if isinstance(token, str) and len(token) <= MAX_TOKEN_CHARACTERS else ""
        return hmac.compare_digest(text.encode(errors="replace"), self.token.encode())

    def may_press_estop(self, headers: Headers) -> bool:
        """Return whether a request may press the e-stop. It needs no token."""
        name, value = ESTOP_HEADER
        return headers.get(name) == value and ("origin" not in headers or self.is_same_origin(headers))


def _split_port(host: str) -> str:
    """Return the host of a header ``Host`` without its port; an empty text for a malformed header."""
    match = re.fullmatch(r"(?:\[([^\[\]]+)\]|([^\[\]:]+))(?::[0-9]*)?", host)
    return (match[1] or match[2]) if match else ""


class AccessControl:
    """Refuses requests with a wrong host or origin, and adds the headers that restrict the page to its own files."""

    def __init__(self, app: ASGIApp, access: Access) -> None:
        self._app, self._access = app, access

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "http":
            await self._answer(scope, receive, send)
        elif scope["type"] == "websocket":
            headers = Headers(scope=scope)
            if self._access.is_host_allowed(headers.get("host", "")) and self._access.is_same_origin(headers):
                await self._app(scope, receive, send)
            else:
                await send({"type": "websocket.close", "code": 1008})

    async def _answer(self, scope: Scope, receive: Receive, send: Send) -> None:
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        app = self._app
        if not self._access.is_host_allowed(host):
            app = PlainTextResponse("This page has another address: see the link that robotcore printed.\n", 421)

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message).update(_build_headers(host, has_frames=self._access.has_frames))
            await send(message)

        await app(scope, receive, send_with_headers)


def _build_headers(host: str, *, has_frames: bool) -> dict[str, Any]:
    socket = f"ws://{host} wss://{host}" if host.isascii() and not set(host) & set(" ;,'\"") else ""
    policy = {
        "default-src": "'none'",
        "script-src": "'self'",
        "style-src": "'self'",
        "img-src": "'self' blob: data:",
        "connect-src": f"'self' {socket}",
        "base-uri": "'none'",
        "form-action": "'none'",
        "frame-ancestors": "'self'" if has_frames else "'none'",
        "frame-src": "'self'" if has_frames else "'none'",
    }
    return {
        "Content-Security-Policy": "; ".join(f"{name} {value}" for name, value in policy.items()),
        "X-Content-Type-Options": "nosniff",
        "X-Frame-Options": "SAMEORIGIN" if has_frames else "DENY",
        "Referrer-Policy": "no-referrer",
        "Cross-Origin-Resource-Policy": "same-origin",
        "Cross-Origin-Opener-Policy": "same-origin",
        "Cache-Control": "no-store",
        "Connection": "close",
    }
