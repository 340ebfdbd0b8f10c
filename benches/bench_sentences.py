"""Processor time of reading sentences: the first of a process, over the import, and those after it.

    python benches/bench_sentences.py [FILE]

FILE has a sentence on each line; without one, they are the 120 of the tests whose writers had not seen the reader. A
sentence that is refused counts too. The first one is the median of five processes.
"""

from __future__ import annotations

import contextlib
import subprocess
import sys
import time
from pathlib import Path
from statistics import median

import numpy as np

from lidardraft.drafting.text.layout import spec_from_text
from lidardraft.errors import LayoutError, TextError

SENTENCES = Path(__file__).parents[1] / "tests" / "drafting" / "text" / "unseen.txt"
FIRST = """
import time
from lidardraft.drafting.text.layout import spec_from_text
start = time.process_time()
spec_from_text("a crossroads with a bus, cars, cyclists and people, houses and trees on both sides")
print(time.process_time() - start)
"""


def seconds(sentence: str) -> float:
    """Of processor time that a sentence takes."""
    start = time.process_time()
    with contextlib.suppress(TextError, LayoutError):
        spec_from_text(sentence)
    return time.process_time() - start


def main() -> None:
    """Print both."""
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else SENTENCES
    sentences = [line for line in path.read_text(encoding="utf-8").splitlines() if line.strip()]
    command = [sys.executable, "-c", FIRST]
    first = [float(subprocess.run(command, capture_output=True, check=True, text=True).stdout) for _ in range(5)]
    print(f"first sentence of a process, over the import: {1e3 * median(first):.0f} ms of CPU (median of 5)")
    seconds(sentences[0])
    spent = 1e3 * np.array([seconds(sentence) for sentence in sentences])
    middle, most = np.percentile(spent, (50, 95))
    words = np.mean([len(sentence.split()) for sentence in sentences])
    print(f"{len(sentences)} sentences of {words:.0f} words on average: median {middle:.1f} ms, 95 % {most:.1f} ms")


if __name__ == "__main__":
    main()
