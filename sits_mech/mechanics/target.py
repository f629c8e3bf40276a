"""How does the rigid target move the nodes bonded to it, and what does the dead load cost?

The target is exactly rigid: three numbers ``q = (d_h, d_z, alpha)`` place every bonded node. A point at distance X from
the centre of the bonded face moves by

    u_x = d_h + X (cos alpha - 1),        u_z = d_z - X sin alpha,

with `d_z` minus the sink and `alpha` clockwise in the x-z picture, of any size. The force keeps its direction and acts
at the material point `height` above that centre, which moves to (d_h + height sin alpha, d_z + height cos alpha); so

    V(q) = -F_x (d_h + height sin alpha) + F_z (d_z + height (cos alpha - 1)) - M alpha.

Unknowns eliminated this way need no penalty and no multiplier. Scaled: lengths by the thickness of the layer, forces
per depth by shear modulus times thickness, moments by shear modulus times thickness squared.
"""

from __future__ import annotations

import numpy as np

from sits_mech.quantities import Array


def bonded_displacement(X: Array, q: Array) -> Array:
    """Return the displacement of the bonded nodes.

    Parameters
    ----------
    X : ndarray, shape (n,)
        Distances from the centre of the bonded face.
    q : ndarray, shape (3,)
        Shear, upward displacement, clockwise rotation [rad].

    Returns
    -------
    ndarray, shape (n, 2)
    """
    return np.stack([q[0] + X * (np.cos(q[2]) - 1.0), q[1] - X * np.sin(q[2])], axis=-1)


def bonded_tangent(X: Array, alpha: float) -> tuple[Array, Array]:
    """Return the first derivative of `bonded_displacement` by q, and the second by alpha (all others vanish).

    Parameters
    ----------
    X : ndarray, shape (n,)
        Distances from the centre of the bonded face.
    alpha : float
        Rotation [rad].

    Returns
    -------
    first : ndarray, shape (n, 2, 3)
    second : ndarray, shape (n, 2)
    """
    cos, sin = np.cos(alpha), np.sin(alpha)
    first = np.zeros((X.size, 2, 3))
    first[:, 0, 0] = first[:, 1, 1] = 1.0
    first[:, :, 2] = np.stack([-X * sin, -X * cos], axis=-1)
    return first, np.stack([-X * cos, X * sin], axis=-1)


def load_potential(load: Array, height: float, q: Array) -> tuple[float, Array, float]:
    """Return the potential of the dead load, its gradient by q, and its second derivative by alpha.

    Parameters
    ----------
    load : ndarray, shape (3,)
        F_x, F_z, M, scaled.
    height : float
        Where the force acts above the bonded face, scaled.
    q : ndarray, shape (3,)
        Shear, upward displacement, clockwise rotation.
    """
    F_x, F_z, M = (float(value) for value in load)
    cos, sin = float(np.cos(q[2])), float(np.sin(q[2]))
    value = -F_x * (q[0] + height * sin) + F_z * (q[1] + height * (cos - 1.0)) - M * q[2]
    gradient = np.array([-F_x, F_z, -height * (F_x * cos + F_z * sin) - M])
    return float(value), gradient, height * (F_x * sin - F_z * cos)
