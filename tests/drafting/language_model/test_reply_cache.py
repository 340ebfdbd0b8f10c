"""Replies on disk: found again, and never in the way where a file is spoiled."""

import json
import os
from pathlib import Path

import pytest

from lidardraft.drafting.language_model.chat_server import ChatReply
from lidardraft.drafting.language_model.reply_cache import ReplyCache, cache_folder
from lidardraft.errors import FormatError

REPLIES = [ChatReply("a b\u00fcs \u2028", "small"), ChatReply("", "small", is_cut=True)]


def test_what_is_kept_is_found_again(tmp_path: Path) -> None:
    cache = ReplyCache(tmp_path / "a" / "b")
    assert cache.find("12") == []
    cache.make_folder()
    cache.keep("12", REPLIES)
    assert cache.find("12") == REPLIES
    assert cache.find("34") == []
    assert [path.name for path in (tmp_path / "a" / "b").iterdir()] == ["12.json"]


REPLY = {"text": "a", "model": "b", "is_cut": False}


@pytest.mark.parametrize(
    "spoiled",
    [
        b"",
        b"\xff",
        b"[]",
        b"{" * 100_000,
        b'{"schema": "lidardraft.replies/1", "replies": [',
        json.dumps({"schema": "lidardraft.replies/2", "replies": []}).encode(),
        json.dumps({"schema": "lidardraft.replies/1", "replies": REPLY}).encode(),
        json.dumps({"schema": "lidardraft.replies/1", "replies": [1]}).encode(),
        json.dumps({"schema": "lidardraft.replies/1", "replies": [{**REPLY, "text": 5}]}).encode(),
        json.dumps({"schema": "lidardraft.replies/1", "replies": [{**REPLY, "is_cut": None}]}).encode(),
        json.dumps({"schema": "lidardraft.replies/1", "replies": [{"text": "a"}]}).encode(),
    ],
)
def test_a_spoiled_file_is_told_and_written_anew(tmp_path: Path, spoiled: bytes) -> None:
    cache = ReplyCache(tmp_path)
    cache.path("12").write_bytes(spoiled)
    with pytest.warns(UserWarning, match=r"12\.json.*; the model is asked again") as told:
        assert cache.find("12") == []
    assert str(told[0].message).count("12.json") == 1
    cache.keep("12", REPLIES)
    assert cache.find("12") == REPLIES


def test_a_device_in_the_place_of_a_file_is_told_and_left_alone(tmp_path: Path) -> None:
    cache = ReplyCache(tmp_path)
    os.mkfifo(cache.path("12"))
    with pytest.warns(UserWarning, match=r"12\.json is a FIFO"):
        assert cache.find("12") == []
    with pytest.raises(FormatError, match=r"12\.json cannot be written"):
        cache.keep("12", REPLIES)


def test_a_folder_that_cannot_be_is_told_before_anything_is_asked(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for folder in (tmp_path / "file", tmp_path / "file" / "below", tmp_path / "\0"):
        with pytest.raises(FormatError, match="replies of language models cannot be kept there: "):
            ReplyCache(folder).make_folder()


def test_the_folder_is_where_the_platform_has_its_caches(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert cache_folder() == tmp_path / ".cache" / "lidardraft" / "replies"
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "elsewhere"))
    assert cache_folder() == tmp_path / "elsewhere" / "lidardraft" / "replies"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setattr("sys.platform", "darwin")
    assert cache_folder() == tmp_path / "Library" / "Caches" / "lidardraft" / "replies"
    monkeypatch.setattr("sys.platform", "win32")
    monkeypatch.setenv("LOCALAPPDATA", str(tmp_path / "Local"))
    assert cache_folder() == tmp_path / "Local" / "lidardraft" / "replies"
