from typing import Any, cast

import pytest

from caricli.studio.guard import Guard
from tests.studio.conftest import run_apart


def answer(token, headers, query=b""):
    """Status and words for somebody who asks so."""
    sent: list[dict] = []

    async def inside(scope, receive, send):
        sent.append({"status": 200, "body": b""})

    async def send(message):
        sent.append(message)

    scope = {"type": "http", "method": "GET", "headers": headers, "query_string": query}
    run_apart(Guard(inside, token)(scope, None, send))
    return sent[0]["status"], bytes(sent[-1]["body"]).decode()


@pytest.mark.parametrize("host", [b"127.0.0.1:8020", b"localhost:8020", b"[::1]:8020"])
def test_this_machine_comes_in(host):
    assert answer(None, [(b"host", host)])[0] == 200


@pytest.mark.parametrize(
    "headers", [[(b"host", b"elsewhere:8020")], [(b"host", b"localhost"), (b"origin", b"http://elsewhere")], []]
)
def test_other_names_are_told_what_to_do(headers):
    for query in (b"", b"token=None"):
        status, words = answer(None, headers, query)
        assert status == 403 and "--host NAME" in words and "token" not in words


def test_a_page_from_elsewhere_may_link_here_and_take_nothing():
    asked = [(b"host", b"localhost"), (b"sec-fetch-site", b"cross-site")]
    for dest, status in ((b"document", 200), (b"image", 403), (b"iframe", 403), (b"empty", 403)):
        assert answer(None, [*asked, (b"sec-fetch-dest", dest)])[0] == status
    own = [(b"host", b"localhost"), (b"sec-fetch-site", b"same-origin"), (b"sec-fetch-dest", b"image")]
    assert answer(None, own)[0] == 200


def test_a_link_from_elsewhere_that_has_the_token_comes_in():
    sent: list[dict] = []

    async def send(message):
        sent.append(message)

    asked = [(b"sec-fetch-site", b"cross-site"), (b"sec-fetch-dest", b"document")]
    scope = {"type": "http", "method": "GET", "headers": asked, "query_string": b"token=secret"}
    run_apart(Guard(cast(Any, None), "secret")(scope, cast(Any, None), send))
    cookie = dict(sent[0]["headers"])[b"set-cookie"]
    assert b"SameSite=lax" in cookie and b"HttpOnly" in cookie
    given = (b"cookie", cookie.partition(b";")[0])
    assert answer("secret", [*asked, given])[0] == 200
    for dest in (b"image", b"iframe", b"empty", b"websocket"):
        assert answer("secret", [asked[0], (b"sec-fetch-dest", dest), given])[0] == 403


def test_without_the_token_it_is_asked_for():
    assert answer("secret", [(b"host", b"localhost")]) == (
        403,
        "This studio opens with the address that caricli printed, which ends in a token.\n",
    )
    assert answer("secret", [(b"host", b"localhost")], b"token=secret")[0] == 303
    assert answer("secret", [(b"cookie", b"caricli_studio=secret")])[0] == 200
