"""Precision: bfloat16 where the processor multiplies it faster than float32, in training and in sampling alike."""

from __future__ import annotations

from typing import Any

import torch


def reduced_precision(device: torch.device) -> torch.autocast:
    """A context in which convolutions and linear layers work in bfloat16, where `device` has the instructions.

    Weights, norms' statistics and the optimiser stay float32. What must keep its digits leaves it by an
    `autocast(enabled=False)` of its own.
    """
    return torch.autocast(device.type, dtype=torch.bfloat16, enabled=has_bfloat16(device))


def has_bfloat16(device: torch.device) -> bool:
    """Whether bfloat16 is faster than float32: a CPU without the instructions emulates them."""
    capabilities: dict[str, Any] = getattr(torch.cpu, "get_capabilities", dict)()  # newer torch
    return device.type == "cuda" or bool(capabilities.get("avx512_bf16") or capabilities.get("amx_bf16"))
