"""From the pose to the inductances: bars (planar), field (planar-fem), rings and axis_fem (axisymmetric), sheets."""
