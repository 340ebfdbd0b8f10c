"""Our caster with every shape given as its triangles: `bench_peer(n_threads)` for a benchmark's hook."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))  # a hook is loaded by its path
from peer_lidardraft import Peer

__version__ = Peer.version


def bench_peer(n_threads: int) -> Peer:
    """A peer that scans into arrays that stay."""
    return Peer(n_threads, triangles=True)
