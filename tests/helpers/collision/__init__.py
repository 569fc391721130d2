"""Cells and motions for tests of collision, and published problems."""
