"""The graph of a search: the states that it has tried, and how they are joined."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from simx_server.kinematics.scratch import Array

from .paths import Tree


@dataclass
class Graph:
    """States (n,) and edges, by the indices of their first and last state."""

    states: list[Array] = field(default_factory=list[Array])
    edges: list[tuple[int, int]] = field(default_factory=list[tuple[int, int]])
    starts: list[int] = field(default_factory=list[int])
    goals: list[int] = field(default_factory=list[int])


def graph_of(trees: Sequence[Tree], path: Sequence[Array]) -> Graph:
    """Return the graph of a search from the start and, if there is a second tree, from the goals.

    Args:
        trees: that of the start, and that of the goals, whose ways lead from branches to roots.
        path: the states of the path, if one was found: those of the trees.
    """
    found = Graph()
    for tree, roots in zip(trees, (found.starts, found.goals), strict=False):
        offset = len(found.states)
        found.states += tree.states
        for index, parent in enumerate(tree.parents, offset):
            if parent < 0:
                roots.append(index)
            elif roots is found.goals:
                found.edges.append((index, parent + offset))
            else:
                found.edges.append((parent + offset, index))
    known = {id(state): index for index, state in enumerate(found.states)}
    listed = set(found.edges)
    for first, last in pairwise(path):
        edge = known[id(first)], known[id(last)]
        if edge not in listed:  # where the trees have met
            found.edges.append(edge)
    if len(trees) == 1 and path:
        found.goals.append(known[id(path[-1])])
    return found
