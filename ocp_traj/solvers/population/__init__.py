"""Population methods on the condensed form."""
