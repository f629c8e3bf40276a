"""Which pads and loads are the references of? Sizes, silicone and load of each, as a scene and for NGSolve.

Lengths in mm, loads in newtons and N mm on the whole pad (per metre of depth of a layer in plane strain), all on a
copper target whose loads act at its lower face if nothing else is said. Contact of free faces is off on both sides.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from random import Random
from typing import Any, Literal

MU = 30.0  # kPa
LAWS: Mapping[str, tuple[str, Mapping[str, float | list[float]]]] = {
    # constants over the initial shear modulus, those without that unit in words
    "neo-hookean": ("", {"shear_modulus": 1.0}),
    "mooney-rivlin": ("", {"c10": 0.35, "c01": 0.15}),
    "yeoh": ("", {"c10": 0.5, "c20": 0.05, "c30": 0.01}),
    "ogden": ("alpha=[2.0, -2.0], ", {"mu": [0.6, 0.4]}),
    "gent": ("j_m=10.0, ", {"shear_modulus": 1.0}),
    "ogden 4": ("alpha=[4.0, -2.0], ", {"mu": [0.7, 0.3]}),
}
# Order of the elements, and of those beside them: parts of the base cells of their meshes
FAMILIES: Mapping[int, tuple[int, ...]] = {3: (1, 2, 3, 4), 2: (2, 3, 4)}
SECTIONS: Mapping[int, tuple[int, ...]] = {3: (1, 2, 3, 4, 6), 2: (2, 3, 4, 6, 8)}
ECOFLEX = (7471.5, 248.86, 14940.0)  # c10, c20 [Pa], K [kPa] of the catalogue's ecoflex-00-30


@dataclass(frozen=True)
class Case:
    """One pad under one load.

    Attributes
    ----------
    name : str
    kind : str
        "plane" for a layer in plane strain, "round" for a disc on a cylinder, "box" for a rectangle on a box, "mixed"
        for a disc on a box.
    pad, target : (float, float)
        Width and length, of what is round the diameter twice [mm].
    thickness : float
        Of the pad [mm].
    load : (float, float, float)
        F_x, F_z down [N, or N/m], M [N mm, or N mm/m].
    law : str
    bulk : float
        Bulk over shear modulus [-].
    height : float
        Of the load above the target's lower face [mm].
    linear : bool
        Whether the load is so small that the stiffness at rest answers for it.
    turned : bool
        Whether the package is asked for pad and load turned by a quarter about z: F_y and M_x, the whole pad.
    prony : tuple of (float, float)
        Share of the instantaneous stiffness [-] and time [s] of each branch.
    mullins : mapping or None
        Softening: r [-], m over the initial shear modulus, beta [-].
    meshes : mapping of int to tuple of int
        Order of the elements of a family, and parts of the base cells of its meshes.
    axial : bool
        Whether the package is asked of a section about the axis.
    milder : bool
        Whether a section stands on such a family, too: loads that crease smaller cells.
    fanned : bool
        Whether a flush box stands on prisms that meet in its corners (ngsolve_fans.py): loads that fold bricks there.
    twist : float
        M_z [N mm], alone, small: a flush cylinder turns by ``2 M_z t/(pi mu a^4)``, exactly (A. de Saint-Venant 1855).
    """

    name: str
    kind: Literal["plane", "round", "box", "mixed"]
    pad: tuple[float, float]
    target: tuple[float, float]
    thickness: float
    load: tuple[float, float, float]
    law: str = "neo-hookean"
    bulk: float = 1000.0
    height: float = 0.0
    linear: bool = False
    turned: bool = False
    twist: float = 0.0
    prony: tuple[tuple[float, float], ...] = ()
    mullins: Mapping[str, float] | None = None
    meshes: Mapping[int, tuple[int, ...]] = field(default_factory=lambda: FAMILIES, compare=False)
    milder: bool = False
    axial: bool = False
    fanned: bool = False

    @property
    def model(self) -> str:
        """The package's model."""
        return "planar" if self.kind == "plane" else "axisymmetric" if self.axial else "block"

    @property
    def bond(self) -> tuple[float, float]:
        """Width and length of what the target covers [mm]."""
        return min(self.target[0], self.pad[0]), min(self.target[1], self.pad[1])

    @property
    def mu(self) -> float:
        """Initial shear modulus [kPa]."""
        return 2e-3 * ECOFLEX[0] if self.law == "ecoflex" else MU

    @property
    def K(self) -> float:
        """Bulk over shear modulus [-]."""
        return ECOFLEX[2] / self.mu if self.law == "ecoflex" else self.bulk

    @property
    def on_family(self) -> bool:
        """Whether its meshes are of a family whose cells are divided: in space at finite strain, films, milder."""
        solid = self.kind in ("box", "mixed") or (self.kind == "round" and bool(self.load[0] or self.load[2]))
        film = self.kind == "box" and self.target[0] > 50.0 * self.thickness
        return self.milder or film or (solid and not self.linear)

    @property
    def changes(self) -> list[str]:
        """What makes the scene of it from the catalogue's biorob2018."""
        x, y = self.pad[::-1] if self.turned else self.pad
        size = f'diameter="{x} mm"' if self.kind == "round" else f'width="{x} mm", length="{y} mm"'
        size = f'width="{x} mm", length="1 m"' if self.kind == "plane" else size
        pad = f'{size}, thickness="{self.thickness} mm", contact="never", material={self.material}'
        x, y = self.target[::-1] if self.turned else self.target
        rectangle = f'shape="rectangle", width="{x} mm", length="{y} mm"'
        size = f'shape="disc", diameter="{x} mm"' if self.kind in ("round", "mixed") else rectangle
        target = f'material="copper", {size}, thickness="0.2 mm", load_height="{self.height} mm"'
        return [f"elastomer={{{pad}}}", f"target={{{target}}}"]

    @property
    def material(self) -> str:
        """The silicone by name, or as an inline table [Pa]."""
        if self.law == "ecoflex":
            return '"ecoflex-00-30"'
        words, shares = LAWS[self.law]
        scale = 1e3 * self.mu
        each = {name: [scale * x for x in share] if isinstance(share, list) else scale * share
                for name, share in shares.items()}
        constants = ", ".join(f"{name}={value}" for name, value in each.items())
        law, history = self.law.partition(" ")[0], ""
        if self.prony:
            branches = ", ".join(f'{{weight={weight}, time="{tau} s"}}' for weight, tau in self.prony)
            history += f", prony=[{branches}]"
        if self.mullins:
            keys = ", ".join(f"{key}={scale * x if key == 'm' else x:g}" for key, x in self.mullins.items())
            history += f", mullins={{{keys}}}"
        return f'{{law="{law}", {words}{constants}, bulk_modulus={scale * self.K}{history}}}'

    def energy(self, I1: Any, I2: Any) -> Any:
        """Isochoric energy over the initial shear modulus, for NGSolve; Ogden's even powers are of I1 and I2."""
        if self.law == "gent":
            from ngsolve import log

            return -5.0 * log(1.0 - (I1 - 3) / 10.0)
        if self.law == "ogden":
            return 0.3 * (I1 - 3) + 0.2 * (I2 - 3)
        if self.law == "ogden 4":  # sum of lambda^4: I1^2 - 2 I2
            return 0.0875 * (I1 * I1 - 2 * I2 - 3) + 0.15 * (I2 - 3)
        if self.law == "ecoflex":
            return 0.5 * (I1 - 3) + ECOFLEX[1] / (2.0 * ECOFLEX[0]) * (I1 - 3) ** 2
        c = LAWS[self.law][1]
        x, y = I1 - 3, I2 - 3
        if self.law == "neo-hookean":
            return 0.5 * x
        if self.law == "mooney-rivlin":
            return 0.35 * x + 0.15 * y
        return c["c10"] * x + c["c20"] * x**2 + c["c30"] * x**3


