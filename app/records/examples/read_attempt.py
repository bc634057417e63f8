#!/usr/bin/env python3
"""Reads a store of Stylet with nothing but Python's standard library.

    read_attempt.py STORE        a line for each attempt, with its peak force
    read_attempt.py STORE ID     one attempt: score, metrics, events, peak force

packaging/guide/records.md says what tables and files hold, app/records/README.md what each byte is.
"""

import pathlib
import sqlite3
import struct
import sys
import zlib

SAMPLE = struct.Struct("<4B2I31f")  # tool, phase, tissue, label; flags, faults; 31 numbers
DEPTH, FORCE = 20, 21  # indices: tool's pose 7, tip 3, axis 3, probe's pose 7, depth, axial force, ...
TISSUES = ["air", "skin", "soft tissue", "bone", "fascia", "liver", "vessel", "duct", "cartilage"]


class Damaged(Exception):
    pass


def samples(file):
    """Yields (tick, seconds, fields) of samples.bin, as far as its frames are whole."""
    data = file.read_bytes()
    head = struct.Struct("<8sII")
    if len(data) < head.size or len(data) < head.size + head.unpack_from(data)[2] + 4:
        print(f"{file}: ends inside its header", file=sys.stderr)  # killed while starting
        return
    magic, version, size = head.unpack_from(data)
    if magic != b"STYLSMP\n" or version != 1:
        raise Damaged(f"{file}: not a file of samples that this program knows")
    if struct.unpack_from("<I", data, 16 + size)[0] != zlib.crc32(data[:16 + size]):
        raise Damaged(f"{file}: the header's checksum does not match")
    _digest, dt_s, sample_bytes = struct.unpack_from("<QdI", data, 16)
    if sample_bytes != SAMPLE.size:
        raise Damaged(f"{file}: samples of {sample_bytes} bytes")
    at = 16 + size + 4
    while at + 28 <= len(data):
        mark, count, body, first, _last = struct.unpack_from("<4sIIQQ", data, at)
        end = at + 28 + body
        if mark != b"FRAM" or end + 4 > len(data) or body != count * SAMPLE.size:
            break
        if struct.unpack_from("<I", data, end)[0] != zlib.crc32(data[at:end]):
            break
        for i in range(count):
            yield first + i, (first + i) * dt_s, SAMPLE.unpack_from(data, at + 28 + i * SAMPLE.size)
        at = end + 4
    if at != len(data):
        print(f"{file}: {len(data) - at} bytes behind the last whole frame", file=sys.stderr)


def peak_force(folder):
    """(newtons, millimetres deep, seconds, tissue) of the largest axial force; None without samples."""
    file = folder / "record" / "samples.bin"
    if not file.exists():
        return None
    peak = None
    for _tick, seconds, fields in samples(file):
        force = abs(fields[6 + FORCE])
        if peak is None or force > peak[0]:
            peak = force, fields[6 + DEPTH] * 1000.0, seconds, TISSUES[fields[2]]
    return peak


def told(peak):
    if peak is None:
        return "no samples"
    return "peak force %.3f N, %.1f mm deep at %.3f s (%s)" % peak


def main(arguments):
    if len(arguments) not in (2, 3):
        print(__doc__, file=sys.stderr)
        return 2
    store = pathlib.Path(arguments[1])
    index = sqlite3.connect(f"file:{store / 'store.sqlite'}?mode=ro", uri=True)
    index.row_factory = sqlite3.Row
    wanted = arguments[2] if len(arguments) == 3 else "%"
    attempts = index.execute("SELECT * FROM attempt WHERE id LIKE ? ORDER BY number", (wanted,)).fetchall()
    for attempt in attempts:
        score = "-" if attempt["total"] is None else f"{attempt['total']:.1f}"
        print(f"{attempt['id']}  {attempt['trainee']}  {attempt['scenario']}  {attempt['state']}  score {score}  "
              + told(peak_force(store / "attempts" / attempt["id"])))
        if wanted == "%":
            continue
        for metric in index.execute("SELECT * FROM metric WHERE attempt = ? ORDER BY place", (attempt["number"],)):
            print(f"    {metric['name']}: {metric['value']} {metric['unit']}, "
                  f"{metric['points']} of {metric['most_points']} points")
        for event in index.execute("SELECT * FROM event WHERE attempt = ? ORDER BY place", (attempt["number"],)):
            print(f"    {event['tick'] * attempt['dt_s']:9.3f} s  {event['kind']}: {event['text']}")
    if not attempts:
        print("no such attempt" if wanted != "%" else "no attempts")
    return 0 if attempts else 1


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv))
    except (Damaged, sqlite3.Error, OSError, struct.error) as error:
        print(f"read_attempt.py: {error}", file=sys.stderr)
        sys.exit(2)
