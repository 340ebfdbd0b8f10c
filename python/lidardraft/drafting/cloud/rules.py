"""The rules by which a labelled cloud becomes shapes. Numbers without a source are estimates.

The rules of the search itself are in `rust/core/cloud/`.
"""

from dataclasses import dataclass

# Classes with clusters that become upright cylinders, and classes that need not reach down to the ground.
POST_CLASSES = ("pole", "trunk", "traffic-light")
HANGING_CLASSES = ("vegetation", "traffic-sign", "traffic-light")

# Clusters: points within a reach are neighbours; it grows with the range, as gaps between beams do.
REACH = {"building": 1.0, "vegetation": 0.8}  # m, by class
OTHER_REACH = 0.5  # m, of all other classes
REACH_PER_RANGE = 0.01  # m more for each metre from the sensor
MIN_POINTS = 6  # of a cluster

# Boxes.
MIN_EXTENT = 0.1  # m, of any shape
SEEN_WHOLE = 0.7  # of the usual extent of a class; a longer side was seen whole, and is not completed
# A side longer than this many widths of the class is a length. Of 1.1 to 1.67, the smaller ones find the most of the
# cars with boxes in PandaSet (Xiao et al., ITSC 2021; CC BY 4.0).
LONGER_THAN_WIDE = 1.25

# Ground.
HANGING_HEIGHT = 2.5  # m; objects that begin higher over the ground do not stand on it
GROUND_PLANE_DROP = 0.3  # m from the lowest seen ground down to the plane under all of it
GROUND_PLANE_SIZE = 400.0  # m, length and width of that plane


@dataclass(frozen=True, kw_only=True, slots=True)
class Detail:
    """How finely foliage and facades are cut.

    At most `most_rays` rays, evenly chosen, decide how well shapes agree with them. A layout has about `most_shapes`
    shapes. A piece is halved if it is longer than `least_length` [m] and wrong for `worth` returns or more; a piece
    needs at least `least_points` points. With `grounded` all pieces reach down to the ground, and none is left out.
    Without, a piece is left out if it explains fewer than two returns or hides more than it explains.
    """

    most_rays: int
    most_shapes: int
    least_length: float
    worth: int
    least_points: int
    grounded: bool


DETAILS = {
    "fine": Detail(most_rays=50_000, most_shapes=850, least_length=0.0, worth=5, least_points=3, grounded=False),
    "objects": Detail(most_rays=15_000, most_shapes=150, least_length=4.0, worth=200, least_points=30, grounded=True),
}
