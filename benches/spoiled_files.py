"""Files that are spoiled in many ways: what each reader says of them, in what time and memory."""

from __future__ import annotations

import gzip
import io
import itertools
import os
import resource
import struct
import sys
import tempfile
import time
import zipfile
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from good_files import LAYOUT, PCD, SENSOR, SVG, Reader, archive, npy, picture_bytes, readers, write_las, written
from lidardraft.errors import LidarDraftError
from lidardraft.formats.glb import glb_bytes
from small_recordings import pandas_pickle

SECONDS, BYTES = 2.0, 2**30  # that a reader may take of a processor and of memory
_MIB = 2**20


def spoilings(reader: Reader) -> Iterator[tuple[str, bytes]]:
    """Ways to spoil any file, by name, of less than two megabytes."""
    good, noise = reader.good, np.random.default_rng(0).bytes(4096)
    yield "empty", b""
    for share in (0.1, 0.5, 0.9):
        yield f"cut at {share:.0%}", good[: int(share * len(good))]
    yield "without its last byte", good[:-1]
    yield "random bytes", noise
    yield "another beginning", b"\x00\x01\x02\x03" + good[4:]
    yield "random bytes in its middle", good[: len(good) // 2] + noise[:64] + good[len(good) // 2 :]
    yield "ones in its middle", good[: len(good) // 2] + b"\xff" * 32 + good[len(good) // 2 + 32 :]
    yield "nan for numbers", good.replace(b"1", b"nan").replace(b"4", b"NaN")
    yield "infinite numbers", good.replace(b"1", b"1e999").replace(b"4", b"inf")
    yield "numbers of 5,000 digits", good.replace(b"4", b"4" * 5000)
    yield "not UTF-8", b"\xff\xfe\xfa" + good
    yield "UTF-16", good.decode("latin-1").encode("utf-16")
    yield "a byte order mark", b"\xef\xbb\xbf" + good
    yield "lines of Windows", good.replace(b"\n", b"\r\n")
    yield "zeros", bytes(4096)
    yield "twice", good + good
    yield "brackets", b"[" * _MIB
    yield "braces", b'{"a":' * 200_000


def large_spoilings() -> Iterator[tuple[str, bytes]]:
    """Files for any reader that take a while to make, by name."""
    yield "spaces", b" " * (100 * _MIB)
    yield "one long line", b"a" * (100 * _MIB)
    yield "many lines", b"v 1 2 3\n" * (12 * _MIB)
    yield "large and zero", bytes(120 * _MIB)


def _png(width: int, height: int, data: bytes = b"", kind: int = 2) -> bytes:
    def chunk(name: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))

    head = struct.pack(">IIBBBBB", width, height, 8, kind, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def _claim(shape: tuple[int, ...], zeros: int = 0) -> bytes:
    """An .npy file whose header claims much, and so many megabytes of zeros."""
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "<f4", "fortran_order": False, "shape": shape})
    return header.getvalue() + bytes(zeros * _MIB)


