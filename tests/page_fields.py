"""What the page of a scan holds, unpacked."""

import base64
import json
import re
import zlib

import numpy as np


def page_data(page: str) -> dict:
    return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)[1])


def fields_of_page(page: str) -> dict[str, np.ndarray]:
    """What a page holds of each point, in metres and seconds."""
    data, start, found = page_data(page), 0, {}
    packed = np.frombuffer(zlib.decompress(base64.b64decode(data["packed"])), np.uint8)
    for name, width, unit in data["fields"]:
        planes = packed[start : start + width * data["count"]].reshape(width, -1)
        steps = np.ascontiguousarray(planes.T).view(f"<i{width}")[:, 0]
        found[name], start = np.cumsum(steps, dtype=steps.dtype) * unit, start + planes.size
    assert start == len(packed)
    return found
