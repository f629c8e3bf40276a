"""Parts of the axisymmetric model of permeable discs: the scene on its axis, lines between cells, finite elements."""
