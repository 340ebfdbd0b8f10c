"""How a scan is sampled where nothing else is said; no torch, so that the command line can tell it at once."""

STEPS = 4  # calls of the network, from a simulated scan
STEPS_FROM_NOISE = 20
START = 1.0  # the noise level from which a simulated scan is changed: buildings stay, what is unsure may move
