"""Frames from captures (.pcap) of an Ouster's packets, in the layouts of its sensor documentation.

Captures are of Ethernet, Linux's "any" or raw IP, with IPv4 datagrams whole or in fragments.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from lidardraft.errors import FormatError, one_of

_HEAD, _RECORD = 24, 16  # bytes of a capture's header, and of a packet's
_LONGEST = 2**18  # bytes of a packet
_MOST_OPEN = 64  # incomplete datagrams kept at once
_LINKS = {1: 14, 101: 0, 113: 16, 228: 0, 276: 20}  # bytes before IP: Ethernet, raw, Linux's two kinds of "any"
_VALID = 1  # the bit of a column's status that marks it as measured
_SINGLE = ("<u4", 0x7FFFF, 1, 4, "u1")
# By profile: type, bits and millimetres of a range, place and type of the reflectivity; bytes of a pixel.
_PROFILES = {
    "LEGACY": (("<u4", 0xFFFFF, 1, 4, "<u2"), 12),
    "RNG19_RFL8_SIG16_NIR16": (_SINGLE, 12),
    "RNG19_RFL8_SIG16_NIR16_DUAL": (("<u4", 0x7FFFF, 1, 3, "u1"), 16),
    "RNG15_RFL8_NIR8": (("<u2", 0x7FFF, 8, 2, "u1"), 4),
}


@dataclass(frozen=True, slots=True)
class Packets:
    """The form of a sensor's packets: its beams, the columns of a turn and of a packet, and the profile.

    Raises `FormatError` for an unsupported profile."""

    beams: int
    turn: int
    columns: int
    profile: str

    def __post_init__(self) -> None:
        if self.profile not in _PROFILES:
            said = one_of(_PROFILES, self.profile)
            raise FormatError(f"udp_profile_lidar is {self.profile!r:.50}; without Ouster's SDK it must be {said}")

    @property
    def is_old(self) -> bool:
        """Whether they are of firmware before 2.2, without headers."""
        return self.profile == "LEGACY"

    def column(self) -> np.dtype:
        """A column: its number, frame (of old packets), status, and the words of its pixels."""
        (word, _, _, at, reflectivity), size = _PROFILES[self.profile]
        pixel = {"names": ["range", "reflectivity"], "formats": [word, reflectivity], "offsets": [0, at]}
        pixels = (np.dtype({**pixel, "itemsize": size}), (self.beams,))  # type: ignore[call-overload]
        start, end = (16, 4) if self.is_old else (12, 0)
        whole = start + size * self.beams + end
        names, formats = ["number", "frame", "status", "pixels"], ["<u2", "<u2", "<u2", pixels]
        offsets = [8, 10, whole - 4 if self.is_old else 10, start]
        return np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": whole})

    def frames(self, path: str | os.PathLike[str]) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """For each turn the ranges [beams, turn] in millimetres, 0 for no return, the reflectivities, and whether each
        of the columns [turn] was measured."""
        kind, head = self.column(), 0 if self.is_old else 32
        _, mask, unit, *_ = _PROFILES[self.profile][0]
        size = 2 * head + self.columns * kind.itemsize
        now, frame = None, self._empty()
        with Path(path).open("rb") as file:
            for payload in _payloads(file):
                if len(payload) != size:
                    continue  # from the inertial unit, or of another kind
                columns = np.frombuffer(payload, kind, self.columns, head)
                number = int(columns["frame"][0]) if self.is_old else int.from_bytes(payload[2:4], "little")
                if now is not None and number != now:
                    yield frame
                    frame = self._empty()
                now = number
                columns = columns[(columns["status"] & _VALID > 0) & (columns["number"] < self.turn)]
                ranges, reflectivity, measured = frame
                at = columns["number"].astype(np.int64)
                ranges[:, at] = (columns["pixels"]["range"] & mask).astype(np.int64).T * unit
                reflectivity[:, at] = columns["pixels"]["reflectivity"].T
                measured[at] = True
        if now is not None:
            yield frame

    def _empty(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        shape = self.beams, self.turn
        return np.zeros(shape, np.int64), np.zeros(shape, np.int64), np.zeros(self.turn, bool)


def _payloads(file: BinaryIO) -> Iterator[bytes]:
    """The UDP payloads of a capture; a truncated one ends before the missing part."""
    head = file.read(_HEAD)
    order = {b"\xd4\xc3\xb2\xa1": "<", b"\x4d\x3c\xb2\xa1": "<", b"\xa1\xb2\xc3\xd4": ">", b"\xa1\xb2\x3c\x4d": ">"}
    if head[:4] == b"\x0a\x0d\x0d\x0a":
        raise FormatError("it is a pcapng; make a pcap of it, as by editcap -F pcap")
    if len(head) < _HEAD or head[:4] not in order:
        raise FormatError("not a capture of packets, a pcap")
    (link,) = struct.unpack(order[head[:4]] + "I", head[20:24])
    before = _LINKS.get(link & 0xFFFF)
    if before is None:
        raise FormatError(f"its packets are of link type {link & 0xFFFF}; it must be one of {sorted(_LINKS)}")
    waiting = dict[tuple[bytes, bytes], dict[int, tuple[bytes, bool]]]()
    while len(record := file.read(_RECORD)) == _RECORD:
        (length,) = struct.unpack(order[head[:4]] + "8xI4x", record)
        if length > _LONGEST:
            raise FormatError(f"a packet has {length} bytes, more than {_LONGEST}: the capture is broken")
        packet = file.read(length)
        tag = 4 * (packet[max(0, before - 2) : before] == b"\x81\x00")  # of a VLAN
        whole = _datagram(packet[before + tag :], waiting)
        if whole is not None:
            yield whole[8:]


def _datagram(packet: bytes, waiting: dict[tuple[bytes, bytes], dict[int, tuple[bytes, bool]]]) -> bytes | None:
    """The UDP datagram of an IPv4 packet, if the packet holds it whole or completes its fragments; else None."""
    if len(packet) < 28 or packet[0] >> 4 != 4 or packet[9] != 17:
        return None
    length, cut = struct.unpack_from(">H2xH", packet, 2)
    data, more, start = packet[4 * (packet[0] & 15) : length or None], bool(cut & 0x2000), 8 * (cut & 0x1FFF)
    if not more and not start:
        return data
    key = packet[12:20], packet[4:6]
    parts = waiting.setdefault(key, {})
    parts[start] = data, more
    if len(waiting) > _MOST_OPEN:
        del waiting[next(iter(waiting))]
    end = 0
    while end in parts:
        data, more = parts[end]
        if not more:
            waiting.pop(key, None)
            return b"".join(parts[at][0] for at in sorted(parts))
        if not data:
            break
        end += len(data)
    return None
