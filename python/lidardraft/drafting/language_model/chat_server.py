"""A chat server with the API that OpenAI made common: OpenAI, vLLM, llama.cpp, Ollama, LM Studio, ...

The only file of lidardraft that opens a socket: one request and its answer, within limits of time and size.
"""

from __future__ import annotations

import http.client
import json
import os
import queue
import threading
import time
import urllib.error
import urllib.request
from dataclasses import dataclass
from email.message import Message
from email.utils import parsedate_to_datetime
from http import HTTPStatus
from typing import Any
from urllib.parse import urlsplit

from lidardraft.errors import FormatError, LanguageModelError
from lidardraft.json_fields import is_number, parse_object

URL, MODEL, KEY = "LIDARDRAFT_LLM_URL", "LIDARDRAFT_LLM_MODEL", "LIDARDRAFT_LLM_KEY"  # variables of the environment
_EXAMPLE = "http://localhost:11434/v1"
_WAITS = (1.0, 4.0)  # s before a busy server is asked again, if it does not say how long
_BUSY = (408, 429, 502, 503, 504)
_OPTION_REFUSED = (400, 422, 500, 501)  # statuses of servers that refuse a `response_format`
_LONGEST_QUOTE = 300  # characters of a server's text, in a message
_SHORTEST_SECRET = 8  # characters; "none" or "EMPTY" are not secret, and occur in many replies
_LONGEST = 1e6  # s, of a time limit: more than a week, and within the limits of threads
MAX_BYTES = 2**22  # of an answer; a scene of 5,000 objects has less


@dataclass(frozen=True, slots=True)
class ChatReply:
    """A model's reply; `is_cut` if the server stopped it before its end. `model` is the server's name for the model."""

    text: str
    model: str
    is_cut: bool = False


@dataclass(frozen=True, slots=True)
class ChatServer:
    """A server of language models: the `url` of the API, which ends in /v1 on most servers, and the name of the
    `model`.

    The key, if the server needs one, is in the environment variable LIDARDRAFT_LLM_KEY and nowhere else.
    """

    url: str
    model: str

    def __post_init__(self) -> None:
        if not self.url:
            raise LanguageModelError(f"no language model is named; {URL} or --llm-url is its server, as in {_EXAMPLE}")
        if "@" in self.url or "?" in self.url or "#" in self.url:  # it is not shown, as it may hold a secret
            raise LanguageModelError(f"the URL of a language model has no user, query or fragment: {_EXAMPLE}")
        try:
            parts = urlsplit(self.url)
            usable = parts.scheme in ("http", "https") and bool(parts.hostname) and parts.port != 0
        except ValueError:
            usable = False
        if not usable or not self.url.isprintable() or " " in self.url:
            raise LanguageModelError(f"the URL of the language model is {self.url!r}; it must be as {_EXAMPLE}")
        if not self.model or not isinstance(self.model, str):
            raise LanguageModelError(f"which model of {self.url} to ask is not given; {MODEL} or --llm-model names it")
        object.__setattr__(self, "url", self.url.rstrip("/").removesuffix("/chat/completions"))

    def reply(self, messages: list[dict[str, str]], options: dict[str, Any], limit: TimeLimit) -> ChatReply:
        """The model's reply to a chat; a server that refuses the `options` is asked without them.

        A busy server is asked again, up to twice, after the time that it asks for. Raises `LanguageModelError` in one
        line for every other failure, and at the end of the time limit.
        """
        asked = {"model": self.model, "messages": messages}
        answer = self._ask(asked | options, limit)
        if options and answer.status in _OPTION_REFUSED:
            answer = self._ask(asked, limit)
        try:
            return _reply_of(answer)
        except LanguageModelError as error:
            raise LanguageModelError(f"{self.url}: {_without_key(str(error))}") from None

    def _ask(self, body: dict[str, Any], limit: TimeLimit) -> HttpAnswer:
        for usual_wait in (*_WAITS, None):
            answer = self._post(body, limit)
            if answer.status not in _BUSY or usual_wait is None:
                break
            asked_for = answer.retry_after()
            wait = usual_wait if asked_for is None else asked_for
            if wait >= limit.left:
                break
            time.sleep(wait)
        return answer

    def _post(self, body: dict[str, Any], limit: TimeLimit) -> HttpAnswer:
        headers = {"Content-Type": "application/json", "Accept": "application/json", "User-Agent": "lidardraft"}
        if key := _key():
            headers["Authorization"] = f"Bearer {key}"
        try:
            return _without_key_in(post(f"{self.url}/chat/completions", headers, json.dumps(body).encode(), limit))
        except TimeoutError:
            raise LanguageModelError(f"{self.url}: no whole answer within {limit.seconds:g} s") from None
        except OSError as error:
            said = error.strerror or str(error) or type(error).__name__
            raise LanguageModelError(f"{self.url}: {_without_key(said)}") from None


def _key() -> str:
    key = os.environ.get(KEY, "").strip()
    if not (key.isascii() and key.isprintable()):
        raise LanguageModelError(f"the key in {KEY} has characters that no key has")
    return key


def _without_key(text: str) -> str:
    """The text with the key masked, as a server may have put it there."""
    key = _key()
    return text.replace(key, "[key]") if len(key) >= _SHORTEST_SECRET else text


def _without_key_in(answer: HttpAnswer) -> HttpAnswer:
    """The answer with the key masked everywhere, as messages may quote any part: a quote could cut the key and show
    half."""
    key, headers = _key(), Message()
    if len(key) < _SHORTEST_SECRET:
        return answer
    for name, value in answer.headers.items():
        headers[name] = value.replace(key, "[key]")
    return HttpAnswer(answer.status, headers, answer.body.replace(key.encode(), b"[key]"))


