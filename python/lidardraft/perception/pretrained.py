"""Networks of the transformers library, by id or by folder; what is missing is one clear line."""

from __future__ import annotations

import os
from importlib.util import find_spec
from typing import Any

import torch

from lidardraft.errors import CheckpointError

_FILES = "--depth FILE, --semantics FILE and --masks FILE need no network"


def auto_class(name: str) -> Any:
    """A class of transformers such as "AutoModelForDepthEstimation"; raises `CheckpointError` where it is missing."""
    if find_spec("transformers") is None:
        raise CheckpointError("networks for pictures need the extra `image`: pip install 'lidardraft[image]'")
    import transformers

    return getattr(transformers, name)


def load_pretrained(kind: str, class_name: str, name: str | os.PathLike[str], **options: Any) -> Any:
    """What a class of transformers loads from a folder or, where there is none, from the hub or its cache.

    `kind` is what the message calls it. Weights are read from safetensors files alone, and code of others is never run.
    Raises `CheckpointError` where it is not there or does not fit.
    """
    loader, source = auto_class(class_name), os.fspath(name)
    try:
        return loader.from_pretrained(source, **options)
    except Exception as error:  # whatever the library and those below it raise on files of others
        said = next((line for line in str(error).splitlines() if line.strip()), type(error).__name__)
        raise CheckpointError(f"{kind} {source!r} cannot be loaded: {said.strip()}; {_FILES}") from None


def load_network(kind: str, class_name: str, name: str | os.PathLike[str], device: str) -> torch.nn.Module:
    """A model of transformers, in evaluation mode on a device."""
    network = load_pretrained(kind, class_name, name, use_safetensors=True)
    try:
        placed: torch.nn.Module = network.to(device).eval()
    except (RuntimeError, AssertionError) as error:  # torch's, for a device it does not have
        raise CheckpointError(f"device is {device!r}: {str(error).splitlines()[0]}") from None
    return placed
