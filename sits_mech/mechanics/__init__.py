"""From the wrench to the pose: block (in space), layer (in the plane), linear, closed_form."""
