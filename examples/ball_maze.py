#!/usr/bin/env python3
"""Draws a maze round a ball, from pole to pole, as an area map: red is wall. The map fits the layout of the scene that was exported.

    myxo export docs/experiments/ball_maze.toml --set areas.map= --steps 0 --out ball.npz
    python3 examples/ball_maze.py ball.npz docs/experiments/ball_maze.png

The ball has its middle at the origin. A map can be drawn on any other surface by another function `walls`: `texel_position` says where
each texel of the texture lies. Needs numpy:

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

# Rings of rooms, from pole to pole; the first and the last are one room each.
RINGS = 7
# How thick a wall is, as a share of a ring's width.
WALL = 0.35
SEED = 4

WHOLE = 2.0 * np.pi
WIDTH = np.pi / RINGS


def rooms():
    """How many rooms each ring has: each is about as long as the ring is wide."""
    middles = (np.arange(RINGS) + 0.5) * WIDTH
    counts = [round(WHOLE * np.sin(middle) / WIDTH) for middle in middles]
    counts[0] = counts[-1] = 1
    return counts


def possible_doors(counts):
    """All pairs of rooms, each a ring and a number, that can have a door, with the door's longitude."""
    pairs = []
    for ring, count in enumerate(counts):
        if count > 1:
            for room in range(count):
                pairs.append(((ring, room), (ring, (room + 1) % count), WHOLE * (room + 1) / count))
        if ring + 1 == len(counts):
            break
        # Each room of the ring with more rooms can have a door to the room opposite its middle, in the middle of their common wall.
        # Some are narrower than a door, but on each side by less than half a wall, so that a door opens no third room.
        below = counts[ring + 1]
        many, few = max(count, below), min(count, below)
        for room in range(many):
            other = int((room + 0.5) / many * few)
            start = max(room / many, other / few)
            end = min((room + 1) / many, (other + 1) / few)
            upper, lower = (room, other) if count >= below else (other, room)
            pairs.append(((ring, upper), (ring + 1, lower), WHOLE * (start + end) / 2.0))
    return pairs


def doors(counts):
    """A random tree of doors: there is one way from any room to any other."""
    beside = {}
    for first, second, longitude in possible_doors(counts):
        beside.setdefault(first, []).append((second, longitude))
        beside.setdefault(second, []).append((first, longitude))
    draw = random.Random(SEED)
    start = (len(counts) // 2, 0)
    found, stack, tree = {start}, [start], []
    while stack:
        room = stack[-1]
        unvisited = [(other, longitude) for other, longitude in beside[room] if other not in found]
        if not unvisited:
            stack.pop()
            continue
        other, longitude = draw.choice(unvisited)
        found.add(other)
        tree.append((room, other, longitude))
        stack.append(other)
    return tree


def walls(position):
    """Which of these places, on a ball of radius 1, are wall."""
    half_wall, half_door = 0.5 * WALL * WIDTH, 0.5 * (1.0 - WALL) * WIDTH
    counts = rooms()
    polar = np.arccos(np.clip(position[..., 1], -1.0, 1.0))
    longitude = np.arctan2(position[..., 2], position[..., 0]) % WHOLE
    # Lengths along a parallel are angles times this.
    around = np.sin(polar)
    ring = np.clip((polar / WIDTH).astype(int), 0, RINGS - 1)
    is_wall = np.zeros(polar.shape, bool)
    for k in range(1, RINGS):
        is_wall |= np.abs(polar - k * WIDTH) < half_wall
    for k, count in enumerate(counts):
        if count > 1:
            side = WHOLE / count
            off = np.abs((longitude + 0.5 * side) % side - 0.5 * side)
            is_wall |= (ring == k) & (off * around < half_wall)
    for (a, _), (b, _), door in doors(counts):
        off = np.abs((longitude - door + np.pi) % WHOLE - np.pi) * around
        if a == b:
            in_door = (off < half_wall) & (np.abs(polar - (a + 0.5) * WIDTH) < half_door)
        else:
            in_door = (off < half_door) & (np.abs(polar - max(a, b) * WIDTH) < half_wall)
        is_wall &= ~in_door
    return is_wall


def write_png(path, pixels):
    """A PNG with 8 bits a colour, without a library."""
    height, width, _ = pixels.shape
    lines = b"".join(b"\0" + line.tobytes() for line in pixels)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    with open(path, "wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(lines, 9)) + chunk(b"IEND", b""))


def main():
    if len(sys.argv) != 3:
        sys.exit("usage: ball_maze.py BALL.npz MAP.png")
    try:
        with np.load(sys.argv[1]) as data:
            position, is_owned = data["texel_position"], data["texel_triangle"] >= 0
    except (OSError, KeyError, ValueError) as error:
        sys.exit(f"ball_maze: {sys.argv[1]} is not what `myxo export BALL --out BALL.npz` writes: {error}")
    position = np.where(is_owned[..., None], position, [0.0, 1.0, 0.0])
    position = position / np.linalg.norm(position, axis=-1, keepdims=True)
    pixels = np.zeros(is_owned.shape + (3,), np.uint8)
    pixels[is_owned & walls(position), 0] = 255
    write_png(sys.argv[2], pixels)


if __name__ == "__main__":
    main()
