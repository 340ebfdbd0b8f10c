"""The errors that bad input gets. Each message names the thing, the value and the limit."""


class LidarDraftError(ValueError):
    """Something given to lidardraft cannot be used; the base of the family."""


class LayoutError(LidarDraftError):
    """A primitive, a layout or a pose that cannot be."""


class SensorError(LidarDraftError):
    """A sensor description that cannot be, or an image of another sensor."""


class FormatError(LidarDraftError):
    """A file that is broken, truncated or not what its name says."""


class TextError(LidarDraftError):
    """A sentence of which nothing was understood."""


class CheckpointError(LidarDraftError):
    """A weight file that is not ours or does not fit."""


class TrainingError(LidarDraftError):
    """A training run that cannot start or go on."""
