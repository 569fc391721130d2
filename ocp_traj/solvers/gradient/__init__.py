"""Gradient solvers: CasADi's nlpsol plug-ins on the lifted form, continued, refined and made exact."""
