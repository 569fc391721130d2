"""Timing of a fixed path: TOPP-RA, convex path tracking, jerk-limited timing."""
