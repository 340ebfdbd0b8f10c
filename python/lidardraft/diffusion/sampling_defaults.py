"""How a scan is sampled where nothing else is said; no torch, so that the command line can tell it at once."""

STEPS = 20  # calls of the network, two each where a ControlNet is guided
GUIDANCE = 2.0  # how many times what a ControlNet changes of its base counts
