"""Shards made by the machines of a Ray cluster, which all see the folder under the same path."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

from lidardraft.errors import FormatError

Item = TypeVar("Item")
T = TypeVar("T")


def on_cluster(make: Callable[[Item], T], items: Iterable[Item], address: str) -> Iterator[T]:
    """`make(item)` of each item as it is done, on the cores of a cluster ("auto": of this machine's).

    What was at work on a machine that is lost is made again on another. Raises as `make` does, and `FormatError` where
    there is no such cluster.
    """
    import ray

    try:
        ray.init(address=address, log_to_driver=False, logging_level="error")
    except (ConnectionError, ValueError, RuntimeError) as error:
        said = str(error).splitlines()[0].partition(". ")[0]
        raise FormatError(f"no Ray cluster at {address!r}: {said}; `ray start --head` begins one") from None
    try:
        task, given, left = ray.remote(num_cpus=1, max_retries=-1)(_made), ray.put(make), iter(items)
        cores = int(ray.cluster_resources().get("CPU", 1))
        at_work = [task.remote(given, item) for item in itertools.islice(left, 2 * cores)]
        while at_work:
            done, at_work = ray.wait(at_work)
            yield from ray.get(done)
            at_work += [task.remote(given, item) for item in itertools.islice(left, len(done))]
    except ray.exceptions.RayTaskError as error:
        raise error.cause from None
    finally:
        ray.shutdown()


def _made(make: Callable[[Item], T], item: Item) -> T:
    return make(item)
