"""Options that have --text read by a language model instead of the grammar."""

from __future__ import annotations

import argparse
import os

from lidardraft.cli.arguments import number

_URL = "LIDARDRAFT_LLM_URL"  # as in chat_server.py, which loads HTTP


def add_language_model(parser: argparse.ArgumentParser) -> None:
    """--llm-url, --llm-model, --llm-blender, --llm-cache and --llm-timeout, in a group of their own."""
    group = parser.add_argument_group("language model (reads --text where its URL is given; else nothing is sent)")
    text = "server that answers as OpenAI's does, as in http://localhost:11434/v1 (default $LIDARDRAFT_LLM_URL; '' is "
    text += "none); its key, if it wants one, is read from $LIDARDRAFT_LLM_KEY alone"
    group.add_argument("--llm-url", metavar="URL", help=text)
    group.add_argument("--llm-model", metavar="NAME", help="model of the server (default $LIDARDRAFT_LLM_MODEL)")
    text = "have the model write a Blender script, which is read as data, instead of relations"
    group.add_argument("--llm-blender", action="store_const", const=True, help=text)
    text = "where replies are kept; the same request is not sent again (default: the user's cache folder)"
    group.add_argument("--llm-cache", metavar="FOLDER", help=text)
    text = "how long all replies together may take (default 120)"
    group.add_argument("--llm-timeout", type=number, metavar="SECONDS", help=text)


def asks_language_model(arguments: argparse.Namespace) -> bool:
    """Whether the arguments or the environment name a language model."""
    url = os.environ.get(_URL) if arguments.llm_url is None else arguments.llm_url
    return bool(url or arguments.llm_model or arguments.llm_blender)
