"""Many cases from one study file: requests, workers, tables."""