def _layers() -> list[Case]:
    """Layers in plane strain; the first seven loads are those of another reference of the project."""
    wide, flush = ((20.0, 1e3), (15.0, 1e3), 2.0), ((15.0, 1e3), (15.0, 1e3), 3.0)
    rows = [
        Case("layer, pressed 5 %", "plane", *wide, (0.0, 1810.0, 0.0)),
        Case("layer, sheared and pressed", "plane", *wide, (267.0, 4050.0, 0.0)),
        Case("layer, moment", "plane", *wide, (0.0, 0.0, -1750.0)),
        Case("layer, sheared 10 %", "plane", *wide, (53.9, 0.0, 0.0)),
        Case("flush layer, pressed 5 %", "plane", *flush, (0.0, 709.0, 0.0)),
        Case("flush layer, sheared 10 %", "plane", *flush, (42.5, 0.0, 0.0)),
        Case("flush layer, sheared 50 %", "plane", *flush, (213.0, 0.0, 0.0)),
        Case("layer, sheared 74 %", "plane", (20.0, 1e3), (8.0, 1e3), 2.0, (178.0, 0.0, 0.0)),
        Case("soft layer, nu 0.45", "plane", (10.0, 1e3), (6.0, 1e3), 4.0, (5.0, 120.0, 0.0), bulk=9.7),
        Case("layer, small press", "plane", *wide, (0.0, 1e-2, 0.0), linear=True),
        Case("layer, small shear", "plane", *wide, (1e-2, 0.0, 0.0), linear=True),
        Case("flush layer, small press", "plane", *flush, (0.0, 1e-2, 0.0), linear=True),
        Case("square section, pulled", "plane", (4.0, 1e3), (4.0, 1e3), 4.0, (3.0, -25.0, 0.0)),
    ]
    for law in ("mooney-rivlin", "yeoh", "ogden", "gent"):
        rows.append(Case(f"layer, {law}", "plane", (20.0, 1e3), (10.0, 1e3), 2.0, (60.0, 300.0, 200.0), law))
    return rows


