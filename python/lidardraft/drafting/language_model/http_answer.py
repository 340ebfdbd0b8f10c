"""One HTTP request and its answer, within a time and a size: the only file of lidardraft that opens a socket."""

from __future__ import annotations

import http.client
import queue
import threading
import time
import urllib.error
import urllib.request
from dataclasses import dataclass, field
from email.message import Message
from email.utils import parsedate_to_datetime
from typing import Any

from lidardraft.errors import LanguageModelError
from lidardraft.json_fields import is_number

_LONGEST = 1e6  # s, of a time limit: more than a week, and what threads can wait for
MAX_BYTES = 2**22  # of an answer; a scene of 5,000 objects has less


@dataclass(frozen=True, slots=True)
class HttpAnswer:
    """What a server answers, whatever the status; `body` has `MAX_BYTES` + 1 bytes where it is longer than that."""

    status: int
    headers: Message
    body: bytes

    def retry_after(self) -> float | None:
        """How long the server asks to wait before it is asked again [s]; None where it says nothing readable."""
        said = self.headers.get("Retry-After", "").strip()
        if said.isdecimal() and len(said) < 10:
            return float(said)
        try:
            wait = parsedate_to_datetime(said).timestamp() - time.time()
        except (ValueError, OverflowError):
            return None
        return max(0.0, wait)


@dataclass(frozen=True, slots=True)
class TimeLimit:
    """A number of seconds over 0, which begin when it is made."""

    seconds: float
    _end: float = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if not (is_number(self.seconds) and 0 < self.seconds <= _LONGEST):
            limits = f"over 0, up to {_LONGEST:g}"
            raise LanguageModelError(f"the time limit is {self.seconds!r}; it must be a number of seconds {limits}")
        object.__setattr__(self, "seconds", float(self.seconds))
        object.__setattr__(self, "_end", time.monotonic() + self.seconds)

    @property
    def left(self) -> float:
        """The seconds that are left, 0 when it is over."""
        return max(0.0, self._end - time.monotonic())


class _NothingFollowed(urllib.request.HTTPErrorProcessor):
    """Answers of every status come back as they are: a redirection would carry the key to another server."""

    def http_response(self, _request: Any, response: Any) -> Any:
        return response

    def https_response(self, _request: Any, response: Any) -> Any:
        return response


def post(url: str, headers: dict[str, str], body: bytes, limit: TimeLimit) -> HttpAnswer:
    """What the server at an http or https URL answers to a POST; proxies are those of the environment.

    Raises `TimeoutError` when the limit is over, whatever the server does, and another `OSError` where there is no
    answer: no such name, no connection, no valid certificate, no HTTP.
    """
    answers: queue.SimpleQueue[HttpAnswer | Exception] = queue.SimpleQueue()
    request = urllib.request.Request(url, body, headers, method="POST")

    def ask() -> None:
        try:
            answers.put(_answer(request, limit))
        except Exception as error:  # carried over to the thread that waits
            answers.put(error)

    # A socket's own timeout starts again with each byte, and the search for a name has none: so a thread, left behind.
    threading.Thread(target=ask, name="lidardraft-http", daemon=True).start()
    try:
        answer = answers.get(timeout=limit.left)
    except queue.Empty:
        raise TimeoutError from None
    if isinstance(answer, urllib.error.URLError) and isinstance(answer.reason, Exception):
        raise answer.reason
    if isinstance(answer, http.client.HTTPException | ValueError):
        raise OSError(f"{type(answer).__name__}: {answer}")
    if isinstance(answer, Exception):
        raise answer
    return answer


def _answer(request: urllib.request.Request, limit: TimeLimit) -> HttpAnswer:
    opener = urllib.request.build_opener(_NothingFollowed)
    with opener.open(request, timeout=max(0.001, limit.left)) as response:
        parts, size = [], 0
        while size <= MAX_BYTES and (part := response.read1(min(2**16, MAX_BYTES + 1 - size))):
            parts.append(part)
            size += len(part)
            if not limit.left:
                raise TimeoutError
        return HttpAnswer(response.status, response.headers, b"".join(parts))
