"""The channels of a network's states, conditions and rays; all without torch."""

DEPTH, INTENSITY, VALIDITY = range(3)  # channels of the state
CLASS = slice(3, 8)  # those of the bits of a class id, the lowest first (Chen et al., Analog Bits, ICLR 2023)
STATE_CHANNELS = 8
# The parts of a condition, and their channels: range and validity of the layout's cast, its class, the state of its
# simulated scan, and the pixels that the layout leaves open.
CONDITION_PARTS = {
    "depth": [DEPTH, VALIDITY],
    "class": list(range(CLASS.start, CLASS.stop)),
    "simulated": list(range(STATE_CHANNELS, 2 * STATE_CHANNELS)),
    "open": [2 * STATE_CHANNELS],
}
CONDITION_CHANNELS = 2 * STATE_CHANNELS + 1
RAY_CHANNELS = 5
HIDDEN = 4  # the channel of the rays for pixels that the vehicle hides
