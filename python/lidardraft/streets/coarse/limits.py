"""The limits of numbers in styles."""

from typing import Any

from lidardraft.errors import LayoutError


def check_limits(style: Any, **limits: tuple[float, float]) -> None:
    """Raises `LayoutError` if a field of the style is below the first or over the second number given for it."""
    for name, (low, high) in limits.items():
        if not low <= getattr(style, name) <= high:
            raise LayoutError(f"{name} is {getattr(style, name)}; it must be {low:g} to {high:g}")