def special_files(large: bool = True) -> Iterator[tuple[str, str, bytes]]:
    """Reader, name and bytes of files that are made against one format; `large` for those that take a while to make,
    too."""
    entities = "".join(f'<!ENTITY e{k} "{f"&e{k - 1};" * 10}">' for k in range(1, 7))
    bomb = f'<!DOCTYPE svg [<!ENTITY e0 "eeeeeeeeee">{entities}]><svg><text>&e6;</text></svg>'
    svg = {
        "a million entities": bomb.encode(),
        "an outside entity": b'<!DOCTYPE svg [<!ENTITY x SYSTEM "file:///etc/passwd">]><svg>&x;</svg>',
        "deep groups": b"<svg>" + b"<g>" * 200_000,
        "a million shapes": b"<svg>" + b"<rect/>" * 1_000_000 + b"</svg>",
        "a million commands": b'<svg><path d="M0 0' + b"c1 1 2 2 3 3" * 1_000_000 + b'"/></svg>',
        "a million points": b'<svg><polygon points="' + b"1,2 " * 1_000_000 + b'"/></svg>',
        "large shapes": b'<svg width="90" height="60">%s</svg>' % (b'<rect id="road" width="9000" height="2"/>' * 4000),
        "strokes without end": b'<svg><path id="wall" d="M0 0%s" stroke="red"/></svg>' % (b"l9 9l-9 0" * 14_000),
        "attributes": b"<svg><rect " + b" ".join(b'a%d=""' % k for k in range(200_000)) + b"/></svg>",
        "an endless number": b'<svg width="' + b"9" * 1_000_000 + b'"/>',
        "transforms": b'<svg><rect id="car" transform="' + b"scale(2)" * 200_000 + b'" width="1" height="1"/></svg>',
    }
    yield from (("sketch of shapes", name, data) for name, data in svg.items())
    rows = zlib.compress(bytes(10_001) * 1000)
    stripes = np.full((1000, 1000, 3), 255, np.uint8)
    stripes[::6] = stripes[1::6] = stripes[2::6] = (102, 102, 156)
    checks = np.full((1400, 1400, 3), 255, np.uint8)
    checks[np.add.outer(np.arange(1400) // 4, np.arange(1400) // 4) % 2 > 0] = (0, 0, 142)
    pictures = {
        "two billion pixels to a side": _png(2**31 - 1, 2**31 - 1, rows),
        "pixels that are not there": _png(5000, 5000, rows[:200]),
        "nothing": _png(0, 0),
        "a broken sum": _png(4, 4).replace(b"IDAT", b"zTXt", 1),
    }
    if large:
        pictures["100 megapixels"] = _png(10_000, 10_000, zlib.compress(bytes(10_001) * 10_000, 1), kind=0)
    for name, data in pictures.items():
        yield "painted sketch", name, data
        yield "picture", name, data
    cells = np.kron(np.random.default_rng(3).integers(0, 2, (160, 160)), np.ones((6, 6)))
    maze = np.where(cells[..., None] > 0, (107, 142, 35), 255).astype(np.uint8)
    down, right = np.mgrid[-500:500, -500:500]
    turns = np.sin(np.hypot(right, down) / 12 + np.arctan2(down, right) / 2)
    spiral = np.where(np.abs(turns)[..., None] < 0.4, (128, 64, 128), 255).astype(np.uint8)
    drawn = {"stripes": stripes, "checks": checks, "maze": maze, "spiral": spiral}
    if large:
        drawn["noise"] = np.random.default_rng(1).integers(0, 256, (1400, 1400, 3)).astype(np.uint8)
    for name, pixels in drawn.items():
        yield "painted sketch", name, picture_bytes("png", pixels, compress_level=1)
    images = {
        "more than there is": _claim((2**40,)),
        "a pickle": npy(np.array([print], dtype=object)),
        "text for numbers": npy(np.array(["car"])),
    }
    if large:
        images["a bomb"] = _claim((35 * _MIB,), 140)
    for name, data in images.items():
        yield "cast", name, archive("depth", data)
        yield "range image", name, archive("depth", data)
        if name != "a bomb":
            yield "npy", name, data
    for name, text in (
        ("a deep header", "(" * 9000),
        ("a hundred axes", f"{{'descr': '<f4', 'fortran_order': False, 'shape': {(1,) * 100}}}"),
        ("an axis that is no number", "{'descr': '<f4', 'fortran_order': False, 'shape': (True,)}"),
    ):
        data = b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text.encode()
        yield "npy", name, data
        yield "depth", name, data
        yield "points", name, archive("xyz", data)
    yield "points", "one label for all", archive("xyz", npy(np.ones((9, 3))), "label", npy(np.array(1)))
    yield "points", "a field of many axes", archive("xyz", npy(np.ones((9, 3, 2))))
    yield "points", "packed slowly", archive("xyz", npy(np.ones((9, 3))), kind=zipfile.ZIP_LZMA)
    yield "sensor", "a long name", SENSOR.to_json().replace("few", "few" * 400_000).encode()
    yield "pickled table", "a call", b"\x80\x03cos\n_exit\n(K\x01tR."
    yield "pickled table", "a table of another pandas", b"\x80\x03cpandas.core.frame\nDataFrame\n)\x81."
    yield "pickled table", "nested tuples", b"\x80\x03)" + b"q\x00h\x00\x86" * 60 + b"q\x00}h\x00Ns."
    yield "pickled table", "a million lists", b"\x80\x03(" + b"]" * 2**20 + b"l."
    yield "pickled table", "a memory of thousands of millions", b"\x80\x03Nr\xff\xff\xff\x7f."
    yield "pickled table", "a text that is not there", b"\x80\x03B\xff\xff\xff\xff."
    yield "pickled table", "pointers for objects", pandas_pickle(a=np.arange(3)).replace(b"i8", b"O8")
    yield "pandaset lidar/00.pkl.gz", "a bomb", gzip.compress(bytes(80 * _MIB), 1)
    yield "layout", "two million fields", b"{" + b'"a":1,' * 2_000_000 + b'"a":1}'
    polygon = SVG.replace(b"<line", b'<polygon id="car" points="1 2 3"/><line')
    yield "sketch of shapes", "a polygon of one point", polygon
    counts = {"a trillion points": b"1000000000000", "no number of points": b"-2", "much text": b"9000000"}
    for name, points in counts.items():
        body = b"1 2\n" * (9_000_000 if name == "much text" else 2)
        yield "pcd", name, PCD[: PCD.index(b"POINTS")] + b"POINTS " + points + b"\nDATA ascii\n" + body
    packed = PCD[: PCD.index(b"DATA")].replace(b"POINTS 2", b"POINTS 500000000") + b"DATA binary_compressed\n"
    yield "pcd", "a bomb", packed + struct.pack("<2I", 8, 2**32 - 1) + b"\xe0\xff\x00" * 8
    yield from _models()
    many = ",".join(
        f'{{"shape":"box","center":[{k},0,1],"size":[4,2,1],"label":"car","id":"c{k}"}}' for k in range(400_000)
    )
    yield "layout", "400,000 shapes", f'{{"schema":"lidardraft.layout/2","primitives":[{many}]}}'.encode()
    deep = '{"a":' * 900 + "1" + "}" * 900
    yield "layout", "a deep provenance", LAYOUT.to_json().replace('{"seed": 1}', deep).encode()
    yield "bin", "points that are no numbers", np.full((99, 4), np.nan, "<f4").tobytes()
    yield "bin", "points infinitely far", np.full((99, 4), np.inf, "<f4").tobytes()
    las = bytearray(written(write_las, ".las"))
    las[100:104] = b"\xff" * 4
    yield "las", "four thousand million records", bytes(las)
    yield "label", "more labels than points", bytes(4 * 10_000)


def _models() -> Iterator[tuple[str, str, bytes]]:
    yield "obj", "vertices that are no numbers", b"o car\nv nan 0 0\nv 1 0 0\nv 0 1 1e999\nf 1 2 3\n"
    yield "obj", "a face of no vertices", b"o car\nv 0 0 0\nf 1 2 999999999999\n"
    yield "obj", "a face of a million corners", b"o car\nv 0 0 0\nv 1 0 0\nv 0 1 1\nf" + b" 1 2 3" * 400_000 + b"\n"
    car_of = b"o car_%d\nv 0 0 0\nv 1 0 0\nv 0 1 1\nf -3 -2 -1\n"
    for count in (200_000, 65_000):
        yield "obj", f"{count:,} objects", b"".join(car_of % k for k in range(count))
    triangle = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 1)], "<f4").tobytes()

    def glb(nodes: list[dict[str, object]], count: int = 3, **more: object) -> bytes:
        document = {
            "asset": {"version": "2.0"},
            "buffers": [{"byteLength": 36}],
            "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 36}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3"}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            "scenes": [{"nodes": [0]}],
            "nodes": nodes,
        }
        return glb_bytes(document | more, triangle)

    car: dict[str, object] = {"name": "car", "mesh": 0}
    yield "glb", "a circle of nodes", glb([{**car, "children": [0]}])
    yield "glb", "nodes that double", glb([{"name": "car", "children": [k + 1, k + 1]} for k in range(60)] + [car])
    yield "glb", "more vertices than there are", glb([car], count=2**31)
    yield "glb", "vertices that are no numbers", glb([car]).replace(triangle, np.full((3, 3), np.nan, "<f4").tobytes())
    parts = [{"attributes": {"POSITION": 0}}] * 200_000
    yield "glb", "200,000 parts of one mesh", glb([car], meshes=[{"primitives": parts}])
    yield "glb", "a rotation of zeros", glb([{**car, "rotation": [0, 0, 0, 0]}])
    yield "glb", "another file", glb([car], buffers=[{"uri": "/dev/zero", "byteLength": 36}])
    yield "glb", "a length that is too long", glb([car])[:8] + struct.pack("<I", 2**32 - 1) + glb([car])[12:]
    many = [{"name": f"car_{k}", "mesh": 0, "translation": [k, 0, 0]} for k in range(19_000)]
    yield "glb", "19,000 nodes", glb(many, scenes=[{"nodes": list(range(19_000))}])
    yield "glb", "100,000 nodes", glb(many * 5, scenes=[{"nodes": list(range(95_000))}])


