"""Who may ask the server for anything."""

import secrets
from hashlib import sha256
from urllib.parse import parse_qs

from starlette.requests import cookie_parser
from starlette.responses import PlainTextResponse, RedirectResponse
from starlette.types import ASGIApp, Receive, Scope, Send

_ELSEWHERE = ("cross-site", "same-site")
"""Pages of other hosts, and of other ports of this one."""


class Guard:
    """Lets those in that know a token, which other users of the machine do not.

    The address carries it once, and a cookie from then on; of what other pages ask for, only links bring it along.
    """

    def __init__(self, app: ASGIApp, token: str) -> None:
        """app: what is guarded. token: text."""
        self.app = app
        self.token = token
        # A host has its cookies of all ports together: studios of several users have each their own.
        self.cookie = f"caricli_studio_{sha256(token.encode()).hexdigest()[:12]}"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, or refuse."""
        if scope["type"] not in ("http", "websocket") or self._welcome(scope):
            await self.app(scope, receive, send)
        elif scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008})
        elif self._told(scope):
            answer = RedirectResponse("/", 303)
            answer.set_cookie(self.cookie, self.token, httponly=True, samesite="lax")
            await answer(scope, receive, send)
        else:
            words = "This studio opens with the address that caricli printed, which ends in a token.\n"
            await PlainTextResponse(words, 403)(scope, receive, send)

    def _welcome(self, scope: Scope) -> bool:
        headers = {name: value.decode("latin-1") for name, value in scope["headers"]}
        if headers.get(b"sec-fetch-site") in _ELSEWHERE and headers.get(b"sec-fetch-dest") != "document":
            return False  # a picture or a frame of a page from elsewhere would take a desk from a tab
        given = cookie_parser(headers.get(b"cookie", "")).get(self.cookie, "")
        return secrets.compare_digest(given.encode(), self.token.encode())

    def _told(self, scope: Scope) -> bool:
        given = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])[0]
        return secrets.compare_digest(given.encode(), self.token.encode())
