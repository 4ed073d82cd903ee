"""Who may ask the server for anything."""

import secrets
from hashlib import sha256
from urllib.parse import parse_qs

from starlette.requests import cookie_parser
from starlette.responses import PlainTextResponse, RedirectResponse
from starlette.types import ASGIApp, Receive, Scope, Send

LOOPBACK = ("127.0.0.1", "localhost", "::1")
"""Names of one's own machine."""


class Guard:
    """Lets pages of this machine alone in, or with a token those that know it.

    Without a token the name that was asked for has to be this machine's, so that no page from elsewhere gets in under a
    name of its own. With one, the address carries it once, and a cookie from then on; of what pages from elsewhere ask
    for, only links bring it along.
    """

    def __init__(self, app: ASGIApp, token: str | None) -> None:
        """app: what is guarded. token: text, or None."""
        self.app = app
        self.token = token
        # A host has its cookies of all ports together: every studio has one of its own.
        self.cookie = f"caricli_studio_{sha256(str(token).encode()).hexdigest()[:12]}"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, or refuse."""
        if scope["type"] not in ("http", "websocket") or self._welcome(scope):
            await self.app(scope, receive, send)
        elif scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008})
        elif self.token is not None and self._told(scope):
            answer = RedirectResponse("/", 303)
            answer.set_cookie(self.cookie, str(self.token), httponly=True, samesite="lax")
            await answer(scope, receive, send)
        else:
            end = ", which ends in a token" if self.token else "; --host NAME serves under another one"
            words = f"This studio opens with the address that caricli printed{end}.\n"
            await PlainTextResponse(words, 403)(scope, receive, send)

    def _welcome(self, scope: Scope) -> bool:
        headers = {name: value.decode("latin-1") for name, value in scope["headers"]}
        if headers.get(b"sec-fetch-site") == "cross-site" and headers.get(b"sec-fetch-dest") != "document":
            return False  # a picture or a frame of a page from elsewhere would take a desk from a tab
        if self.token is None:
            names = [_host(headers.get(b"host", ""))]
            origin = headers.get(b"origin")
            names += [] if origin is None else [_host(origin.partition("://")[2])]
            return all(name in LOOPBACK for name in names)
        given = cookie_parser(headers.get(b"cookie", "")).get(self.cookie, "")
        return secrets.compare_digest(given.encode(), self.token.encode())

    def _told(self, scope: Scope) -> bool:
        given = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])[0]
        return secrets.compare_digest(given.encode(), str(self.token).encode())


def _host(text: str) -> str:
    """The name in a host with or without a port."""
    if text.startswith("["):
        return text[1:].partition("]")[0]
    return text.rpartition(":")[0] if ":" in text else text