def _round() -> list[Case]:
    """Discs on cylinders, pressed or pulled along their axis, or turned and sheared at small strain."""
    rows: list[Case] = []

    def add(name: str, pad: float, target: float, t: float, load: tuple[float, float, float], **more: Any) -> None:
        rows.append(Case(name, "round", (pad, pad), (target, target), t, load, **more))

    add("flush disc 15 x 2, pressed 1 %", 15.0, 15.0, 2.0, (0.0, 1.2, 0.0))
    add("flush disc 15 x 2, pulled 8 %", 15.0, 15.0, 2.0, (0.0, -10.0, 0.0))
    add("flush disc 15 x 2, small shear", 15.0, 15.0, 2.0, (1e-4, 0.0, 0.0), linear=True)
    add("flush disc 15 x 2, small moment", 15.0, 15.0, 2.0, (0.0, 0.0, 1e-3), linear=True)
    add("disc 10 on 20 x 2, small shear", 20.0, 10.0, 2.0, (1e-4, 0.0, 0.0), linear=True)
    add("disc 10 on 20 x 2, small press", 20.0, 10.0, 2.0, (0.0, 1e-4, 0.0), linear=True)
    add("disc 10 on 15 x 2, pressed 8 %", 15.0, 10.0, 2.0, (0.0, 4.0, 0.0))
    add("disc 5 on 10 x 5, nu 0.45", 10.0, 5.0, 5.0, (0.0, 1.0, 0.0), bulk=9.7)
    add("flush disc 8 x 4, nu 0.45, pressed 3 %", 8.0, 8.0, 4.0, (0.0, 0.4, 0.0), bulk=9.7)
    add("flush disc 10 x 10, pulled 10 %", 10.0, 10.0, 10.0, (0.0, -0.8, 0.0), bulk=50.0)
    add("disc 8 on 20 x 2, ecoflex", 20.0, 8.0, 2.0, (0.0, 2.0, 0.0), law="ecoflex", height=0.2)
    add("flush disc 20 x 1, nu 0.4999", 20.0, 20.0, 1.0, (0.0, 20.0, 0.0), bulk=5000.0)
    add("disc 8 on 12 x 3, gent", 12.0, 8.0, 3.0, (0.0, 1.5, 0.0), law="gent")
    add("disc 8 on 12 x 3, ogden, pulled", 12.0, 8.0, 3.0, (0.0, -0.8, 0.0), law="ogden")
    add("flush disc 12 x 4, mooney-rivlin", 12.0, 12.0, 4.0, (0.0, 2.0, 0.0), law="mooney-rivlin")
    add("disc 8 on 12 x 2, yeoh", 12.0, 8.0, 2.0, (0.0, 2.0, 0.0), law="yeoh")
    add("disc 4 on 16 x 2, nu 0.49", 16.0, 4.0, 2.0, (0.0, 0.5, 0.0), bulk=50.0)
    add("disc 6 on 12 x 6, sheared little", 12.0, 6.0, 6.0, (1e-4, 0.0, 0.0), bulk=50.0, linear=True)
    add("flush disc 15 x 2, small twist", 15.0, 15.0, 2.0, (0.0, 0.0, 0.0), linear=True, twist=1e-3)
    add("flush disc 20 x 0.1, film", 20.0, 20.0, 0.1, (0.0, 0.1, 0.0), linear=True)
    add("flush disc 20 x 0.02, film", 20.0, 20.0, 0.02, (0.0, 0.1, 0.0), linear=True)
    return rows


