"""Problems with known optima, constrained ones, and a test of structural bias."""
