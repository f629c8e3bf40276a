"""From the pose to the inductances: bars (planar), field (planar-fem), rings (axisymmetric), sheets (in space)."""