def _boxes() -> list[Case]:
    """Rectangles on boxes."""
    rows: list[Case] = []
    square = ((20.0, 20.0), (15.0, 15.0), 2.0)
    for name, load in (("press", (0.0, 1e-4, 0.0)), ("shear", (1e-4, 0.0, 0.0)), ("moment", (0.0, 0.0, 1e-3))):
        rows.append(Case(f"15 x 15 on 20 x 20 x 2, small {name}", "box", *square, load, linear=True))
    published = ((20.0, 20.0), (15.0, 8.0), 2.0)
    for name, load in (("press", (0.0, 1e-4, 0.0)), ("shear", (1e-4, 0.0, 0.0))):
        rows.append(Case(f"biorob2018-w15, small {name}", "box", *published, load, "ecoflex", height=0.2, linear=True))
        rows.append(replace(rows[-1], name=f"{rows[-1].name}, turned", turned=True))
    film = ((20.0, 20.0), (8.0, 8.0))
    rows += [
        Case("8 x 8 on 20 x 20 x 0.1, film", "box", *film, 0.1, (0.0, 0.01, 0.0), linear=True),
        Case("8 x 8 on 20 x 20 x 0.02, film", "box", *film, 0.02, (0.0, 0.01, 0.0), linear=True),
        Case("flush 15 x 15 x 3, 5 N", "box", (15.0, 15.0), (15.0, 15.0), 3.0, (0.0, 5.0, 0.0)),
        Case("8 x 8 on 12 x 12 x 4, nu 0.45", "box", (12.0, 12.0), (8.0, 8.0), 4.0, (0.0, 3.0, 0.0), bulk=9.7),
        Case("15 x 15 on 20 x 20 x 2, 13 N", "box", *square, (0.0, 13.0, 0.0)),
        Case("15 x 15 on 20 x 20 x 2, 1.8 N", "box", *square, (1.8, 0.0, 0.0)),
        Case("biorob2018-w15, 0.5 N and 2 N", "box", *published, (0.5, 2.0, 0.0), "ecoflex", height=0.2),
        Case("biorob2018, 13.33 N", "box", (20.0, 20.0), (8.0, 8.0), 2.0, (0.0, 13.33, 0.0), "ecoflex", height=0.2),
        Case("6 x 6 x 6, pulled and sheared", "box", (6.0, 6.0), (6.0, 6.0), 6.0, (0.2, -0.2, 0.0), bulk=50.0),
        Case("8 x 4 on 12 x 6 x 2, moment", "box", (12.0, 6.0), (8.0, 4.0), 2.0, (0.0, 0.3, 1.0), "gent"),
    ]
    for wide, t, load in ((8.0, 2.0, (0.768, 0.0, 0.0)), (5.0, 1.5, (0.225, 0.141, 0.0))):
        name = f"flush {wide:g} x {wide:g} x {t:g}, {load[0]} N of shear, {load[1]:g} N"
        rows.append(Case(name, "box", (wide, wide), (wide, wide), t, load, bulk=49.67, fanned=True))
    for F_x, F_z in ((0.3, 1.0), (0.4, 1.6), (1.0, 2.0)):
        own = Case(f"biorob2018, {F_x:g} N and {F_z:g} N", "box", *published[:1], (8.0, 8.0), 2.0, (F_x, F_z, 0.0))
        rows.append(replace(own, law="ecoflex", height=0.2, meshes={2: (2, 3), 3: (1, 2)}))
    rows[-1] = replace(rows[-1], meshes={2: (1, 2), 4: (1,)})  # finer ones fold at half the load
    return rows


