"""Reader of Siconos' text files of contact problems in the plane."""

import numpy as np

from rcr._data import checks
from rcr._data.problem import DelassusProblem


def load_siconos(path):
    """Return the DelassusProblem of a ``.dat`` file."""
    with open(path, encoding="ascii", errors="replace") as file:
        words = _Words(file.read())
    dimension, nc = words.integer("dimension"), words.integer("number of contacts")
    if dimension != 2:
        raise ValueError(f"dimension = {dimension}; expected 2, contacts in the plane")
    storage, rows, columns = words.integers("storage, rows and columns of the matrix", 3)
    if nc < 0 or not rows == columns == 2 * nc:
        raise ValueError(f"the matrix is {rows} × {columns} for {nc} contacts; expected 2 each")
    if storage not in (0, 1, 2):
        raise ValueError(f"storage = {storage}; expected 0 dense, 1 blocks or 2 sparse")
    entries = (_dense, _blocks, _sparse)[storage](words, 2 * nc)
    q, mu = words.numbers("q", 2 * nc), words.numbers("mu", nc)
    return DelassusProblem(entries, q, mu)


class _Words:
    """Reads the words of a text in order."""

    def __init__(self, text):
        lines = [line.split() for line in text.split("\n")]
        self.words, self.at = [word for line in lines for word in line], 0
        self.ends = np.cumsum([len(line) for line in lines])

    def line(self):
        """Return the rest of the line of the next word, empty at the end, and its number."""
        k = int(np.searchsorted(self.ends, self.at, side="right"))
        return self.words[self.at : self.ends[k] if k < len(self.ends) else None], k + 1

    def numbers(self, what, count):
        """Read `count` numbers, over several lines; `what` names them in an error."""
        if not 0 <= count <= len(self.words):
            raise ValueError(f"{count} numbers of {what} are announced, of {len(self.words)} words")
        found = self.words[self.at : self.at + count]
        if len(found) < count:
            raise ValueError(f"the file ends after {len(found)} of {count} numbers of {what}")
        self.at += count
        try:
            return np.array(found, float)
        except ValueError:
            raise ValueError(f"{what} holds a word that is not a number, before line "
                             f"{self.line()[1]}") from None

    def integer(self, what):
        return int(self.integers(what, 1)[0])

    def integers(self, what, count):
        value = self.numbers(what, count)
        good = (abs(value) < 2**31) & (value == np.floor(value))
        checks.require(good, f"the {what}", value, "whole numbers of 32 bits")
        return value.astype(int)


def _dense(words, size):
    """Read a matrix that is stored column by column."""
    words.numbers("the size of the matrix", 2)
    value = words.numbers("the matrix", size * size)
    return np.tile(np.arange(size), size), np.repeat(np.arange(size), size), value


def _blocks(words, size):
    """Read blocks in order of rows, each by columns. Their sizes are given as running sums."""
    count, rows, columns = words.integers("blocks", 3)
    row_end = words.integers("block rows", rows)
    column_end = words.integers("block columns", columns)
    filled1, filled2 = words.integers("index", 2)
    start, block_column = words.integers("index1", filled1), words.integers("index2", filled2)
    for ends, name in (row_end, "rows"), (column_end, "columns"):
        last = ends[-1] if len(ends) else 0
        if (np.diff(ends, prepend=0) < 0).any() or last != size:
            raise ValueError(f"the ends of the block {name} do not rise from 0 to {size}")
    fits = count == filled2 and filled1 == rows + 1 and (np.diff(start) >= 0).all()
    inside = (block_column >= 0) & (block_column < columns)
    if not fits or start[-1] != count or not inside.all():
        raise ValueError(f"the index of {count} blocks does not fit {rows} × {columns} blocks")
    row_start, column_start = (np.concatenate([[0], ends[:-1]]) for ends in (row_end, column_end))
    entries = [(np.zeros(0, int), np.zeros(0, int), np.zeros(0))]
    for i in range(rows):
        for k in range(start[i], start[i + 1]):
            j = block_column[k]
            if words.integer("number of a block") != k:
                raise ValueError(f"block {k} is not at the place in its index")
            row = np.arange(row_start[i], row_end[i])
            column = np.arange(column_start[j], column_end[j])
            value = words.numbers(f"block {k}", len(row) * len(column))
            entries.append((np.tile(row, len(column)), np.repeat(column, len(row)), value))
    return tuple(np.concatenate(part) for part in zip(*entries))


def _sparse(words, size):
    """Read a matrix as CSparse prints it.

    Lines are `col 3 : locations 6 to 9` with following lines `row : value`, or triplets
    `row column : value`.
    """
    words.integer("origin of the matrix")
    row, column, value, at, count = [], [], [], None, None
    line, number = words.line()
    while line and (":" in line or count is None):
        try:
            if line[0] == "col":
                at = int(line[1])
            elif "nnz:" in line:
                count = int(float(line[line.index("nnz:") + 1].rstrip(",")))
            elif ":" in line:
                split = line.index(":")
                places = [int(float(word)) for word in line[:split]]
                row.append(places[0])
                column.append(places[1] if split == 2 else at)
                value.append(float(line[split + 1]))
        except (ValueError, IndexError, TypeError):
            found = " ".join(line)[:60]
            raise ValueError(f"line {number} is not a line of a sparse matrix: {found!r}") from None
        words.at += len(line)
        line, number = words.line()
    if None in column:
        raise ValueError("entries of the sparse matrix precede the first line `col`")
    if count is None or (count < 1e6 and count != len(value)):  # printed with six digits
        raise ValueError(f"the sparse matrix has {len(value)} entries; its header says {count}")
    return np.array(row, int), np.array(column, int), np.array(value, float)
