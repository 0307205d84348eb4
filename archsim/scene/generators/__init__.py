"""Seeded procedural meshes: the same generator, seed and parameters give the same bytes."""

from archsim.scene.generators.registry import GENERATORS, make_mesh

__all__ = ["GENERATORS", "make_mesh"]
