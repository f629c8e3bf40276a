"""One mesh: along a path (path.py), by increments brought to rest (newton.py), to an Outcome (outcome.py)."""
