"""The sensor as it is described: parts, units, files, checks."""
