"""How well estimators do on data like a laboratory's: random scenarios, errors, closed loop."""
