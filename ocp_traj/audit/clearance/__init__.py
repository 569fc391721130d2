"""Clearance at every instant: proved by planes, or refuted by an instant."""
