"""A real HTTP server that replays answers, in the forms in which servers of language models give them."""

import json
import threading
from collections.abc import Callable
from dataclasses import dataclass
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any


@dataclass(frozen=True)
class Answer:
    """A status, a body (JSON unless it is bytes) and headers."""

    body: Any = b""
    status: int = 200
    headers: tuple[tuple[str, str], ...] = (("Content-Type", "application/json"),)

    def send(self, handler: BaseHTTPRequestHandler) -> None:
        data = self.body if isinstance(self.body, bytes) else json.dumps(self.body).encode()
        handler.send_response(self.status)
        for name, value in (*self.headers, ("Content-Length", str(len(data)))):
            handler.send_header(name, value)
        handler.end_headers()
        handler.wfile.write(data)


@dataclass(frozen=True)
class Drip:
    """Bytes that begin with `start` and go on with `piece`, a tenth of a second apart, until the server ends."""

    start: bytes = b""
    piece: bytes = b""


@dataclass(frozen=True)
class Received:
    """A request: its path, its headers in lower case, and its body."""

    path: str
    headers: dict[str, str]
    body: dict[str, Any]


class ReplayServer:
    """Gives one of its `answers` to each request, in order, and 500 when there are none left."""

    def __init__(self) -> None:
        self.answers: list[Answer | Drip] = []
        self.requests: list[Received] = []
        self._ended = threading.Event()
        self._server = ThreadingHTTPServer(("127.0.0.1", 0), self._handler())
        self._thread = threading.Thread(target=self._server.serve_forever, kwargs={"poll_interval": 0.01})
        self.host = f"127.0.0.1:{self._server.server_port}"
        self.url = f"http://{self.host}/v1"

    def __enter__(self) -> "ReplayServer":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._server.shutdown()
        self._thread.join()
        self._server.server_close()

    def _handler(self) -> type[BaseHTTPRequestHandler]:
        replay = self

        class Handler(BaseHTTPRequestHandler):
            def do_POST(self) -> None:
                body = self.rfile.read(int(self.headers["Content-Length"]))
                headers = {name.lower(): value for name, value in self.headers.items()}
                replay.requests.append(Received(self.path, headers, json.loads(body)))
                answer = replay.answers.pop(0) if replay.answers else Answer({"error": "no answer left"}, 500)
                try:
                    if isinstance(answer, Answer):
                        answer.send(self)
                    else:
                        replay._drip(self, answer)
                except OSError:
                    self.close_connection = True  # who asked has gone

            def log_message(self, *_: object) -> None: ...

        return Handler

    def _drip(self, handler: BaseHTTPRequestHandler, answer: Drip) -> None:
        handler.wfile.write(answer.start)
        while not self._ended.wait(0.1):
            if answer.piece:
                handler.wfile.write(answer.piece)
        handler.close_connection = True


# What a server answers whose model has written some text, after the documentation of each.
Dialect = Callable[..., Answer]


def openai(text: str | None, finish: str = "stop", refusal: str | None = None) -> Answer:
    message = {"role": "assistant", "content": text, "refusal": refusal, "annotations": []}
    details = {"cached_tokens": 0, "audio_tokens": 0}
    body = {
        "id": "chatcmpl-B9MBs8CjcvOU2jLn4n570S5qMJKcT",
        "object": "chat.completion",
        "created": 1741569952,
        "model": "gpt-4.1-2025-04-14",
        "choices": [{"index": 0, "message": message, "logprobs": None, "finish_reason": finish}],
        "usage": {"prompt_tokens": 19, "completion_tokens": 10, "total_tokens": 29, "prompt_tokens_details": details},
        "service_tier": "default",
        "system_fingerprint": None,
    }
    return Answer(body)


def vllm(text: str | None, finish: str = "stop") -> Answer:
    message = {"role": "assistant", "content": text, "refusal": None, "annotations": None, "audio": None}
    message |= {"function_call": None, "tool_calls": [], "reasoning": None}
    choice = {"index": 0, "message": message, "logprobs": None, "finish_reason": finish, "stop_reason": None}
    body = {
        "id": "chatcmpl-2a9ac1f1dcb14ff1a2a2ed2ec0a5e1d4",
        "object": "chat.completion",
        "created": 1763800000,
        "model": "Qwen/Qwen2.5-7B-Instruct",
        "choices": [choice],
        "service_tier": None,
        "system_fingerprint": None,
        "usage": {"prompt_tokens": 40, "total_tokens": 60, "completion_tokens": 20, "prompt_tokens_details": None},
        "prompt_logprobs": None,
        "kv_transfer_params": None,
    }
    return Answer(body)


def llama_cpp(text: str | None, finish: str = "stop") -> Answer:
    body = {
        "choices": [{"finish_reason": finish, "index": 0, "message": {"role": "assistant", "content": text}}],
        "created": 1763800000,
        "model": "qwen2.5-7b-instruct-q4_k_m.gguf",
        "system_fingerprint": "b7000-90e4dba4",
        "object": "chat.completion",
        "usage": {"completion_tokens": 20, "prompt_tokens": 40, "total_tokens": 60},
        "id": "chatcmpl-8lNlRnUwB8vQ5GmMrLyfvHMYL3CIXh5q",
        "timings": {"prompt_n": 40, "prompt_ms": 51.0, "predicted_n": 20, "predicted_ms": 210.5},
    }
    return Answer(body, headers=(("Content-Type", "application/json; charset=utf-8"),))


def ollama(text: str | None, finish: str = "stop") -> Answer:
    body = {
        "id": "chatcmpl-872",
        "object": "chat.completion",
        "created": 1763800000,
        "model": "llama3.2",
        "system_fingerprint": "fp_ollama",
        "choices": [{"index": 0, "message": {"role": "assistant", "content": text}, "finish_reason": finish}],
        "usage": {"prompt_tokens": 40, "completion_tokens": 20, "total_tokens": 60},
    }
    return Answer(body)


DIALECTS: dict[str, Dialect] = {"openai": openai, "vllm": vllm, "llama.cpp": llama_cpp, "ollama": ollama}
