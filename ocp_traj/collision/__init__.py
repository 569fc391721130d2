"""Collision: convex bodies of a robot and its cell, which pairs are judged, and how far from each other they are."""

from __future__ import annotations

from ocp_traj.collision.cell import Cell, cell_of
from ocp_traj.collision.scene import CollisionScene, Contact, Shape, Solid

__all__ = ["Cell", "CollisionScene", "Contact", "Shape", "Solid", "cell_of"]