def _by_chance(count: int = 40, seed: int = 64) -> list[Case]:
    """Pads by chance: half their sinks up to 14 %, half their shear up to 45 % of t, by estimates of their stiffness.

    Those are ``mu A/t`` and, of A. N. Gent, P. B. Lindley (Proc. Inst. Mech. Eng. 173 (1959) 111), ``E A/t`` with
    ``1/E = 1/(3 mu (1 + 2 S^2)) + 1/K``, in the plane ``1/(4 mu (1 + S^2)) + 1/K``; S the loaded over the free area.
    """
    chance, rows = Random(seed), list[Case]()
    kinds = ("plane", "round", "box", "round", "mixed", "plane", "box", "round", "box", "plane")
    for number in range(count):
        kind, law = kinds[number % len(kinds)], chance.choice(["neo-hookean", "mooney-rivlin", "yeoh", "ogden", "gent"])
        nu, covers = chance.choice([0.45, 0.48, 0.49, 0.497, 0.4999]), chance.choice(["flush", "inside", "wider"])
        way = chance.choice(["pressed", "pressed", "off centre", "sheared", "sheared"])
        way = "pressed" if kind == "round" and number % 10 != 7 else way  # about their axis
        t = round(chance.uniform(1.5, 5.0), 1)
        wide = round(t * chance.uniform(1.5, 5.0), 1)
        long = {"plane": 1e3, "box": round(wide * chance.uniform(0.6, 1.0), 1)}.get(kind, wide)
        margin, press = round(t * chance.uniform(0.4, 2.5), 1), chance.uniform(0.02, 0.14)
        shear, aside = chance.uniform(0.05, 0.45), chance.uniform(0.05, 0.15)
        covers = "inside" if kind == "mixed" else covers
        along = 0.0 if kind == "plane" else margin
        pad = (round(wide + margin, 1), round(long + along, 1)) if covers == "inside" else (wide, long)
        target = (round(1.25 * wide, 1), long) if covers == "wider" else (wide, long)
        target = (target[0],) * 2 if kind == "round" else target
        bulk = 2.0 * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu))
        area, S = wide * long, wide * long / (2.0 * t * (wide + long))
        if kind in ("round", "mixed"):
            area, S = 0.25 * math.pi * wide**2, wide / (4.0 * t)
        E = 1.0 / (1.0 / (4.0 * (1.0 + S**2) if kind == "plane" else 3.0 * (1.0 + 2.0 * S**2)) + 1.0 / bulk)
        F_z = float(f"{1e-3 * MU * E * area * press:.3g}")
        F_x = float(f"{1e-3 * MU * area * shear:.3g}") if way == "sheared" else 0.0
        M = float(f"{F_z * wide * aside:.3g}") if way == "off centre" else 0.0
        meshes = SECTIONS if kind == "plane" else {2: (2, 3), 3: (1, 2)}
        milder = kind == "plane" and way != "pressed"
        name = f"by chance {number + 1}: {kind}, {covers}, {law}, nu {nu}, {way}"
        rows.append(Case(name, kind, pad, target, t, (F_x, F_z, M), law, round(bulk, 2), meshes=meshes, milder=milder))
        rows[-1] = replace(rows[-1], axial=kind == "round" and way == "pressed")
    return rows


CASES: tuple[Case, ...] = (*_layers(), *_round(), *_boxes(), *_by_chance())
