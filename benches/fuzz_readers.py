"""A fuzzer for every reader: good files changed at random. Each is read, or ends in one line that names it.

`python benches/fuzz_readers.py SECONDS [READER...]` gives each reader that time, which is the seed too. It prints a row
for each, and keeps what it found in out/fuzz/.
"""

from __future__ import annotations

import os
import random
import re
import resource
import signal
import sys
import tempfile
import time
import warnings
from collections import Counter
from pathlib import Path

from good_files import Reader, readers
from lidardraft.errors import LidarDraftError

SECONDS, BYTES = 20, 2**31  # that a file may take, beyond the memory that there was before
KEPT = Path("out/fuzz")
NUMBERS = [b"0", b"-1", b"1e999", b"nan", b"9" * 30, b"1e-300", b"4294967296", b"[]", b"{}", b"null", b'""', b"true"]
BYTES_OF_NUMBERS = [(sign * 2**k + off) % 2**64 for sign in (1, -1) for k in (0, 7, 15, 31, 40, 63) for off in (-1, 0)]


def changed(good: bytes, rng: random.Random) -> bytes:
    """The file with one to four changes: a bit, a few bytes, a number, a piece cut, doubled or moved, or its end."""
    data = bytearray(good)
    for _ in range(rng.choice((1, 1, 2, 4))):
        at, many = rng.randrange(len(data) + 1), rng.choice((1, 4, 8, 60))
        numbers = [each.span() for each in re.finditer(rb"-?\d[\d.e+-]*", data[at : at + 200])]
        match rng.randrange(8):
            case 0 if at < len(data):
                data[at] ^= 1 << rng.randrange(8)
            case 1:
                data[at : at + many] = rng.randbytes(many)
            case 2:  # a length, as binary formats hold it
                size = rng.choice((1, 2, 4, 8))
                put = rng.choice(BYTES_OF_NUMBERS).to_bytes(8, "little")[:size]
                data[at : at + size] = put if rng.random() < 0.7 else put[::-1]
            case 3 if numbers:
                first, last = rng.choice(numbers)
                data[at + first : at + last] = rng.choice(NUMBERS)
            case 4:
                del data[at : at + many]
            case 5:
                data[at:at] = data[at : at + many] * rng.choice((1, 2, 50))
            case 6:
                other = rng.randrange(len(data) + 1)
                data[at : at + many] = data[other : other + many]
            case 7 if rng.random() < 0.2:
                del data[at:]
    return bytes(data)


def fault(reader: Reader, path: Path) -> str | None:
    """The fault in how the reader ends; "" if it refuses the file as it should, None if it reads it."""
    signal.alarm(SECONDS)
    try:
        reader.read(path)
    except LidarDraftError as error:
        said = str(error)
        clear = path.name in said and said.isprintable() and "MemoryError" not in said
        return "" if clear else f"not clear: {said}"
    except BaseException as error:
        return f"{type(error).__name__}: {error}"
    finally:
        signal.alarm(0)
    return None


def fuzz(name: str, reader: Reader, seconds: float, folder: Path) -> None:
    """Changes of one good file for so long; prints how many were read and refused, the slowest, and faults by kind."""
    rng, path, counts, faults, slowest = (
        random.Random(name),
        folder / f"fuzzed{reader.ending}",
        Counter(),
        Counter(),
        0.0,
    )
    used = int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    resource.setrlimit(resource.RLIMIT_AS, (used + BYTES,) * 2)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        begun, data = time.process_time(), changed(reader.good, rng)
        path.write_bytes(data)
        said = fault(reader, path)
        slowest = max(slowest, time.process_time() - begun)
        counts["read" if said is None else "refused"] += 1
        if said:
            kind = re.sub(r"\d+", "0", said)[:80]
            faults[kind] += 1
            if faults[kind] == 1:
                KEPT.mkdir(parents=True, exist_ok=True)
                kept = KEPT / f"{name.replace('/', '_')}-{len(faults)}{reader.ending}"
                kept.write_bytes(data)
                print(f"  {kept}: {said[:300]!r}", flush=True)
    total = counts["read"] + counts["refused"]
    print(f"| {name} | {total:,} | {counts['read']:,} | {slowest:.2f} | {sum(faults.values())} |", flush=True)


def main() -> None:
    """A process for each reader, so that one that is killed is a row too."""
    known, only = readers(), sys.argv[2:]
    print("| reader | files | of which read | slowest [s] | faults |\n|---|---:|---:|---:|---:|", flush=True)
    for name, reader in known.items():
        if only and name not in only:
            continue
        if (child := os.fork()) == 0:
            warnings.simplefilter("ignore")
            os.dup2(os.open(os.devnull, os.O_WRONLY), 2)

            def late(*_: object) -> None:
                raise TimeoutError

            signal.signal(signal.SIGALRM, late)
            with tempfile.TemporaryDirectory(dir="/dev/shm") as folder:
                tempfile.tempdir = folder
                fuzz(name, reader, float(sys.argv[1]), Path(folder))
            os._exit(0)
        _, status = os.waitpid(child, 0)
        if status:
            print(f"| {name} | killed by signal {status & 127} | | | 1 |", flush=True)


if __name__ == "__main__":
    main()
