"""Let only the browser in that was given the token: everything else gets 403 and changes nothing."""

from __future__ import annotations

from starlette.datastructures import MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocketClose

_HOSTS = ("127.0.0.1", "localhost")


class Guard:
    """An ASGI application before another one: loopback by name, no other origin, token by address or by cookie."""

    def __init__(self, app: ASGIApp, token: str) -> None:
        self.app, self.token = app, token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on what is allowed, and give the cookie with the page; its name is of the port, for several studios."""
        if scope["type"] not in ("http", "websocket"):
            return await self.app(scope, receive, send)
        asked = HTTPConnection(scope)
        host = asked.headers.get("host", "")
        name, _, port = host.rpartition(":")
        cookie, by_address = f"sits_studio_{port}", self.token in asked.query_params.getlist("token")
        here = name in _HOSTS and asked.headers.get("origin", f"http://{host}") == f"http://{host}"
        if not (here and (by_address or asked.cookies.get(cookie) == self.token)):
            page = PlainTextResponse("403: open the address that sits-mech studio printed\n", 403)
            refusal: ASGIApp = WebSocketClose(1008) if scope["type"] == "websocket" else page
            return await refusal(scope, receive, send)

        async def sent(message: Message) -> None:
            if message["type"] == "http.response.start" and by_address:
                message.setdefault("headers", [])
                given = f"{cookie}={self.token}; HttpOnly; SameSite=Strict; Path=/"
                MutableHeaders(scope=message).append("set-cookie", given)
            await send(message)

        return await self.app(scope, receive, sent)
