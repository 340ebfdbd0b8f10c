"""The channels of a network's states, conditions and rays; all without torch."""

DEPTH, INTENSITY, VALIDITY = range(3)  # channels of the state
CLASS = slice(3, 8)  # those of the bits of a class id, the lowest first (Chen et al., Analog Bits, ICLR 2023)
STATE_CHANNELS = 8
# The parts of a condition, which is the state of the layout's cast, and their channels: range and validity, and class.
CONDITION_PARTS = {"depth": [DEPTH, VALIDITY], "class": list(range(CLASS.start, CLASS.stop))}
RAY_CHANNELS = 5
