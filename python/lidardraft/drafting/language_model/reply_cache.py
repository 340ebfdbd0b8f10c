"""Replies of language models on disk: the same request gives the same layout, without a server."""

from __future__ import annotations

import json
import os
import sys
import warnings
from collections.abc import Sequence
from pathlib import Path

from lidardraft.drafting.language_model.chat_server import ChatReply
from lidardraft.errors import FormatError, LidarDraftError
from lidardraft.files import named, read_text, written_whole
from lidardraft.json_fields import check_fields, check_object, parse_object

_SCHEMA = "lidardraft.replies/1"
# The variable that says where caches are, and where they are in a home without it.
_CACHES = {"win32": ("LOCALAPPDATA", "AppData", "Local"), "darwin": ("XDG_CACHE_HOME", "Library", "Caches")}
_FIELDS = {"text": str, "model": str, "is_cut": bool}


def cache_folder() -> Path:
    """Where this user's caches are by the rules of the platform, and in it the folder of lidardraft's replies.

    Raises `FormatError` where the user has no home.
    """
    variable, *below = _CACHES.get(sys.platform, ("XDG_CACHE_HOME", ".cache"))
    try:
        caches = Path(os.environ.get(variable) or Path.home().joinpath(*below))
    except RuntimeError as error:
        raise FormatError(f"no folder for the replies of language models: {error}") from None
    return caches / "lidardraft" / "replies"


class ReplyCache:
    """A folder with a file for each request: the replies that it got, of which the last one was good."""

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = Path(folder)

    def make_folder(self) -> None:
        """Raises `FormatError` where the folder cannot be made or written to, before a reply is asked for in vain."""
        reason = "it may not be written to"
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            usable = os.access(self.folder, os.W_OK | os.X_OK)
        except (OSError, ValueError) as error:
            usable, reason = False, getattr(error, "strerror", None) or str(error)
        if not usable:
            raise FormatError(f"{self.folder}: replies of language models cannot be kept there: {reason}")

    def find(self, request: str) -> list[ChatReply]:
        """The replies to the request of that hash, none where there are none; a broken file is a `UserWarning`."""
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


def _replies(text: str) -> list[ChatReply]:
    document = parse_object(text)
    check_fields(document, ("schema", "replies"))
    if document["schema"] != _SCHEMA:
        raise FormatError(f"schema is {document['schema']!r}; it must be {_SCHEMA!r}")
    if not isinstance(document["replies"], list):
        raise FormatError("replies is no list")
    for reply in document["replies"]:
        check_fields(check_object(reply), _FIELDS)
        for name, kind in _FIELDS.items():
            if type(reply[name]) is not kind:
                raise FormatError(f"{name} is {reply[name]!r:.50}; it must be of type {kind.__name__}")
    return [ChatReply(**reply) for reply in document["replies"]]
