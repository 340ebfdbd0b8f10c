"""Families of words: what a sentence speaks of or leaves out together."""

# How often a sentence names each family, and its words: an estimate of ours.
FAMILIES: dict[str, tuple[float, tuple[str, ...]]] = {
    "people": (0.85, ("person", "bicycle", "motorcycle")),
    "buildings": (0.9, ("house", "building")),
    "trees": (0.9, ("tree",)),
    "greenery": (0.6, ("bush", "hedge")),
    "enclosures": (0.6, ("fence", "wall")),
    "poles": (0.5, ("street-light", "pole", "traffic-sign", "traffic-light")),
    "furniture": (0.4, ("bin", "bench")),
}
ALWAYS_NAMED = ("car", "van", "truck", "bus", "tram")

# The number of a word's family; -1, the last, for what is always named, and for what no sentence speaks of.
FAMILY_OF: dict[str | None, int] = {
    **{word: number for number, (_, words) in enumerate(FAMILIES.values()) for word in words},
    **dict.fromkeys((*ALWAYS_NAMED, None), -1),
}
