"""Reads the OpenEXR files that `vr render` writes: one layer of scan lines of 32-bit floats, not compressed, RLE or ZIP. Needs numpy.

What the format is: https://openexr.com/en/latest/OpenEXRFileLayout.html
"""
import struct
import zlib

import numpy as np

MAGIC = b"\x76\x2f\x31\x01"
FLOAT = 2
LINES = {0: 1, 1: 1, 2: 1, 3: 16}  # scan lines in a block: none, RLE, ZIP by line, ZIP by 16 lines
RLE = 1


def rgba(path):
    """Premultiplied linear light, float32 of shape (height, width, 4), row 0 at the top."""
    channels = read(path)
    return np.stack([channels[c] for c in "RGBA"], -1)


def read(path):
    """Every channel by its name: float32 of shape (height, width), row 0 at the top."""
    with open(path, "rb") as f:
        data = f.read()
    if data[:4] != MAGIC:
        raise ValueError(f"{path}: no OpenEXR file")
    attributes, at = {}, 8
    while data[at]:
        name_end = data.index(b"\0", at)
        type_end = data.index(b"\0", name_end + 1)
        (size,) = struct.unpack_from("<i", data, type_end + 1)
        attributes[data[at:name_end].decode()] = data[type_end + 5:type_end + 5 + size]
        at = type_end + 5 + size
    offsets = at + 1
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    names, entry, at = [], attributes["channels"], 0
    while entry[at]:
        end = entry.index(b"\0", at)
        (kind,) = struct.unpack_from("<i", entry, end + 1)
        if kind != FLOAT:
            raise ValueError(f"{path}: only 32-bit floats are read")
        names.append(entry[at:end].decode())
        at = end + 17
    compression = attributes["compression"][0]
    if compression not in LINES:
        raise ValueError(f"{path}: compression {compression} is not read")
    lines = LINES[compression]
    image = {name: np.zeros((height, width), np.float32) for name in names}
    for block in range(-(-height // lines)):
        (offset,) = struct.unpack_from("<Q", data, offsets + 8 * block)
        y, size = struct.unpack_from("<2i", data, offset)
        y -= y0
        count = min(lines, height - y)
        whole = count * width * 4 * len(names)
        raw = data[offset + 8:offset + 8 + size]
        if size < whole:  # else it was stored as it is, since packing did not make it smaller
            raw = _unpredict(_unpack_runs(raw, whole) if compression == RLE else zlib.decompress(raw))
        rows = np.frombuffer(raw, "<f4").reshape(count, len(names), width)
        for k, name in enumerate(names):
            image[name][y:y + count] = rows[:, k]
    return image


def _unpack_runs(packed, size):
    out, at = bytearray(), 0
    while len(out) < size:
        (count,) = struct.unpack_from("b", packed, at)
        if count < 0:
            out += packed[at + 1:at + 1 - count]
            at += 1 - count
        else:
            out += packed[at + 1:at + 2] * (count + 1)
            at += 2
    return bytes(out)


def _unpredict(stored):
    """Sums the differences, and lays the two halves out in turns."""
    deltas = np.frombuffer(stored, np.uint8).astype(np.int64)
    deltas[1:] -= 128
    sums = (np.cumsum(deltas) & 255).astype(np.uint8)
    half = (len(sums) + 1) // 2
    out = np.empty_like(sums)
    out[0::2], out[1::2] = sums[:half], sums[half:]
    return out.tobytes()
