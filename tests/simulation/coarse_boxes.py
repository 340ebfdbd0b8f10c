"""Single objects as a coarse layout has them, alone in their layout."""

from lidardraft import Intent, Layout, Primitive, detail


def box(
    label: str,
    size: tuple[float, float, float],
    *,
    at: tuple[float, float, float] = (15.0, 3.0, 0.0),
    yaw: float = 0.0,
    id: str = "",
    shape: str = "box",
    instance: int = 0,
) -> Primitive:
    """A shape whose base is at `at`."""
    x, y, bottom = at
    center = (x, y, bottom + size[2] / 2)
    return Primitive(
        shape=shape, center=center, size=size, label=label, id=id or f"{label}_1", yaw=yaw, instance=instance
    )


def detailed(*parts: Primitive, seed: int = 0, headed: bool = True) -> list[Primitive]:
    """What becomes of these shapes."""
    return list(detail(Layout(primitives=parts, intent=Intent(headed=headed)), seed=seed).primitives)


def materials(parts: list[Primitive]) -> set[str | None]:
    return {part.material for part in parts}
