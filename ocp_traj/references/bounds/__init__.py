"""Lower bounds of any motion through the waypoints, and certificates of families."""
