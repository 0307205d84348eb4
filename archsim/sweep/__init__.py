"""Sweeps: many runs that differ in a few values, never repeated, never lost."""
