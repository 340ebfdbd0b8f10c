"""The server of studios: a session for each visitor, available again after a reload or a lost connection."""

from __future__ import annotations

import contextlib
import io
import secrets
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import viser

from lidardraft.studio.editor import Editor
from lidardraft.studio.page import BrowserPage, Inputs
from lidardraft.studio.session import Session, hear

MOST_VISITORS = 16
KEPT, IDLE = 600.0, 3600.0  # s, of a session without a page, and of one without edits
_COOKIE = "lidardraft-visits"  # in the browser's storage: random names of sessions, not of files


class Studio:
    """A server on 127.0.0.1, on `port` or the next free one; `begin` makes the first scene of a visitor."""

    def __init__(self, begin: Callable[[], Editor], inputs: Inputs, port: int = 8080) -> None:
        self._begin, self._inputs = begin, inputs
        self._sessions: dict[str, Session] = {}
        self._names: dict[int, str] = {}
        self._lock = threading.Lock()
        with contextlib.redirect_stdout(io.StringIO()):  # a panel of viser's, useless on the command line
            self._server = viser.ViserServer(host="127.0.0.1", port=port, label="lidardraft studio", verbose=False)
        # a page could request a public tunnel
        self._server.request_share_url = lambda *_, **__: None  # type: ignore[method-assign]
        self._server.on_client_connect(self._came)
        self._server.on_client_disconnect(self._left)

    @property
    def port(self) -> int:
        """The port of the server."""
        return self._server.get_port()

    @property
    def url(self) -> str:
        """The address of the page."""
        return f"http://127.0.0.1:{self.port}"

    @property
    def sessions(self) -> dict[str, Session]:
        """The kept sessions, by their names."""
        with self._lock:
            return dict(self._sessions)

    def stop(self) -> None:
        """End all sessions, and the server."""
        for session in self.sessions.values():
            session.end()
        self._server.stop()

    def tidy(self) -> None:
        """End the sessions that have been unused for long."""
        now = time.monotonic()
        with self._lock:
            old = [
                name
                for name, session in self._sessions.items()
                if now - session.used > (KEPT if session.page is None else IDLE)
            ]
            for name in old:
                session = self._sessions.pop(name)
                session.tell(
                    "This studio ends, as nothing was edited for an hour; reload the page for a new one.", is_error=True
                )
                session.end()

    def _came(self, client: Any) -> None:
        try:
            known = (client.local_storage.get_item(_COOKIE, timeout=5.0) or "").split()
        except (RuntimeError, TimeoutError):
            known = []
        self.tidy()
        with self._lock:
            name = next((one for one in known if one in self._sessions and self._sessions[one].page is None), None)
            if name is None and len(self._sessions) >= MOST_VISITORS:
                spare = [one for one, session in self._sessions.items() if session.page is None]
                if not spare:
                    client.add_notification("The studio is full", f"{MOST_VISITORS} people use it; come back later.")
                    return
                self._sessions.pop(spare[0]).end()
            if name is None:
                name = secrets.token_urlsafe(12)
                self._sessions[name] = Session(self._begin())
            session = self._sessions[name]
            self._names[client.client_id] = name
            kept = [one for one in known if one in self._sessions and one != name]
        client.local_storage.set_item(_COOKIE, " ".join((name, *kept)))
        BrowserPage(client, session, self._inputs)

    def _left(self, client: Any) -> None:
        with self._lock:
            session = self._sessions.get(self._names.pop(client.client_id, ""))
        if session is not None:
            session.leave()


@contextlib.contextmanager
def served(begin: Callable[[], Editor], inputs: Inputs, port: int = 8080) -> Iterator[Studio]:
    """A studio that ends with the block."""
    with warnings.catch_warnings():
        warnings.simplefilter("always", UserWarning)
        warnings.filterwarnings("ignore", message="Queued a .* on a closed connection")  # the visitor has left
        warnings.showwarning = lambda message, *_, **__: hear(str(message))
        studio = Studio(begin, inputs, port)
        try:
            yield studio
        finally:
            studio.stop()
