"""The server of a page: for this computer alone, and for who has the token.

It listens on the loopback address. A request is answered where it names this computer (`Host`, so that no name of
another that leads here is taken) and has the token; a WebSocket, besides, where the page that opens it came from here
(`Origin`). A request that is not over after `PATIENCE`, or larger than `LARGEST`, is cut off; pages and connections
are counted. The page asks for each answer, so that none waits in memory for a page that is slow.
"""

from __future__ import annotations

import asyncio
import hmac
import os
import secrets
import socket
import threading
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Protocol

import h11
import uvicorn
from starlette.applications import Starlette
from starlette.datastructures import Headers
from starlette.middleware import Middleware
from starlette.middleware.trustedhost import TrustedHostMiddleware
from starlette.requests import HTTPConnection, Request
from starlette.responses import HTMLResponse, PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect
from uvicorn.protocols.http.h11_impl import H11Protocol

from ...core.errors import UsageError
from ..acquisition.live import Shown
from .content import LiveContent

ADDRESS, HOSTS = "127.0.0.1", ["127.0.0.1", "localhost"]
TOKEN = "INERTIALCAL_LIVE_TOKEN"  # noqa: S105 - the name of a variable
SHORTEST = 16  # signs of a token
PATIENCE = 5.0  # [s] for a request and its answer
LARGEST = 8192  # bytes of a request
PAGES, CONNECTIONS = 8, 32  # at a time
REFUSED = 1008  # of RFC 6455, 7.4.1: a message that violates the policy


class Content(Protocol):
    """What a page shows."""

    page: str  # HTML, with ``{nonce}`` and ``{script}``
    script: str
    largest: int  # Bytes of a message of the page

    async def answer(self, asked: str | bytes) -> str | bytes | None:
        """Return the answer to what a page asks; None where it asks for what is not given."""
        ...


def live_page(shown: Shown, port: int) -> AbstractContextManager[str]:
    """Give the live page of an acquisition, which may start later; else as `served`."""
    return served(LiveContent(shown), port)


@contextmanager
def served(content: Content, port: int) -> Iterator[str]:
    """Give a page while the block runs; its address, with its token, comes out.

    Parameters
    ----------
    content : Content
        That is shown.
    port : int
        Of this computer; 0 for one that is free.

    Raises
    ------
    UsageError
        ``bad_port`` where another program has it, ``bad_token`` where the one of the environment is short.
    """
    token = os.environ.get(TOKEN) or secrets.token_urlsafe(24)
    if len(token) < SHORTEST or not token.replace("-", "").replace("_", "").isalnum() or not token.isascii():
        what = f"{TOKEN} is not a token: {SHORTEST} or more letters, digits, - and _ are needed"
        raise UsageError(what, do="Unset it, for a random one", code="bad_token")
    listening = _listening(port)
    config = uvicorn.Config(
        _application(content, token), http=_Patient, ws="websockets-sansio", loop="asyncio",
        lifespan="off", log_config=None, log_level="critical", access_log=False, server_header=False,
        proxy_headers=False, ws_per_message_deflate=False, ws_max_size=content.largest,
        h11_max_incomplete_event_size=LARGEST, limit_concurrency=CONNECTIONS,
        timeout_keep_alive=2, timeout_graceful_shutdown=1,
    )  # fmt: skip
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run, args=([listening],), name="lab page", daemon=True)
    thread.start()
    try:
        yield f"http://{ADDRESS}:{listening.getsockname()[1]}/?token={token}"
    finally:
        server.should_exit = True
        thread.join(2.0 * PATIENCE)


def _listening(port: int) -> socket.socket:
    made = socket.socket()
    made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        made.bind((ADDRESS, port))
        made.listen()
    except (OSError, OverflowError) as error:
        made.close()
        said = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise UsageError(f"port {port}: {said}", do="Name another: --port N", code="bad_port") from None
    return made


class _Patient(H11Protocol):
    """HTTP of one request a connection, that does not wait for ever."""

    _end: asyncio.TimerHandle | None = None
    _came = 0  # bytes

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        super().connection_made(transport)
        self._end = self.loop.call_later(PATIENCE, transport.abort)

    def data_received(self, data: bytes) -> None:
        self._came += len(data)
        if self._came > LARGEST:
            self.transport.abort()
        else:
            super().data_received(data)

    def on_response_complete(self) -> None:
        super().on_response_complete()
        self.transport.close()

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        self._forget()
        super().handle_websocket_upgrade(event)

    def connection_lost(self, exc: Exception | None) -> None:
        self._forget()
        super().connection_lost(exc)

    def _forget(self) -> None:
        if self._end is not None:
            self._end.cancel()


def _application(content: Content, token: str) -> Starlette:
    """Return what answers; all that it does not know is refused as what has no token is."""
    pages = 0

    def allowed(one: HTTPConnection) -> bool:
        return hmac.compare_digest(one.query_params.get("token", "").encode(), token.encode())

    def shown(request: Request) -> Response:
        if not allowed(request):
            return PlainTextResponse("open the address that was printed\n", 403, _headers("'none'", ""))
        nonce = secrets.token_urlsafe(16)
        headers = _headers(f"'nonce-{nonce}'", f"; connect-src ws://{request.headers['host']}")
        return HTMLResponse(content.page.replace("{nonce}", nonce).replace("{script}", content.script), headers=headers)

    async def told(web: WebSocket) -> None:
        nonlocal pages
        if not allowed(web) or not _from_here(web.headers) or pages >= PAGES:
            await web.close(REFUSED)  # before it was accepted: 403
            return
        pages += 1
        try:
            await web.accept()
            while (message := await web.receive())["type"] == "websocket.receive":
                text: str | None = message.get("text")
                answer = await content.answer(message["bytes"] if text is None else text)
                if answer is None:
                    await web.close(REFUSED)
                    return
                await (web.send_text(answer) if isinstance(answer, str) else web.send_bytes(answer))
        except WebSocketDisconnect:
            pass
        finally:
            pages -= 1

    hosts = Middleware(TrustedHostMiddleware, allowed_hosts=HOSTS, www_redirect=False)
    return Starlette(routes=[Route("/", shown), WebSocketRoute("/live", told)], middleware=[hosts])


def _headers(inline: str, more: str) -> dict[str, str]:
    policy = f"default-src 'none'; script-src {inline}; style-src {inline}; base-uri 'none'; form-action 'none'"
    return {
        "Content-Security-Policy": f"{policy}; frame-ancestors 'none'{more}", "Cache-Control": "no-store",
        "Referrer-Policy": "no-referrer", "X-Content-Type-Options": "nosniff",
        "Cross-Origin-Opener-Policy": "same-origin", "Cross-Origin-Resource-Policy": "same-origin",
    }  # fmt: skip


def _from_here(headers: Headers) -> bool:
    """Tell whether a page of this server opens it: one origin, that of the host."""
    return headers.getlist("origin") == [f"http://{headers.get('host', '')}"]


__all__ = ["ADDRESS", "CONNECTIONS", "LARGEST", "PAGES", "PATIENCE", "TOKEN", "live_page", "served"]
