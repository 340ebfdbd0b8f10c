"""A request and its replies: errors go back to the model, good replies are kept, and what is kept is read again."""

import json
import os
from pathlib import Path

import pytest

from lidardraft.drafting.language_model.chat_server import ChatReply, ChatServer, TimeLimit
from lidardraft.drafting.language_model.conversation import Conversation, Prompt, ReplyCache, Request, converse
from lidardraft.errors import FormatError, LanguageModelError, LayoutError
from replay_server import Answer, ReplayServer, ollama, openai

PROMPT = Prompt("numbers", "Write a number.")


def read(text: str) -> int:
    if not text.isdecimal():
        raise LayoutError(f"{text!r} is no number")
    return int(text)


def ask(server: ReplayServer, folder: Path, **options: object) -> Conversation[int]:
    request = Request(ChatServer(server.url, "small"), PROMPT, "seven", options)
    return converse(request, read, ReplyCache(folder), TimeLimit(60))


def test_errors_go_back_to_the_model(server: ReplayServer, tmp_path: Path) -> None:
    server.answers = [ollama("sieben"), ollama("se", finish="length"), ollama("7")]
    conversation = ask(server, tmp_path)
    assert conversation.result == 7
    cut = "it is cut off after 2 characters, write a shorter one; 'se' is no number"
    assert [attempt.error for attempt in conversation.attempts] == ["'sieben' is no number", cut, None]
    chats = [[(m["role"], m["content"]) for m in request.body["messages"]] for request in server.requests]
    assert chats[0] == [("system", "Write a number."), ("user", "seven")]
    assert chats[1][:3] == [*chats[0], ("assistant", "sieben")]
    assert chats[2][:4] == chats[1]
    assert chats[1][3][0] == chats[2][5][0] == "user"
    assert "'sieben' is no number" in chats[1][3][1]
    assert cut in chats[2][5][1]


def test_the_third_useless_reply_is_the_last(server: ReplayServer, tmp_path: Path) -> None:
    server.answers = [openai(text) for text in ("one", "two", "three", "4")]
    with pytest.raises(LanguageModelError, match="small: none of 3 replies can be used; the last one: 'three' is no"):
        ask(server, tmp_path)
    assert len(server.requests) == 3
    assert list(tmp_path.glob("*.json")) == []
    assert ask(server, tmp_path).result == 4


def test_a_reply_that_is_cut_and_can_be_used_is_used(server: ReplayServer, tmp_path: Path) -> None:
    server.answers = [openai("7", finish="length")]
    assert ask(server, tmp_path).result == 7


def test_a_kept_reply_that_cannot_be_used_is_asked_for_again(server: ReplayServer, tmp_path: Path) -> None:
    server.answers = [openai("7")]
    (path,) = (ask(server, tmp_path), *tmp_path.glob("*.json"))[1:]
    path.write_text(path.read_text().replace('"7"', '"seven"'))
    server.answers = [openai("8")]
    assert ask(server, tmp_path).result == 8
    assert ask(server, tmp_path).result == 8
    path.write_text("{")
    server.answers = [openai("9")]
    with pytest.warns(UserWarning, match="the model is asked again"):
        assert ask(server, tmp_path).result == 9


def test_a_request_is_known_by_all_that_its_reply_depends_on() -> None:
    server = ChatServer("http://one/v1", "small")
    requests = [
        Request(server, PROMPT, "seven", {}),
        Request(server, PROMPT, "eight", {}),
        Request(server, PROMPT, "seven", {"seed": 1}),
        Request(server, Prompt("numbers", "Write a number!"), "seven", {}),
        Request(ChatServer("http://one/v1", "large"), PROMPT, "seven", {}),
        Request(ChatServer("http://two/v1", "small"), PROMPT, "seven", {}),
    ]
    assert len({request.sha256 for request in requests}) == len(requests)
    assert Request(ChatServer("http://one/v1/", "small"), PROMPT, "seven", {}).sha256 == requests[0].sha256
    assert len({PROMPT.version, Prompt("numbers", "Write a number!").version}) == 2


def test_nothing_is_asked_where_no_reply_could_be_kept(server: ReplayServer, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for folder in (tmp_path / "file", tmp_path / "file" / "below", tmp_path / "\0"):
        with pytest.raises(FormatError, match="cannot keep replies of language models: "):
            ask(server, folder)
    assert server.requests == []


def test_a_long_reply_goes_back_in_part(server: ReplayServer, tmp_path: Path) -> None:
    server.answers = [openai("x" * 500_000), openai("7")]
    ask(server, tmp_path)
    assert len(server.requests[1].body["messages"][2]["content"]) == 20_000
    assert len(server.requests[1].body["messages"][3]["content"]) < 3000


def test_a_server_that_fails_is_not_asked_again(server: ReplayServer, tmp_path: Path) -> None:
    server.answers = [openai("sieben"), Answer({"error": {"message": "gone"}}, 500)]
    with pytest.raises(LanguageModelError, match="500 Internal Server Error: gone"):
        ask(server, tmp_path)


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
        json.dumps({"schema": "lidardraft.replies/1", "replies": 1}).encode(),
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