def _reply_of(answer: HttpAnswer) -> ChatReply:
    if answer.status != 200:
        raise LanguageModelError(_refusal(answer))
    if len(answer.body) > MAX_BYTES:
        raise LanguageModelError(f"an answer of more than {MAX_BYTES} bytes")
    try:
        body = parse_object(answer.body)
    except FormatError as error:
        kind = answer.headers.get("Content-Type", "of no type")
        raise LanguageModelError(f"an answer ({kind:.100}) that is {error}; is this the URL of the API?") from None
    choices = body.get("choices")
    choice = choices[0] if isinstance(choices, list) and choices else None
    message = choice.get("message") if isinstance(choice, dict) else None
    if choice is None or not isinstance(message, dict):
        said = _said(answer.body)
        raise LanguageModelError("an answer without a choice" + (f": {said}" if "error" in body else ""))
    text, stopped = _text_of(message.get("content")), choice.get("finish_reason")
    if message.get("refusal"):
        raise LanguageModelError(f"the model refuses: {_without_key(str(message['refusal']))[:_LONGEST_QUOTE]}")
    if stopped == "content_filter":
        raise LanguageModelError("the answer is withheld by a content filter")
    if stopped != "length" and not (isinstance(text, str) and text.strip()):
        raise LanguageModelError("an answer without text")
    # lone surrogates, as from "\ud83d" in JSON, have no UTF-8
    whole = str(text or "").encode("utf-8", "replace").decode()
    return ChatReply(_without_key(whole), _without_key(str(body.get("model", ""))[:200]), stopped == "length")


def _text_of(content: Any) -> Any:
    """The content of a message; if it comes in parts, their texts joined."""
    if not isinstance(content, list):
        return content
    texts = [part.get("text") for part in content if isinstance(part, dict) and part.get("type") == "text"]
    return "".join(text for text in texts if isinstance(text, str))


def _refusal(answer: HttpAnswer) -> str:
    """The message for an answer that is not a success."""
    known = answer.status in HTTPStatus.__members__.values()
    status = f"{answer.status} {HTTPStatus(answer.status).phrase}" if known else str(answer.status)
    if 300 <= answer.status < 400:
        target = answer.headers.get("Location", "nowhere")[:_LONGEST_QUOTE].partition("?")[0]
        return f"{status}: the API is at {target}; redirections are not followed, give that URL"
    said = f"{status}: {_said(answer.body)}".rstrip(": ")
    if answer.status in (401, 403):
        return f"{said}; the key is that of the environment variable {KEY}" + ("" if _key() else ", and it is empty")
    if answer.status == 404:
        return f"{said}; the URL must be that of the API, as in {_EXAMPLE}, and the server must have the model"
    wait = answer.retry_after()
    return said if wait is None else f"{said}; it can be asked again in {wait:.0f} s"


def _said(body: bytes) -> str:
    """The message of an error, in the usual places: {"error": {"message": ..}}, {"error": ..}, {"message": ..}, ..."""
    try:
        found: Any = parse_object(body)
    except FormatError:
        return " ".join(body[:_LONGEST_QUOTE].decode("utf-8", "replace").split())
    for name in ("error", "message", "detail"):
        if isinstance(found, dict) and found.get(name):
            found = found[name]
    return " ".join(_without_key(str(found)).split())[:_LONGEST_QUOTE]


@dataclass(frozen=True, slots=True)
class HttpAnswer:
    """A server's answer of any status; `body` has `MAX_BYTES` + 1 bytes if the answer is longer than the limit."""

    status: int
    headers: Message
    body: bytes

    def retry_after(self) -> float | None:
        """The time [s] to wait that the server asks for; None if it says nothing readable."""
        said = self.headers.get("Retry-After", "").strip()
        if said.isdecimal() and len(said) < 10:
            return float(said)
        try:
            wait = parsedate_to_datetime(said).timestamp() - time.time()
        except (ValueError, OverflowError):
            return None
        return max(0.0, wait)


class TimeLimit:
    """A number of seconds over 0, counted from its creation."""

    def __init__(self, seconds: float) -> None:
        if not (is_number(seconds) and 0 < seconds <= _LONGEST):
            limits = f"over 0, up to {_LONGEST:g}"
            raise LanguageModelError(f"the time limit is {seconds!r}; it must be a number of seconds {limits}")
        self.seconds, self._end = float(seconds), time.monotonic() + seconds

    @property
    def left(self) -> float:
        """The seconds left, 0 at the end."""
        return max(0.0, self._end - time.monotonic())


class _NothingFollowed(urllib.request.HTTPErrorProcessor):
    """Returns answers of every status unchanged: a redirection would carry the key to another server."""

    def http_response(self, _request: Any, response: Any) -> Any:
        return response

    def https_response(self, _request: Any, response: Any) -> Any:
        return response


def post(url: str, headers: dict[str, str], body: bytes, limit: TimeLimit) -> HttpAnswer:
    """The server's answer to a POST at an http or https URL; proxies are those of the environment.

    Raises `TimeoutError` at the end of the limit, whatever the server does, and another `OSError` if there is no
    answer: no such name, no connection, no valid certificate, no HTTP.
    """
    answers: queue.SimpleQueue[HttpAnswer | Exception] = queue.SimpleQueue()
    request = urllib.request.Request(url, body, headers, method="POST")

    def ask() -> None:
        try:
            answers.put(_answer(request, limit))
        except Exception as error:  # passed to the waiting thread
            answers.put(error)

    # A socket's own timeout restarts with each byte, and the look-up of a name has none: so a thread, left behind.
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
