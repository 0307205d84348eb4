"""Which way of a set gives up its line: the arithmetic of the policies that need more than a time of use."""

from __future__ import annotations

from archsim.jit import inlined

_WORD = 0xFFFFFFFF


@inlined
def tree_used(tree, way, num_ways):
    """The set's bits after a use of `way`: every node on the path to it points to the other half.

    Node 1 is the root, node n has the children 2n and 2n + 1; a bit that is set points to the second.
    """
    node = 1
    half = num_ways >> 1
    while half > 0:
        second = (way & half) != 0
        tree = tree & ~(1 << node) if second else tree | (1 << node)
        node = 2 * node + second
        half >>= 1
    return tree


@inlined
def tree_points_to(tree, num_ways):
    """The way that the set's bits lead to."""
    node = 1
    while node < num_ways:
        node = 2 * node + (tree >> node & 1)
    return node - num_ways


@inlined
def random_way(seed, count, num_ways):
    """A way drawn for the cache's request number `count`, the same in every run with this seed."""
    return hashed(hashed(seed & _WORD) ^ (count & _WORD)) * num_ways >> 32


@inlined
def hashed(number):
    """32 bits in which every one of the number's 32 bits counts; no product leaves 63 bits."""
    number = ((number ^ (number >> 16)) * 0x21F0AAAD) & _WORD
    number = ((number ^ (number >> 15)) * 0x735A2D97) & _WORD
    return number ^ (number >> 15)
