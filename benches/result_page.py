"""The pages in benches/results, written by the benches that measured them."""

from __future__ import annotations

import datetime
import os
import platform
import shlex
import sys
from pathlib import Path

RESULTS = Path(__file__).parent / "results"
KEPT = "<!-- A bench that writes this page keeps all below. -->"


def processor() -> str:
    """The name of the processor, and its widest vectors."""
    name, flags = platform.processor() or platform.machine(), set[str]()
    if os.path.exists("/proc/cpuinfo"):
        lines = [line.split(":", 1) for line in Path("/proc/cpuinfo").read_text().splitlines() if ":" in line]
        facts = {key.strip(): value.strip() for key, value in lines}
        name, flags = facts.get("model name", name), set(facts.get("flags", "").split())
    simd = ", ".join(title for flag, title in (("avx2", "AVX2"), ("avx512f", "AVX-512")) if flag in flags)
    return f"{name} ({simd or 'no AVX2'})"


def write_page(name: str, said: str, found: str, folder: Path = RESULTS) -> None:
    """Write the page `name`: the date, the processor, the command and what is `said` of it, then `found`.

    The text below the line `KEPT` stays, such as figures of an earlier version.
    """
    path = folder / f"{name}.md"
    kept = path.read_text(encoding="utf-8").partition(KEPT)[2].strip() if path.exists() else ""
    words = [word for word in sys.argv[1:] if word != "--page"]
    command = shlex.join(["python", f"benches/{Path(sys.argv[0]).name}", *words])
    today = datetime.datetime.now(tz=datetime.timezone.utc).date()
    head = f"Measured {today} on {os.cpu_count()} cores of an {processor()} by `{command}`: {said}"
    parts = [head, found.strip(), *([KEPT, kept] if kept else [])]
    path.write_text("\n\n".join(parts) + "\n", encoding="utf-8")
