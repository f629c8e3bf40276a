"""Who is let in: the token by address, then by cookie; no other host, no other origin, no socket without."""

import asyncio
from typing import Any

import pytest

from sits_mech.studio.guard import Guard

HERE = {"host": "127.0.0.1:8123"}


def asked(query: str = "", kind: str = "http", **headers: str) -> list[dict[str, Any]]:
    """Return what a guarded application answers to a request."""
    found: list[dict[str, Any]] = []

    async def app(scope: Any, receive: Any, send: Any) -> None:
        """Say ok."""
        await send({"type": "http.response.start", "status": 200, "headers": []})

    async def send(message: Any) -> None:
        """Keep an answer."""
        found.append(message)

    async def receive() -> Any:
        """Say nothing."""
        return {}

    pairs = [(name.encode(), value.encode()) for name, value in headers.items()]
    scope = {"type": kind, "headers": pairs, "query_string": query.encode(), "path": "/"}
    asyncio.run(Guard(app, "secret")(scope, receive, send))
    return found


def test_the_token_opens_and_gives_a_cookie_that_opens() -> None:
    """The cookie is of this port, for this site alone."""
    [answer] = asked("scene=x&token=secret", **HERE)
    cookie = dict(answer["headers"])[b"set-cookie"].decode()
    assert answer["status"] == 200 and cookie == "sits_studio_8123=secret; HttpOnly; SameSite=Strict; Path=/"
    [answer] = asked(cookie="other=1; sits_studio_8123=secret", **HERE)
    assert answer["status"] == 200 and not answer["headers"]
    assert asked(kind="lifespan")[0]["status"] == 200


@pytest.mark.parametrize(
    ("query", "headers"),
    [("", HERE), ("token=secre", HERE), ("xtoken=secret", HERE), ("token=secret", {"host": "evil.example:8123"}),
     ("token=secret", HERE | {"origin": "http://evil.example"}), ("token=secret", {}),
     ("", HERE | {"cookie": "sits_studio_8124=secret"})],
)
def test_all_others_get_403(query: str, headers: dict[str, str]) -> None:
    """By page as by socket."""
    assert asked(query, **headers)[0]["status"] == 403
    assert asked(query, "websocket", **headers) == [{"type": "websocket.close", "code": 1008, "reason": ""}]
