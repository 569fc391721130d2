"""Motions to prove, ways to falsify a proof, and an independent measure of what became false."""
