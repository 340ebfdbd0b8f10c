"""Weight files: one safetensors file, with the network's config and a card in its metadata. Nothing is ever unpickled.

The schema names the network of the weights.
"""

from __future__ import annotations

import json
import os
from typing import Any, ClassVar, Protocol, TypeVar

import torch
from safetensors import safe_open
from safetensors.torch import save as serialise
from torch import nn

from lidardraft.errors import CheckpointError, FormatError
from lidardraft.files import written_whole
from lidardraft.json_fields import parse_object
from lidardraft.networks.weight_header import read_metadata


class Config(Protocol):
    """The parameters of the shape of a network."""

    def to_dict(self) -> dict[str, Any]:
        """The fields as JSON types."""


class Network(nn.Module):
    """A torch module that a weight file can hold; its config builds it."""

    SCHEMA: ClassVar[str]
    config: Config

    @classmethod
    def from_dict(cls: type[NetworkT], fields: dict[str, Any]) -> NetworkT:
        """The network of `config.to_dict()`, with fresh weights."""
        raise NotImplementedError


NetworkT = TypeVar("NetworkT", bound=Network)


def save(network: Network, path: str | os.PathLike[str], card: dict[str, Any], *, half: bool = False) -> None:
    """Write the weights, as float16 if `half`. `card` holds JSON types, for `read_card`."""
    dtype = torch.float16 if half else torch.float32
    tensors = {name: t.detach().to("cpu", dtype).contiguous() for name, t in network.state_dict().items()}
    metadata = {
        "schema": network.SCHEMA,
        "config": json.dumps(network.config.to_dict()),
        "card": json.dumps(card),
    }
    with written_whole(path) as temporary:
        temporary.write_bytes(serialise(tensors, metadata))


def load(path: str | os.PathLike[str], network: type[NetworkT]) -> NetworkT:
    """The network of a weight file, float32 on the CPU, in evaluation mode; raises `CheckpointError`."""
    name, metadata = os.fspath(path), read_metadata(path)
    if metadata.get("schema") != network.SCHEMA:
        raise CheckpointError(f"{name}: schema is {metadata.get('schema')!r}; it must be {network.SCHEMA!r}")
    with safe_open(path, framework="pt") as file:
        try:
            built = network.from_dict(parse_object(metadata["config"]))
        except (KeyError, TypeError, ValueError, RuntimeError) as error:
            raise CheckpointError(f"{name}: its config makes no {network.__name__}: {error}") from None
        weights, names = built.state_dict(), set(file.keys())
        for problem, found in (("missing", set(weights) - names), ("unknown", names - set(weights))):
            if found:
                raise CheckpointError(f"{name}: tensor {min(found)!r} is {problem}")
        for key, weight in weights.items():
            tensor = file.get_tensor(key)
            if tensor.shape != weight.shape:
                raise CheckpointError(
                    f"{name}: tensor {key!r} is {list(tensor.shape)}; it must be {list(weight.shape)}"
                )
            if not tensor.isfinite().all():
                raise CheckpointError(f"{name}: tensor {key!r} holds values that are not finite")
            weight.copy_(tensor)
    return built.eval()


def read_card(path: str | os.PathLike[str]) -> dict[str, Any]:
    """The card of a weight file; raises `CheckpointError`."""
    metadata = read_metadata(path)
    if not metadata.get("schema", "").startswith("lidardraft."):
        raise CheckpointError(f"{os.fspath(path)}: schema is {metadata.get('schema')!r}; it must be of lidardraft")
    try:
        return parse_object(metadata.get("card", "{}"))
    except FormatError as error:
        raise CheckpointError(f"{os.fspath(path)}: the card is not a JSON object: {error}") from None
