"""Let only the browser in that was given the token: everything else gets 403 and changes nothing."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any

Message = MutableMapping[str, Any]
App = Callable[[Message, Callable[[], Awaitable[Message]], Callable[[Message], Awaitable[None]]], Awaitable[None]]
_COOKIE = "sits_studio"
_HOSTS = ("127.0.0.1", "localhost")


class Guard:
    """An ASGI application before another one: loopback by name, no other origin, token by address or by cookie."""

    def __init__(self, app: App, token: str) -> None:
        self.app, self.token = app, token

    async def __call__(
        self, scope: Message, receive: Callable[[], Awaitable[Message]], send: Callable[[Message], Awaitable[None]]
    ) -> None:
        """Pass on what is allowed."""
        if scope["type"] not in ("http", "websocket"):
            return await self.app(scope, receive, send)
        headers = {name.decode("latin-1").lower(): value.decode("latin-1") for name, value in scope["headers"]}
        by_address = f"token={self.token}" in scope.get("query_string", b"").decode("latin-1").split("&")
        cookies = [part.strip() for part in headers.get("cookie", "").split(";")]
        if not (self._here(headers) and (by_address or f"{self._cookie(headers)}={self.token}" in cookies)):
            return await _refused(scope, send)

        async def sent(message: Message) -> None:
            """Give the cookie with the page."""
            if message["type"] == "http.response.start" and by_address:
                cookie = f"{self._cookie(headers)}={self.token}; HttpOnly; SameSite=Strict; Path=/"
                message["headers"] = [*message.get("headers", ()), (b"set-cookie", cookie.encode())]
            await send(message)

        return await self.app(scope, receive, sent)

    def _here(self, headers: dict[str, str]) -> bool:
        """Return whether a request is for this machine by name, and of a page of this server."""
        host = headers.get("host", "")
        return host.rpartition(":")[0] in _HOSTS and headers.get("origin", f"http://{host}") == f"http://{host}"

    def _cookie(self, headers: dict[str, str]) -> str:
        """Return the cookie's name: one for each port, so that two studios do not disturb each other."""
        return f"{_COOKIE}_{headers.get('host', '').rpartition(':')[2]}"


async def _refused(scope: Message, send: Callable[[Message], Awaitable[None]]) -> None:
    """Answer 403."""
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 1008})
        return
    await send({"type": "http.response.start", "status": 403, "headers": [(b"content-type", b"text/plain")]})
    await send({"type": "http.response.body", "body": b"403: open the address that sits-mech studio printed\n"})
