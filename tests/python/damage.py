"""Damaged files, as bad disks, broken transfers or other programs make them."""

import random

import numpy as np


def put(index, value):
    """A change of an array: `value` at `index`."""
    def change(array):
        array = np.array(array)
        array[index] = value
        return array

    return change


def replace(name, value):
    """A change of an HDF5 group: `value`, or `value` of the old array, as the array `name`."""
    def change(group):
        array = value(group[name][()]) if callable(value) else value
        del group[name]
        group[name] = array

    return change


def damaged(whole, count, seed=1):
    """`count` variants of the bytes `whole`: cut, doubled, empty, flipped bits, zeros, noise."""
    rng = random.Random(seed)
    for k in range(count):
        content, at = bytearray(whole), rng.randrange(max(1, len(whole)))
        if k % 4 == 0:
            del content[at:]
        elif k % 4 == 1:
            for _ in range(rng.choice((1, 1, 3, 30))):
                content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
        elif k % 4 == 2:
            content[at : at + 64] = bytes(len(content[at : at + 64]))
        else:
            content[at : at + 16] = rng.randbytes(len(content[at : at + 16]))
        yield bytes(content)
    yield from (b"", b"\0", whole[:-1], whole * 2, whole[::-1])


def damaged_text(text, count, seed=1):
    """`count` variants of a table: words replaced, dropped or doubled; then `damaged`."""
    rng = random.Random(seed)
    strange = ("nan inf -inf 1e400 -1 0 1e-320 2147483648 1e18 999999999 abc µ 1,5 0x10 1j -- ' \" "
               "\0").split(" ")
    for _ in range(count):
        lines = text.split("\n")
        row = rng.randrange(len(lines))
        words = lines[row].replace(",", " , ").split() or [""]
        at = rng.randrange(len(words))
        words[at : at + 1] = rng.choice(([], [words[at]] * 2, [rng.choice(strange)],
                                         [rng.choice(strange)], ["9" * rng.randrange(1, 400)]))
        lines[row] = " ".join(words).replace(" , ", ",")
        yield "\n".join(lines).encode()
    yield from damaged(text.encode(), count, seed)
