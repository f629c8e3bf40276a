"""How far to solve what is asked for: errors of a pose weighed by the signals, and aimed at a tolerance."""