def odd_paths(folder: Path, ending: str) -> Iterator[tuple[str, Path]]:
    """What lies at a path and is no file that can be read."""
    names = ("pipe", "folder", "device", "empty device", "loop", "locked", "6 GB", "missing")
    pipe, inner, device, empty, loop, locked, large, missing = paths = [folder / f"{name}{ending}" for name in names]
    os.mkfifo(pipe)
    inner.mkdir()
    device.symlink_to("/dev/zero")
    empty.symlink_to("/dev/null")
    loop.symlink_to(loop)
    locked.write_bytes(b"\xff\0")  # which root reads, and no reader takes
    locked.chmod(0)
    large.touch()
    os.truncate(large, 6 * 2**30)
    assert not missing.exists()
    yield from zip(names, paths, strict=True)


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a reader said of a file (None where it read it; an error's name where it is none of ours), the processor
    time [s] it took, and the memory [bytes] beyond what there was before."""

    reader: str
    file: str
    said: str | None
    seconds: float
    memory: int
    clear: bool


def outcome(name: str, file: str, read: Callable[[Path], object], path: Path) -> Outcome:
    """What comes of reading a file, in a process of its own that may take 30 s and 4 GB more than this one."""
    into, out = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(into)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
        used = int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
        resource.setrlimit(resource.RLIMIT_AS, (used + 4 * 2**30,) * 2)
        resource.setrlimit(resource.RLIMIT_CPU, (30, 30))
        before, begun = _resident(), time.process_time()
        try:
            read(path)
            said, clear = "", True
        except LidarDraftError as error:
            said, clear = f"{type(error).__name__}: {error}", path.name in str(error) and "\n" not in str(error)
        except BaseException as error:
            said, clear = f"{type(error).__name__}: {error}", False
        took = time.process_time() - begun
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
        os.write(out, f"{took:.6f} {max(0, peak - before)} {int(clear)} {said[:900]}".encode("utf-8", "replace"))
        os._exit(0)
    os.close(out)
    with os.fdopen(into, "rb") as pipe:
        answer = pipe.read().decode("utf-8", "replace")
    os.waitpid(child, 0)
    if not answer:
        return Outcome(name, file, "killed: more than 30 s or 4 GB", 30.0, 4 * 2**30, False)
    seconds, memory, clear_, said_ = answer.split(" ", 3)
    return Outcome(name, file, said_ or None, float(seconds), int(memory), clear_ == "1")


def _resident() -> int:
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def outcomes(folder: Path, only: str = "") -> Iterator[Outcome]:
    """What comes of every file, or of those of one reader; each is taken away again."""
    known = readers()
    for name, reader in known.items():
        if only in ("", name):
            for file, data in itertools.chain(spoilings(reader), large_spoilings()):
                path = folder / f"spoiled{reader.ending}"
                path.write_bytes(data)
                yield outcome(name, file, reader.read, path)
                path.unlink()
            with tempfile.TemporaryDirectory(dir=folder) as inner:
                for file, path in odd_paths(Path(inner), reader.ending):
                    yield outcome(name, file, reader.read, path)
    for name, file, data in special_files():
        if only in ("", name):
            path = folder / f"special{known[name].ending}"
            path.write_bytes(data)
            yield outcome(name, file, known[name].read, path)
            path.unlink()


def main() -> None:
    """Print a line for each file, worst last."""
    with tempfile.TemporaryDirectory() as folder:
        found = sorted(outcomes(Path(folder), *sys.argv[1:2]), key=lambda each: (not each.clear, each.seconds))
    for each in found:
        print(f"{each.seconds:7.3f} s {each.memory / _MIB:7.0f} MB {each.reader}, {each.file}: {str(each.said)[:160]}")
    print(f"{len(found)} files; not clear: {sum(not each.clear for each in found)}")


if __name__ == "__main__":
    main()
