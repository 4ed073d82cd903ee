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


def cookie(token, headers=()):
    """The cookie of somebody who came with the token."""
    sent: list[dict] = []

    async def send(message):
        sent.append(message)

    scope = {"type": "http", "method": "GET", "headers": headers, "query_string": b"token=" + token.encode()}
    run_apart(Guard(cast(Any, None), token)(scope, cast(Any, None), send))
    name, *rules = dict(sent[0]["headers"])[b"set-cookie"].split(b"; ")
    assert {b"SameSite=lax", b"HttpOnly"} < {*rules}
    return name


@pytest.mark.parametrize("site", [b"cross-site", b"same-site"])
def test_a_page_from_elsewhere_may_link_here_and_take_nothing(site):
    asked = [(b"sec-fetch-site", site), (b"sec-fetch-dest", b"document")]
    given = (b"cookie", cookie("secret", asked))
    assert answer("secret", [*asked, given])[0] == 200
    for dest in (b"image", b"iframe", b"empty", b"websocket"):
        assert answer("secret", [asked[0], (b"sec-fetch-dest", dest), given])[0] == 403
    own = [(b"sec-fetch-site", b"same-origin"), (b"sec-fetch-dest", b"image")]
    assert answer("secret", [*own, given])[0] == 200


def test_without_the_token_it_is_asked_for():
    assert answer("secret", [(b"host", b"localhost")]) == (
        403,
        "This studio opens with the address that caricli printed, which ends in a token.\n",
    )
    assert answer("secret", [(b"host", b"localhost")], b"token=secret")[0] == 303
    assert answer("secret", [(b"cookie", cookie("secret"))])[0] == 200


def test_studios_of_one_host_leave_each_other_their_cookies():
    both = cookie("secret") + b"; " + cookie("other")
    assert [answer(token, [(b"cookie", both)])[0] for token in ("secret", "other", "third")] == [200, 200, 403]


@pytest.mark.parametrize("other", [b'prefs={"a":1,"b":[1,2]}', b"theme=a b", b"name=J\xfcrgen", b"flag", b"[x]=1"])
def test_cookies_of_other_programs_shut_nobody_out(other):
    for both in (other + b"; " + cookie("secret"), cookie("secret") + b"; " + other):
        assert answer("secret", [(b"cookie", both)])[0] == 200
    assert answer("secret", [(b"cookie", other)])[0] == 403
