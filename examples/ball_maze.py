#!/usr/bin/env python3
"""Draws a maze round a ball, from pole to pole, as an area map: red is wall. The map fits the layout of the scene that was exported.

    myxo export docs/experiments/ball_maze.toml --set areas.map= --steps 0 --out ball.npz
    python3 examples/ball_maze.py ball.npz docs/experiments/ball_maze.png

A map can be drawn on any surface this way: `texel_position` says where each texel of the texture lies, and a function of places decides
what is there. Needs numpy:

    sudo apt-get install python3-numpy     (or: pip install numpy)
"""

import random
import struct
import sys
import zlib

try:
    import numpy as np
except ImportError:
    sys.exit("ball_maze: numpy is missing; install it: sudo apt-get install python3-numpy, or pip install numpy")

RINGS = 7           # of rooms, from pole to pole; the first and the last are one room each
WALL = 0.35         # as a share of a ring's width
SEED = 4


def rooms():
    """How many rooms each ring has: about as long as the ring is wide."""
    width = np.pi / RINGS
    counts = [max(3, round(2.0 * np.pi * np.sin((ring + 0.5) * width) / width)) for ring in range(RINGS)]
    counts[0] = counts[-1] = 1
    return counts


def neighbours(counts):
    """All pairs of rooms that a door could join, with the longitude of its middle, which is that of the wall where both are in one ring."""
    pairs = []
    for ring, count in enumerate(counts):
        if count > 1:
            for room in range(count):
                turn = 2.0 * np.pi * (room + 1) / count
                pairs.append(((ring, room), (ring, (room + 1) % count), turn))
        if ring + 1 == len(counts):
            break
        # The middle of the longer of the two rooms' common walls; a pole is one room, with a wall all round.
        below = counts[ring + 1]
        many, few = max(count, below), min(count, below)
        for room in range(many):
            turn = 2.0 * np.pi * (room + 0.5) / many
            other = int(turn / (2.0 * np.pi) * few) % few
            # A room that lies beside two leaves enough of its wall to one of them.
            start, end = 2.0 * np.pi * room / many, 2.0 * np.pi * (room + 1) / many
            start, end = max(start, 2.0 * np.pi * other / few), min(end, 2.0 * np.pi * (other + 1) / few)
            upper, lower = (room, other) if count >= below else (other, room)
            pairs.append(((ring, upper), (ring + 1, lower), (start + end) / 2.0))
    return pairs


def doors(counts):
    """A random tree of doors: from every room to every other one there is one way."""
    pairs = neighbours(counts)
    beside = {}
    for first, second, turn in pairs:
        beside.setdefault(first, []).append((second, turn))
        beside.setdefault(second, []).append((first, turn))
    draw = random.Random(SEED)
    start = (len(counts) // 2, 0)
    found, way, open_doors = {start}, [start], []
    while way:
        room = way[-1]
        left = [(other, turn) for other, turn in beside[room] if other not in found]
        if not left:
            way.pop()
            continue
        other, turn = draw.choice(left)
        found.add(other)
        open_doors.append((room, other, turn))
        way.append(other)
    assert len(found) == sum(counts)
    return open_doors


def walls(position):
    """Which of these places, on a ball of radius 1, are wall."""
    width = np.pi / RINGS
    half = 0.5 * WALL * width
    wide = 0.5 * (1.0 - WALL) * width
    counts = rooms()
    polar = np.arccos(np.clip(position[..., 1], -1.0, 1.0))
    turn = np.arctan2(position[..., 2], position[..., 0]) % (2.0 * np.pi)
    around = np.sin(polar)
    ring = np.clip((polar / width).astype(int), 0, RINGS - 1)
    is_wall = np.zeros(polar.shape, bool)
    for k in range(1, RINGS):
        is_wall |= np.abs(polar - k * width) < half
    for k, count in enumerate(counts):
        if count > 1:
            side = 2.0 * np.pi / count
            off = np.abs((turn + 0.5 * side) % side - 0.5 * side)
            is_wall |= (ring == k) & (off * around < half)
    for (a, _), (b, _), at in doors(counts):
        off = np.abs((turn - at + np.pi) % (2.0 * np.pi) - np.pi) * around
        if a == b:
            in_door = (off < half) & (np.abs(polar - (a + 0.5) * width) < wide)
        else:
            in_door = (off < wide) & (np.abs(polar - max(a, b) * width) < half)
        is_wall &= ~in_door
    return is_wall


def write_png(path, pixels):
    """A PNG with 8 bits a colour, without a library."""
    rows, columns, _ = pixels.shape
    lines = b"".join(b"\0" + line.tobytes() for line in pixels)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", columns, rows, 8, 2, 0, 0, 0)
    with open(path, "wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(lines, 9)) + chunk(b"IEND", b""))


def main():
    if len(sys.argv) != 3:
        sys.exit(f"usage: {sys.argv[0]} BALL.npz MAP.png")
    data = np.load(sys.argv[1])
    position = data["texel_position"]
    is_owned = data["texel_triangle"] >= 0
    ball = np.where(is_owned[..., None], position, [0.0, 1.0, 0.0])
    ball /= np.linalg.norm(ball, axis=-1, keepdims=True)
    pixels = np.zeros(is_owned.shape + (3,), np.uint8)
    pixels[is_owned & walls(ball), 0] = 255
    write_png(sys.argv[2], pixels)


main()
