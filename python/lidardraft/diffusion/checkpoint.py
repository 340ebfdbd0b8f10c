"""Weight files: one safetensors file, the denoiser's config and a card in its metadata. Nothing is ever unpickled."""

from __future__ import annotations

import json
import os
from typing import Any

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save as serialise

from lidardraft.diffusion.denoiser import Denoiser, DenoiserConfig
from lidardraft.errors import CheckpointError
from lidardraft.files import written_whole

SCHEMA = "lidardraft.denoiser/1"


def save(denoiser: Denoiser, path: str | os.PathLike[str], card: dict[str, Any], *, half: bool = False) -> None:
    """Write the weights, as float16 if `half`. `card` holds JSON types: what `read_card` gives."""
    dtype = torch.float16 if half else torch.float32
    tensors = {name: t.detach().to("cpu", dtype).contiguous() for name, t in denoiser.state_dict().items()}
    metadata = {"schema": SCHEMA, "config": json.dumps(denoiser.config.to_dict()), "card": json.dumps(card)}
    with written_whole(path) as temporary:
        temporary.write_bytes(serialise(tensors, metadata))


def load(path: str | os.PathLike[str]) -> Denoiser:
    """The denoiser of a weight file, float32 on the CPU, in evaluation mode; raises `CheckpointError`."""
    with _Open(path) as file:
        try:
            config = DenoiserConfig.from_dict(json.loads(file.metadata["config"]))
            denoiser = Denoiser.from_config(config)
        except (KeyError, TypeError, ValueError, RuntimeError) as error:
            raise CheckpointError(f"{os.fspath(path)}: its config makes no denoiser: {error}") from None
        weights = denoiser.state_dict()
        names = set(file.tensors.keys())
        for problem, found in (("missing", set(weights) - names), ("unknown", names - set(weights))):
            if found:
                raise CheckpointError(f"{os.fspath(path)}: tensor {min(found)!r} is {problem}")
        for name, weight in weights.items():
            tensor = file.tensors.get_tensor(name)
            if tensor.shape != weight.shape:
                raise CheckpointError(
                    f"{os.fspath(path)}: tensor {name!r} is {list(tensor.shape)}; it must be {list(weight.shape)}"
                )
            if not tensor.isfinite().all():
                raise CheckpointError(f"{os.fspath(path)}: tensor {name!r} holds values that are not finite")
            weight.copy_(tensor)
    return denoiser.eval()


def read_card(path: str | os.PathLike[str]) -> dict[str, Any]:
    """The card of a weight file; raises `CheckpointError`."""
    with _Open(path) as file:
        try:
            card = json.loads(file.metadata.get("card", "{}"))
        except json.JSONDecodeError as error:
            raise CheckpointError(f"{os.fspath(path)}: the card is not JSON: {error}") from None
        return card if isinstance(card, dict) else {}


class _Open:
    """A safetensors file that says it is ours."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = os.fspath(path)

    def __enter__(self) -> _Open:
        try:
            self.tensors = safe_open(self.path, framework="pt").__enter__()  # type: ignore[no-untyped-call]
        except FileNotFoundError:
            raise CheckpointError(f"{self.path}: no such file") from None
        except (SafetensorError, OSError) as error:
            raise CheckpointError(f"{self.path} is no whole safetensors file: {error}") from None
        self.metadata: dict[str, str] = self.tensors.metadata() or {}
        if self.metadata.get("schema") != SCHEMA:
            self.__exit__(None, None, None)
            found = self.metadata.get("schema")
            raise CheckpointError(f"{self.path}: schema is {found!r}; this version reads {SCHEMA!r}")
        return self

    def __exit__(self, *error: object) -> None:
        self.tensors.__exit__(*(error or (None, None, None)))
