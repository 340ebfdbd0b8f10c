import pytest
import torch

from lidardraft.networks import precision
from lidardraft.networks.precision import has_bfloat16, reduced_precision

CPU = torch.device("cpu")


@pytest.mark.parametrize("capability", ["avx512_bf16", "amx_bf16"])
def test_a_cpu_with_the_instructions_works_in_bfloat16(monkeypatch: pytest.MonkeyPatch, capability: str) -> None:
    monkeypatch.setattr(precision.torch.cpu, "get_capabilities", lambda: {capability: True}, raising=False)
    assert has_bfloat16(CPU)
    with reduced_precision(CPU):
        assert torch.nn.Conv2d(2, 2, 1)(torch.zeros(1, 2, 4, 4)).dtype == torch.bfloat16


@pytest.mark.parametrize("capabilities", [{}, {"avx512_bf16": False, "avx2": True}])
def test_a_cpu_without_them_stays_in_float32(monkeypatch: pytest.MonkeyPatch, capabilities: dict[str, bool]) -> None:
    monkeypatch.setattr(precision.torch.cpu, "get_capabilities", lambda: capabilities, raising=False)
    assert not has_bfloat16(CPU)
    with reduced_precision(CPU):
        assert torch.nn.Conv2d(2, 2, 1)(torch.zeros(1, 2, 4, 4)).dtype == torch.float32
