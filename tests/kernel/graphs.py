"""Graphs for the tests of the block LU: number of nodes and list of edges."""


def grid(rows, columns):
    at = lambda i, j: i * columns + j
    across = [(at(i, j), at(i, j + 1)) for i in range(rows) for j in range(columns - 1)]
    up = [(at(i + 1, j), at(i, j)) for i in range(rows - 1) for j in range(columns)]
    return rows * columns, across + up


def star(leaves):
    return leaves + 1, [(0, k) for k in range(1, leaves + 1)]
