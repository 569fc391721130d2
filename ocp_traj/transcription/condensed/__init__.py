"""The condensed form: durations and virtual-knot positions alone, for populations and gradients alike."""
