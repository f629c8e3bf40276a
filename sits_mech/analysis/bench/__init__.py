"""A bench of loads: what it shows of a sensor that is not quite known, and which loads show most."""
