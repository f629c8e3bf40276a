#!/usr/bin/env bash
# Guess:    Ogden constants enter FElupe and matADi as R. W. Ogden printed them (Proc. R. Soc. A 326 (1972) 565):
#           W = sum mu/alpha (l1^alpha + l2^alpha + l3^alpha - 3), whose shear modulus is sum mu alpha/2.
# Happens:  both take W = sum 2 mu/alpha^2 (...), as Abaqus does, where mu itself is a part of the modulus. Treloar's
#           rubber by Ogden's own three terms then pulls 1.47 times too hard at small strain and 0.71 times at a stretch
#           of 7. No number is out of range, nothing warns; with mu alpha/2 in place of mu it is right.
# Version:  felupe 11.3.0, tensortrax 0.29.0, matadi 0.5.0.
# Users:    whoever takes a silicone's constants out of a paper's table into a finite element code.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install -q --disable-pip-version-check felupe==11.3.0 tensortrax==0.29.0 matadi==0.5.0 casadi==3.8.2 \
    numpy==2.4.6 scipy==1.17.1
cat >show.py <<'PYTHON'
import felupe
import matadi
import numpy as np
from felupe.constitution.tensortrax.models.hyperelastic import ogden
from matadi.models import ogden as ogden_of_matadi

MU, ALPHA = np.array([0.63, 0.0012, -0.01]), np.array([1.3, 5.0, -2.0])  # MPa, as printed


def pulled(law, stretch):
    """Nominal stress of an incompressible bar, the pressure taken from its free sides."""
    stress = law.gradient([np.diag([stretch, stretch**-0.5, stretch**-0.5]).reshape(3, 3, 1, 1), None])[0][..., 0, 0]
    return stress[0, 0] - stress[2, 2] * stretch**-1.5


laws = {
    "felupe, constants as printed": felupe.Hyperelastic(ogden, mu=MU, alpha=ALPHA),
    "felupe, mu alpha/2 as mu": felupe.Hyperelastic(ogden, mu=MU * ALPHA / 2, alpha=ALPHA),
    "matadi, constants as printed": matadi.MaterialHyperelastic(ogden_of_matadi, mu=MU, alpha=ALPHA, bulk=5e3),
}
for stretch in 1.01, 2.0, 7.0:
    printed = (MU * (stretch ** (ALPHA - 1) - stretch ** (-ALPHA / 2 - 1))).sum()
    print(f"stretch {stretch}: {printed:.4f} MPa by the printed formula")
    for label, law in laws.items():
        print(f"    {label}: {pulled(law, stretch) / printed:.2f} times that")
PYTHON
env/bin/python show.py 2>/dev/null | tee seen
diff seen - <<'SEEN'
stretch 1.01: 0.0125 MPa by the printed formula
    felupe, constants as printed: 1.47 times that
    felupe, mu alpha/2 as mu: 1.00 times that
    matadi, constants as printed: 1.47 times that
stretch 2.0: 0.6027 MPa by the printed formula
    felupe, constants as printed: 1.47 times that
    felupe, mu alpha/2 as mu: 1.00 times that
    matadi, constants as printed: 1.47 times that
stretch 7.0: 3.9952 MPa by the printed formula
    felupe, constants as printed: 0.71 times that
    felupe, mu alpha/2 as mu: 1.00 times that
    matadi, constants as printed: 0.71 times that
SEEN
