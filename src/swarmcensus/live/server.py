"""The server of the page: on loopback, for browsers that have the token, and not for pages of other sites."""

import contextlib
import contextvars
import errno
import json
import secrets
import socket
import threading
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import parse_qs, urlsplit

from swarmcensus.live.choices import PLAYED, Offer, check_moment, wanted
from swarmcensus.live.exporting import page_of
from swarmcensus.live.pages import PAGE, live_page
from swarmcensus.live.sessions import MOST_TEXT, Session, Spoken, spoken
from swarmcensus.support.errors import InputError

KINDS = {".html": "text/html", ".css": "text/css", ".js": "text/javascript", ".txt": "text/plain"}
MOST_PAGES = 64
MOST_WAITING = 64  # unanswered requests of a page
AT_ONCE = 2  # pages that are served by computation at the same time
LOOPBACK = ("127.0.0.1", "localhost", "::1")
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self' ws: ; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'self' http://127.0.0.1:* http://localhost:* vscode-webview:"
)
HEADERS = {
    "content-security-policy": POLICY,
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cache-control": "no-store",
    "cross-origin-resource-policy": "same-origin",
}


@dataclass(frozen=True)
class Served:
    """A server and its address."""

    offer: Offer
    host: str
    socket: socket.socket
    interprets: bool = False  # whether CPython shows trials while they are compiled
    token: str = field(default_factory=lambda: secrets.token_urlsafe(18))

    @property
    def port(self) -> int:
        """The port of the server."""
        return int(self.socket.getsockname()[1])

    def address(self, fragment: str = "") -> str:
        """The address that a browser opens."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"http://{host}:{self.port}/?token={self.token}{'#' * bool(fragment)}{fragment}"


def listen(offer: Offer, host: str = "127.0.0.1", port: int = 0, interprets: bool = False) -> Served:
    """Listen on a port; 0 takes a free one. Raises InputError if it is not available, or the server not installed."""
    return Served(offer, host, bound(host, port), interprets)


def bound(host: str, port: int) -> socket.socket:
    """A socket that listens on a port, before it is known what is served. Raises InputError as `listen`."""
    try:
        import starlette  # noqa: F401
        import uvicorn  # noqa: F401
        import websockets  # noqa: F401
    except ImportError as error:
        raise InputError(f"watch needs {error.name}: pip install 'swarmcensus[watch]'") from None
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    made = socket.socket(family)
    try:
        made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        made.bind((host, port))
        made.listen()  # so that an early browser waits and is not refused
    except (OSError, OverflowError) as error:
        made.close()
        hint = "; without --port any free one is taken" if getattr(error, "errno", None) == errno.EADDRINUSE else ""
        why = getattr(error, "strerror", None) or error
        raise InputError(f"cannot listen on {host}, port {port}: {why}{hint}", key="port", value=port) from None
    return made


def app_of(served: Served) -> Any:
    """The application: the page, its parts, and the socket for its requests."""
    import anyio
    from starlette.applications import Starlette
    from starlette.requests import Request
    from starlette.responses import Response
    from starlette.routing import Route, WebSocketRoute
    from starlette.websockets import WebSocket, WebSocketDisconnect

    limiter = anyio.CapacityLimiter(AT_ONCE)
    pages: set[int] = set()
    parts = {path.name: (path.read_bytes(), KINDS[path.suffix]) for path in PAGE.iterdir() if path.suffix in KINDS}

    def reply(status: int, content: bytes | str, kind: str = KINDS[".txt"]) -> Response:
        return Response(content, status, HEADERS, f"{kind}; charset=utf-8")

    def nothing(*_: object) -> Response:
        return reply(404, "Not found.\n")

    def is_meant(connection: Request | WebSocket) -> bool:
        """Whether its host is a name of this machine, against DNS rebinding; any host is right beyond loopback."""
        try:
            name = urlsplit(f"//{connection.headers.get('host', '')}").hostname
        except ValueError:
            return False
        return served.host not in LOOPBACK or name in LOOPBACK

    async def page(request: Request) -> Response:
        if not is_meant(request):
            return reply(421, "This server answers only under its own address.\n")
        if not _knows(served, request.url.query):
            return reply(403, "This address lacks the token: open the one that swarmcensus watch printed.\n")
        return reply(200, live_page(), KINDS[".html"])

    async def part(request: Request) -> Response:
        name = request.path_params["name"]
        return reply(200, *parts[name]) if is_meant(request) and name in parts else nothing()

    async def saved(request: Request) -> Response:
        """The page with one trial, as a file to keep; an error is sent as text."""
        if not is_meant(request) or not _knows(served, request.url.query):
            return reply(403, "This address lacks the token.\n")
        ask = {key: value for key, value in request.query_params.items() if key != "token"}
        play = {key: ask.pop(key) for key in PLAYED if key in ask}

        def written() -> str:
            check_moment(wanted(served.offer, ask), play)
            return page_of(served.offer, ask, play)

        try:
            text = await anyio.to_thread.run_sync(written, limiter=limiter)
        except InputError as error:
            return reply(422, str(error))
        return reply(200, text, KINDS[".html"])

    async def talk(page: WebSocket) -> None:
        host, origin = page.headers.get("host", ""), page.headers.get("origin")
        same = origin is not None and origin.partition("://")[2] == host
        if not (same and is_meant(page) and _knows(served, page.url.query)) or len(pages) >= MOST_PAGES:
            await page.close(1008)
            return
        await page.accept()
        pages.add(id(page))
        session = Session(served.offer, served.interprets)
        into, requests = anyio.create_memory_object_stream[str | bytes](MOST_WAITING)
        try:
            async with anyio.create_task_group() as talking:
                talking.start_soon(listen, page, into, talking.cancel_scope)
                async for text in requests:
                    for answer in await anyio.to_thread.run_sync(answered, session, text, limiter=limiter):
                        await say(page, answer)
        except* (WebSocketDisconnect, RuntimeError):  # the page was closed meanwhile
            pass
        finally:
            pages.discard(id(page))
            into.close()
            requests.close()

    async def listen(page: WebSocket, into: Any, talking: Any) -> None:
        """Receive requests while others are answered: an unread one would block the pings behind it."""
        while (message := await page.receive())["type"] != "websocket.disconnect":
            await into.send(message["text"] if message.get("text") is not None else message["bytes"])
        talking.cancel()  # its last requests need no answer

    def answered(session: Session, text: str | bytes) -> list[Spoken]:
        return spoken(session.answer(text))

    async def say(page: WebSocket, answer: Spoken) -> None:
        if isinstance(answer, bytes):
            await page.send_bytes(answer)
        else:
            await page.send_text(answer)

    app = Starlette(
        routes=[Route("/", page), Route("/run.html", saved), Route("/{name}", part), WebSocketRoute("/live", talk)],
        exception_handlers={404: nothing, 405: nothing},
    )
    app.router.redirect_slashes = False  # a redirect would answer any host, and lack our headers
    return app


def _knows(served: Served, query: str) -> bool:
    try:
        given = parse_qs(query, max_num_fields=20).get("token", [""])[0]
    except ValueError:
        return False
    return secrets.compare_digest(given.encode(), served.token.encode())


def warm(served: Served, query: Mapping[str, str], until: contextlib.ExitStack | None = None) -> None:
    """Compute the first frames while the browser is still opening, then close `until`."""

    def begin() -> None:
        with until or contextlib.ExitStack():
            page = Session(served.offer, served.interprets)
            page.answer(json.dumps({"do": "begin", "ask": dict(query)}))
            page.answer(json.dumps({"do": "frames", "from": 0, "count": 2}))

    threading.Thread(target=begin, daemon=True).start()


def serve(served: Served) -> None:
    """Serve until Ctrl-C, or until the process ends if a shell runs it in the background, where Ctrl-C is ignored.

    The server has its own thread, so that no computation or compilation for a page delays the end of the process.
    """
    with serving(served) as thread, contextlib.suppress(KeyboardInterrupt):
        while thread.is_alive():
            time.sleep(0.5)  # not join: in Python 3.11 a join that Ctrl-C interrupts marks the thread as ended


@contextlib.contextmanager
def serving(served: Served) -> Iterator[threading.Thread]:
    """Serve in a thread while a block runs; computations that run when the block ends are abandoned."""
    import uvicorn

    server = uvicorn.Server(uvicorn.Config(
        app_of(served), log_level="critical", lifespan="off", ws="websockets-sansio", ws_max_size=4 * MOST_TEXT,
        ws_max_queue=4, ws_per_message_deflate=False, timeout_graceful_shutdown=1, server_header=False,
        proxy_headers=False,
    ))  # fmt: skip
    run = contextvars.copy_context().run  # messages name options as the command or function that started the server
    thread = threading.Thread(target=run, args=(server.run, [served.socket]), daemon=True)  # so are threads it starts
    thread.start()
    while not server.started and thread.is_alive():
        time.sleep(0.01)
    try:
        yield thread
    finally:
        server.should_exit = True
        thread.join(5.0)
        served.socket.close()
