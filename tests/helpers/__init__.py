"""Tasks, motions, oracles and stand-ins that several tests share: ``from helpers.row_oracle import make_arm``."""
