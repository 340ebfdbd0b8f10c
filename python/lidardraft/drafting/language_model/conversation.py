"""A request to a language model and its outcome: unusable replies go back with the reason."""

from __future__ import annotations

import hashlib
import json
import os
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from string import Template
from typing import Any, Generic, TypeVar

from lidardraft.drafting.language_model.chat_server import ChatReply, ChatServer, TimeLimit
from lidardraft.errors import FormatError, LanguageModelError, LayoutError, LidarDraftError
from lidardraft.files import named, read_text, written_whole
from lidardraft.json_fields import parse_object

T = TypeVar("T")
MAX_ATTEMPTS = 3  # the first one and two retries
_PROMPTS = Path(__file__).with_name("prompts")
_LONGEST_ECHO = 20_000  # characters of a refused reply sent back to the model
_SCHEMA = "lidardraft.replies/1"
_FIELDS = {"text": str, "model": str, "is_cut": bool}


@dataclass(frozen=True, slots=True)
class Prompt:
    """Instructions for a model: their `name`, that of a file in `prompts/`, and their `text`."""

    name: str
    text: str

    @classmethod
    def from_file(cls, name: str, **values: str) -> Prompt:
        """The packaged prompt of that name, with its $names replaced by `values`."""
        return cls(name, Template(read_text(_PROMPTS / f"{name}.md")).substitute(values))

    @property
    def version(self) -> str:
        """Its name and the start of the hash of its text, which changes with each letter."""
        return f"{self.name}-{_sha256(self.text)[:12]}"


@dataclass(frozen=True, slots=True)
class Request:
    """A request to a server: a prompt, the text of the user, and options such as `response_format`."""

    server: ChatServer
    prompt: Prompt
    text: str
    options: dict[str, Any]

    @property
    def messages(self) -> list[dict[str, str]]:
        """The beginning of the chat."""
        return [{"role": "system", "content": self.prompt.text}, {"role": "user", "content": self.text}]

    @property
    def sha256(self) -> str:
        """The hash of everything that decides the reply: server, model, prompt, text and options."""
        fields = {"url": self.server.url, "model": self.server.model, "messages": self.messages, **self.options}
        return _sha256(json.dumps(fields, sort_keys=True))


@dataclass(frozen=True, slots=True)
class Attempt:
    """A reply, and the reason why it was refused; None for the accepted one."""

    reply: ChatReply
    error: str | None


@dataclass(frozen=True, slots=True)
class Conversation(Generic[T]):
    """The outcome of a request: the result of its last attempt."""

    request: Request
    attempts: tuple[Attempt, ...]
    result: T

    def provenance(self) -> dict[str, Any]:
        """The origin of the result, as JSON types, without the server and the key."""
        replies = [attempt.reply for attempt in self.attempts]
        return {
            "model": self.request.server.model,
            "answered_by": replies[-1].model,
            "prompt": self.request.prompt.version,
            "request_sha256": self.request.sha256,
            "attempts": [{"reply_sha256": _sha256(a.reply.text), "error": a.error} for a in self.attempts],
            "reply": replies[-1].text,
        }


class ReplyCache:
    """A folder with a file for each request: its replies, of which the last one was accepted."""

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = Path(folder)

    def make_folder(self) -> None:
        """Raises `FormatError` if the folder cannot be created or written to, before a reply is requested in vain."""
        reason = "it may not be written to"
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            usable = os.access(self.folder, os.W_OK | os.X_OK)
        except (OSError, ValueError) as error:
            usable, reason = False, getattr(error, "strerror", None) or str(error)
        if not usable:
            raise FormatError(f"{self.folder}: cannot keep replies of language models: {reason}")

    def find(self, request: str) -> list[ChatReply]:
        """The replies to the request of that hash; an empty list if there are none. A broken file is a
        `UserWarning`."""
        path = self.path(request)
        if not path.exists():
            return []
        try:
            text = read_text(path)
            with named(path):
                return _replies(text)
        except LidarDraftError as error:
            warnings.warn(f"{error}; the model is asked again", stacklevel=2)
            return []

    def keep(self, request: str, replies: Sequence[ChatReply]) -> None:
        """Write the replies to a request."""
        document = {"schema": _SCHEMA, "replies": [{name: getattr(r, name) for name in _FIELDS} for r in replies]}
        with written_whole(self.path(request)) as path:
            path.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")

    def path(self, request: str) -> Path:
        """The file of the request of that hash."""
        return self.folder / f"{request}.json"


def _is_reply(row: Any) -> bool:
    return isinstance(row, dict) and {name: type(value) for name, value in row.items()} == _FIELDS


def _replies(text: str) -> list[ChatReply]:
    kept = parse_object(text)
    rows = kept.get("replies")
    if kept.get("schema") != _SCHEMA or not isinstance(rows, list) or not all(map(_is_reply, rows)):
        raise FormatError(f"it holds no replies in the schema {_SCHEMA!r}")
    return [ChatReply(**row) for row in rows]


def converse(request: Request, read: Callable[[str], T], cache: ReplyCache, limit: TimeLimit) -> Conversation[T]:
    """The conversation whose last reply `read` accepts: from the cache, or a new one, which is kept.

    `read` raises a `LidarDraftError` for a reply that it refuses. Raises `LanguageModelError` if the server gives no
    reply, and after `MAX_ATTEMPTS` refused replies.
    """
    attempts, result = [], None
    for reply in cache.find(request.sha256):
        attempt, result = _use(reply, read)
        attempts.append(attempt)
    if result is not None:
        return Conversation(request, tuple(attempts), result)
    cache.make_folder()
    attempts, messages = [], request.messages
    while len(attempts) < MAX_ATTEMPTS:
        attempt, result = _use(request.server.reply(messages, request.options, limit), read)
        attempts.append(attempt)
        if result is not None:
            cache.keep(request.sha256, [each.reply for each in attempts])
            return Conversation(request, tuple(attempts), result)
        messages = messages + _retry(attempt)
    model = request.server.model
    raise LanguageModelError(f"{model}: none of {MAX_ATTEMPTS} replies can be used; the last one: {attempts[-1].error}")


def once_more(read: Callable[[str], T], missing: Callable[[T], list[str]]) -> Callable[[str], T]:
    """`read`, but the first reply with something `missing` goes back to the model, unless it is the last one."""
    seen: list[bool] = []

    def checked(reply: str) -> T:
        seen.append(False)
        result = read(reply)
        lines = missing(result) if len(seen) < MAX_ATTEMPTS and not any(seen) else []
        if lines:
            seen[-1] = True
            raise LayoutError(f"{'; '.join(lines)}; add the missing parts")
        return result

    return checked


def _use(reply: ChatReply, read: Callable[[str], T]) -> tuple[Attempt, T | None]:
    try:
        result = read(reply.text)
    except LidarDraftError as error:
        cut = f"it is cut off after {len(reply.text)} characters, write a shorter one; " if reply.is_cut else ""
        return Attempt(reply, f"{cut}{error}"), None
    return Attempt(reply, None), result


def _retry(attempt: Attempt) -> list[dict[str, str]]:
    """The next messages of a chat after a refused reply."""
    told = Prompt.from_file("retry", error=str(attempt.error)).text
    shown = attempt.reply.text[:_LONGEST_ECHO] or "(nothing)"
    return [{"role": "assistant", "content": shown}, {"role": "user", "content": told}]


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()
