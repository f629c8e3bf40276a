"""Does the package hold to its own order? Imports point downwards, the top is small, nothing talks by itself."""

import ast
import io
import os
import re
import subprocess
import sys
import tokenize
from collections.abc import Sequence
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "sits_mech"
FILES = sorted(PACKAGE.rglob("*.py"))

# a file or folder may import lower ranks, and siblings of its own folder (of its own rank, at the top level)
RANKS = {
    **dict.fromkeys(
        ("version", "threads", "plugins", "memory", "disk_cache", "units", "inputs", "arguments", "quantities",
         "rotations", "labels", "notes", "status"), 0
    ),
    **dict.fromkeys(("silicone", "maps"), 1),
    "readout": 2,
    "scene": 3,
    **dict.fromkeys(("boards", "cases", "description", "store"), 4),
    "geometry": 5,
    **dict.fromkeys(("mechanics", "magnetics"), 6),
    "chain": 7,
    "analysis": 8,
    **dict.fromkeys(("batch", "synthesis"), 9),
    **dict.fromkeys(("report", "schemas"), 10),
    **dict.fromkeys(("export", "studio"), 11),
    **dict.fromkeys(("cli", "__init__"), 12),
    "__main__": 13,
}
PLUGGED = ("analysis", "boards", "batch", "synthesis", "report", "schemas", "export", "studio", "cli")
"""Rooms around the core, which stands without them: a scene to its calibration and the inverse."""
SILENT = {
    tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENCODING,
    tokenize.ENDMARKER,
}
MOST_TOKENS = 3000
LARGE = {  # to be divided; no others
    "export/twin/twin.py",
    "report/pictures/drawing.py",
    "synthesis/solved/solve.py",
}
TALK = {"print", "breakpoint", "input"}

# what Windows lacks, and macOS some of it; of signals all but PORTABLE
POSIX = {
    "fcntl", "grp", "posix", "pty", "pwd", "resource", "syslog", "termios", "tty", "signal.alarm", "signal.setitimer",
    *(f"os.{name}" for name in (
        "chown", "fork", "getegid", "geteuid", "getgid", "getloadavg", "getpgid", "getuid", "killpg", "mkfifo", "nice",
        "posix_spawn", "sched_getaffinity", "sched_setaffinity", "setpgid", "setsid", "sysconf", "uname", "wait4",
    )),
}
PORTABLE = {"signal.SIGINT", "signal.SIGTERM", "signal.SIG_DFL", "signal.SIG_IGN"}

# files without tests of their own at the mirrored place, and where they are tested instead
UNMIRRORED = {
    "mechanics/cells/pressed.py": "tests/mechanics/cells/test_targets.py: a touch as by another code, at finite strain",
    "__main__.py": "tests/cli/test_main.py: the package is the command",
    "magnetics/space/plates.py": "tests/magnetics/space/test_near.py: plates of scenes, near, far and at rest",
    "magnetics/space/boxes.py": "tests/magnetics/test_sheets_outline.py: boxes beside prisms of the same shape",
    "magnetics/permeable/skin.py": "tests/magnetics/permeable/test_plates.py: plates of all skin depths",
    "magnetics/permeable/shell_plans.py": "tests/magnetics/permeable/test_plates.py: discs, squares, few cells",
    "analysis/readings/codes.py": "tests/analysis/readings/test_bench.py: codes back to L, and their slopes",
    "analysis/bench/force_maps.py": "tests/analysis/bench/test_loaded.py: maps that benches follow",
    "analysis/material/uniaxial.py": "tests/silicone/test_uniaxial.py: every law, with rate and softening",
    "analysis/built/prior.py": "tests/analysis/built/test_adaptation.py: what is known before, and after a tare",
    "boards/copper.py": "tests/boards/test_kicad.py: what is read of a board",
    "batch/requests.py": "tests/batch/test_run.py: every request",
    "batch/tables.py": "tests/batch/test_run.py: calibrations of a sweep, read back",
    **dict.fromkeys(
        ("batch/studies/asked.py", "batch/studies/written.py"), "tests/batch/test_run.py: studies read and refused"
    ),
    **dict.fromkeys(
        (f"cli/{name}.py" for name in ("console", "grids", "inform", "options", "products", "read", "solve")),
        "tests/cli/test_main.py: through the command line",
    ),
    "cli/readings.py": "tests/analysis/readings/test_bench.py: readings of invert, given and refused",
    "analysis/histories/interpolant.py": "tests/analysis/histories/test_response.py: values and errors between times",
    "inputs.py": "tests/scene/test_sensor.py: what files are refused for; tests/scene/test_bounds.py: kinds of keys",
    "synthesis/solved/loads.py": "tests/synthesis/solved/test_figures.py: polynomials and their slopes",
    "synthesis/required/written.py": "tests/synthesis/required/test_requirements.py: files read and refused",
    **dict.fromkeys(
        (f"synthesis/{name}.py" for name in ("answer", "solved/answered", "around")),
        "tests/synthesis/test_run.py: what comes of a search",
    ),
    "schemas/files.py": "tests/schemas/test_study.py: studies; test_requirements.py and test_bench.py beside it",
    "export/calibrations.py": "tests/test_public_names.py: examples of each; tests/cli/test_built.py: as commands do",
    "report/written.py": "tests/report/test_folder.py: what a calibration leaves",
    "report/envelope.py": "tests/analysis/test_envelope.py: record, table and picture",
    "studio/page.py": "tests/studio/test_studio.py: in a browser",
    "export/fixed_point.py": "tests/export/test_firmware.py: the header made of its integers",
    "export/twin/arrays.py": "tests/export/twin/test_folder.py: what is in the folder",
    **dict.fromkeys(
        ("export/formats.py", "export/source.py"), "tests/export/test_tables.py: every format goes through them"
    ),
    **dict.fromkeys(
        ("geometry/outline.py", "geometry/sheet_plan.py"), "tests/magnetics/test_sheets_outline.py: the sheets on them"
    ),
    "scene/parts/turns.py": "tests/geometry/test_tracks.py: turns of every shape",
    "geometry/plates.py": "tests/magnetics/space/test_neighbours.py: conductors made of them",
    "magnetics/section/elements.py": "tests/magnetics/test_field_parts.py: the field that it solves",
    "magnetics/axis/disc.py": "tests/magnetics/test_rings.py: its impedance",
    "magnetics/axis/coaxial.py": "tests/magnetics/test_axis_fem.py: scenes and poses off the axis",
    "magnetics/space/coupling.py": "tests/magnetics/test_sheets.py: fluxes in the sheets",
    "magnetics/space/loops.py": "tests/magnetics/test_sheets_outline.py: its loops",
    "magnetics/space/classes.py": "tests/magnetics/space/test_modes.py: plates by these matrices, against closed forms",
    "report/pictures/pad.py": "tests/mechanics/test_block.py: sections of its pads for pictures",
    "mechanics/element/mesh.py": "tests/mechanics/element/test_kernel.py: the elements on it",
    "mechanics/element/target.py": "tests/mechanics/element/test_assembly.py: the rigid target's derivatives",
    **dict.fromkeys(
        (f"mechanics/faces/{name}.py" for name in ("face_contact", "surface")),
        "tests/mechanics/faces/test_contact.py: the contact of these faces",
    ),
    "mechanics/loads.py": "tests/chain/test_simulate.py: grids of loads",
    **dict.fromkeys(
        (f"chain/{name}.py" for name in ("omitted/mechanical", "rests")),
        "tests/chain/test_simulate.py: whole answers",
    ),
    "mechanics/pad/planar.py": "tests/mechanics/test_layer.py: the layers on these meshes converge",
    "mechanics/pad/solid.py": "tests/mechanics/test_block.py: the pads on these meshes converge",
    **dict.fromkeys(
        (f"mechanics/equilibrium/{name}.py" for name in ("newton", "linearisation")),
        "tests/mechanics/test_layer.py: every rest is found by them",
    ),
    "mechanics/equilibrium/path.py": "tests/mechanics/equilibrium/test_limit_point.py: paths to limits, and beyond",
    "geometry/meshing/cells.py": "tests/geometry/meshing/test_formats.py: cells of every kind and order",
    "geometry/meshing/store.py": "tests/mechanics/pad/test_user.py: meshes read and refused",
    "readout/front_end.py": "tests/readout/test_converter.py: settings of the converter",
    "report/page/parts.py": "tests/report/page/test_html.py: the page's sections",
    "report/plots/measured.py": "tests/analysis/built/test_comparison.py: compare draws and prints it",
    "report/pictures/request.py": "tests/report/pictures/test_spatial.py: requests drawn and refused",
    "report/pictures/section.py": "tests/report/plots/test_curves.py: sections drawn",
    "report/pictures/style.py": "tests/report/plots/test_curves.py: figures of the style, written",
    **dict.fromkeys(
        ("report/plots/design.py", "report/tables/design.py"), "tests/report/test_design.py: an answer's folder"
    ),
    "report/tables/built.py": "tests/cli/test_built.py: adapt and lot print and draw it",
    "report/tables/drift.py": "tests/cli/test_main.py: simulate over temperature",
    "report/tables/cases.py": "tests/batch/test_run.py: sweep prints it",
    "report/tables/loops.py": "tests/cli/test_main.py: cycle prints it",
    "report/tables/readings.py": "tests/analysis/readings/test_bench.py: invert and converter print it",
    **dict.fromkeys(
        (f"scene/{name}.py" for name in ("materials", "parts/metal", "parts/readout")),
        "tests/scene/test_sensor.py: whole scenes",
    ),
    **dict.fromkeys(
        (f"silicone/laws/{name}.py" for name in ("gent", "law", "mooney_rivlin", "neo_hookean", "ogden", "yeoh")),
        "tests/silicone/laws/test_laws.py: every law by the same tests",
    ),
    "analysis/material/least_squares.py": "tests/analysis/material/test_fitted.py: the fits that it makes",
    "analysis/material/points.py": "tests/analysis/material/test_fitted.py: the fits to them",
    "mechanics/levels/words.py": "tests/mechanics/equilibrium/test_failure.py: what is said of paths that ended",
    "notes.py": "tests/report/test_notes.py: notes and what is said of them",
    "version.py": "tests/report/test_folder.py: a calibration of another version is refused",
}


def tokens_of(text: str) -> int:
    """Count the tokens of Python's code, without comments, line ends and indents."""
    return sum(each.type not in SILENT for each in tokenize.generate_tokens(io.StringIO(text).readline))


def room(module: str) -> str:
    """Return the room of a dotted module name: the part after ``sits_mech``."""
    steps = module.split(".")
    return steps[1] if len(steps) > 1 else "__init__"


def imported(nodes: Sequence[ast.AST], package: str) -> list[tuple[int, str]]:
    """Return line and dotted name of every import of our own, wherever in the file it stands."""
    found = []
    for node in nodes:
        if isinstance(node, ast.Import):
            found += [(node.lineno, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            module = ".".join([*base, *([node.module] if node.module else [])])
            names = [f"{module}.{alias.name}" for alias in node.names] if module == "sits_mech" else [module]
            found += [(node.lineno, name) for name in names]
        elif isinstance(node, ast.Call) and getattr(node.func, "attr", getattr(node.func, "id", "")) in (
            "import_module",
            "__import__",
        ):
            texts = [arg.value for arg in node.args if isinstance(arg, ast.Constant) and isinstance(arg.value, str)]
            found += [(node.lineno, text) for text in texts]
    return [(line, name) for line, name in found if name.split(".")[0] == "sits_mech"]


@cache
def nodes_of(path: Path) -> list[ast.AST]:
    """Return what a file says, parsed once: the module and all below it."""
    return parsed(path.read_text(encoding="utf-8"))


def parsed(source: str) -> list[ast.AST]:
    """Return a module and all nodes below it."""
    return list(ast.walk(ast.parse(source)))


def violations(nodes: Sequence[ast.AST], module: str) -> list[str]:
    """Return the imports of a module that do not point downwards or sideways."""
    package = module.rsplit(".", 1)[0]
    own, rank = room(module), RANKS[room(module)]
    top_level = module.count(".") <= 1
    wrong = []
    for line, name in imported(nodes, package):
        other = room(name)
        if other not in RANKS:
            wrong.append(f"line {line}: {name} has no rank in this test")
            continue
        sibling = other == own or (top_level and RANKS[other] == rank and (PACKAGE / f"{other}.py").exists())
        if not (RANKS[other] < rank or sibling):
            wrong.append(f"line {line}: {module} (rank {rank}) imports {name} (rank {RANKS[other]})")
    return wrong


def dotted(path: Path) -> str:
    """Return the module name of a file."""
    return ".".join(path.relative_to(ROOT).with_suffix("").parts)


def test_imports_point_downwards() -> None:
    """By the order of rooms in the design: nouns, meshes and maps, geometry, physics, chain, readers, the top."""
    assert {dotted(path): wrong for path in FILES if (wrong := violations(nodes_of(path), dotted(path)))} == {}


def circle(sources: dict[str, list[ast.AST]]) -> list[str]:
    """Return modules of which each imports the next one and the last the first, wherever in a file; none if none do."""
    graph: dict[str, set[str]] = {}
    for module, nodes in sources.items():
        names = {f"{node.module}.{alias.name}" for node in nodes if isinstance(node, ast.ImportFrom) and node.module
                 for alias in node.names} | {name for _, name in imported(nodes, module.rsplit(".", 1)[0])}
        graph[module] = (names & set(sources)) - {module}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def test_files_import_each_other_in_no_circle() -> None:
    """Within a room as well arrows run down, those under TYPE_CHECKING and within functions too; the rule sees each."""
    def arrow(name: str) -> list[ast.AST]:
        return parsed(f"if TYPE_CHECKING:\n    from sits_mech.{name} import x\ndef f():\n    import sits_mech.{name}")

    assert circle({"sits_mech.a": arrow("b"), "sits_mech.b": arrow("c"), "sits_mech.c": arrow("a")})
    assert circle({"sits_mech.a": arrow("b"), "sits_mech.b": arrow("c")}) == []
    assert circle({dotted(path).removesuffix(".__init__"): nodes_of(path) for path in FILES}) == []


@pytest.mark.parametrize(("room", "order"), [
    ("mechanics", ["element", "faces", "equilibrium", "levels", "pad"]), ("synthesis", ["required", "solved"]),
])
def test_folders_of_a_room_stand_in_order(room: str, order: list[str]) -> None:
    """A folder there imports those before it and itself."""
    for rank, folder in enumerate(order):
        above = tuple(f"sits_mech.{room}.{other}." for other in order[rank + 1 :])
        for path in sorted((PACKAGE / room / folder).glob("*.py")):
            names = [name for _, name in imported(nodes_of(path), dotted(path).rsplit(".", 1)[0])]
            assert [name for name in names if name.startswith(above)] == [], path


def test_the_import_rule_sees_every_kind_of_import() -> None:
    """The rule itself goes red: inside functions, under TYPE_CHECKING, relative, dynamic."""
    bad = [
        "def f():\n    from sits_mech.chain import simulate",
        "if TYPE_CHECKING:\n    from sits_mech.magnetics.bars import planar_bars",
        "from ..magnetics import bars",
        "from sits_mech import chain",
        "import importlib\nimportlib.import_module('sits_mech.report.tables.solves.solves.solves.solves')",
    ]
    for source in bad:
        assert violations(parsed(source), "sits_mech.mechanics.layer"), source
    good = "import numpy\nfrom .strip import x\nfrom sits_mech.scene.files import sensor"
    assert violations(parsed(good), "sits_mech.mechanics.layer") == []


def forbidden(nodes: Sequence[ast.AST]) -> list[str]:
    """Return what of a module talks, asserts, catches all or stands for what is not there."""
    wrong = []
    for node in nodes:
        match node:
            case ast.Call(func=ast.Name(id=name)) if name in TALK:
                wrong.append(f"line {node.lineno}: {name}")
            case ast.Assert():
                wrong.append(f"line {node.lineno}: assert")
            case ast.ExceptHandler(type=None):
                wrong.append(f"line {node.lineno}: bare except")
            case ast.Name(id="NotImplementedError"):
                wrong.append(f"line {node.lineno}: NotImplementedError")
    return wrong


def test_package_neither_prints_nor_asserts() -> None:
    """Results are returned and errors raised; `cli` alone writes, by its console; a bare except hides everything."""
    bad = "print(1)", "assert a", "try:\n    a\nexcept:\n    b", "raise NotImplementedError"
    assert [source for source in bad if not forbidden(parsed(source))] == []
    assert {dotted(path): wrong for path in FILES if (wrong := forbidden(nodes_of(path)))} == {}


SPEAKING = ("report", "export", "studio", "cli", "boards")
"""Rooms that make or read words for a person; in all others no decision reads a sentence."""
SAID = re.compile(r"(?:^|_)(?:notes?|reasons?|messages?|sentences?)$")
SEARCHES = ("startswith", "endswith", "find", "rfind", "index", "partition", "rpartition", "count", "removeprefix",
            "removesuffix")


def _texts(node: ast.AST) -> list[str]:
    """Return the constant texts that a side of a comparison is, alone or in a tuple, list or set."""
    parts = node.elts if isinstance(node, ast.Tuple | ast.List | ast.Set) else [node]
    return [part.value for part in parts if isinstance(part, ast.Constant) and isinstance(part.value, str)]


def _name(node: ast.AST) -> str:
    """Return the name of a variable, an attribute, or an item by a name; "" of anything else."""
    match node:
        case ast.Name(id=name) | ast.Attribute(attr=name) | ast.Subscript(slice=ast.Constant(value=str(name))):
            return name
        case ast.Call(func=ast.Name(id="str"), args=[inner]) | ast.Call(func=ast.Attribute(value=inner, attr="item")):
            return _name(inner)
    return ""


def _patterns(nodes: Sequence[ast.AST]) -> dict[str, str]:
    """Return the constant texts that names of a module stand for."""
    return {
        target.id: node.value.value for node in nodes if isinstance(node, ast.Assign) for target in node.targets
        if isinstance(target, ast.Name) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
    }


def decided_by_sentences(nodes: Sequence[ast.AST]) -> list[str]:
    """Return where a module compares with or searches a sentence, or searches what is said of an answer for a text.

    A sentence is a constant text with a space within it, also by the name of a constant of the module.
    """
    known, wrong = _patterns(nodes), []

    def texts(node: ast.AST) -> list[str]:
        return [known[node.id]] if isinstance(node, ast.Name) and node.id in known else _texts(node)

    for node in nodes:
        match node:
            case ast.Compare(left=left, ops=ops, comparators=others):
                for op, one, other in zip(ops, (left, *others), others, strict=False):
                    if isinstance(op, ast.In | ast.NotIn):
                        found = texts(one) + texts(other)
                        named = bool(SAID.search(_name(other))) and bool(texts(one))
                    elif isinstance(op, ast.Eq | ast.NotEq):
                        found = texts(one) + texts(other)
                        named = any(SAID.search(_name(a)) and any(texts(b)) for a, b in ((one, other), (other, one)))
                    else:
                        continue
                    if named or any(" " in text.strip() for text in found):
                        wrong.append(f"line {node.lineno}: compared with {found}")
            case ast.Call(func=ast.Attribute(value=value, attr=attr), args=[first, *_]) if attr in SEARCHES:
                found = texts(first)
                if any(" " in text.strip() for text in found) or (SAID.search(_name(value)) and found):
                    wrong.append(f"line {node.lineno}: {attr} of {found}")
    return wrong


def test_no_decision_reads_a_sentence() -> None:
    """What is said of an answer is kinds with numbers: words change without a number's changing; the rule sees each."""
    bad = (
        'if "frictionless contact" in note: pass', 'any("touches" in note for note in notes)', 'x = "long" in notes',
        'if text == "no largest load": pass', 'reason.startswith("stretch")', 'each.report.notes.index("a")',
        'one.partition(" end at ")', 'x = row["reason"].item() == "lost"', '_FOLDED = "pass through"\n_FOLDED in said',
        'x = name in ("a b", "c")', 'str(row["notes"]).find("a")', 'STRETCH = "beyond"\nend.reason.startswith(STRETCH)',
        'x = "a" not in error.message', "message != 'lost'",
    )
    assert [source for source in bad if not decided_by_sentences(parsed(source))] == []
    good = 'note.kind is NoteKind.A', 'x = name in ("a", "b")', 'reason == PathEnd.LOST', '" ".join(a)', 'reason != ""'
    assert [source for source in good if decided_by_sentences(parsed(source))] == []
    files = [path for path in FILES if path.relative_to(PACKAGE).parts[0] not in SPEAKING]
    assert {dotted(path): wrong for path in files if (wrong := decided_by_sentences(nodes_of(path)))} == {}


def test_files_stay_readable() -> None:
    """A file answers one question: said in its docstring, in at most 3000 tokens but for those that are listed."""
    tokens = {path.relative_to(PACKAGE).as_posix(): tokens_of(path.read_text(encoding="utf-8")) for path in FILES}
    assert {name for name, count in tokens.items() if count > MOST_TOKENS} == LARGE
    modules = {path: nodes_of(path)[0] for path in FILES}
    assert [path for path, module in modules.items() if module.body and not ast.get_docstring(module)] == []


def test_files_that_docstrings_name_are_there() -> None:
    """Beside the file, in its room, or from the root of the package or of the studies on."""
    gone = []
    for path in FILES:
        own = path.relative_to(PACKAGE)
        places = path.parent, PACKAGE / own.parts[0], PACKAGE, ROOT, ROOT / "studies"
        for node in nodes_of(path):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
                for name in re.findall(r"(?<![\w/.])(?:[a-z_0-9]+/)*[a-z_0-9]+\.py\b", ast.get_docstring(node) or ""):
                    gone += [] if any((place / name).exists() for place in places) else [f"{own}: {name}"]
    assert gone == []


def test_files_have_their_tests() -> None:
    """Each at the mirrored place, or in the one list, which holds no others; what the list names is there."""
    files = {path.relative_to(PACKAGE).as_posix(): path for path in FILES if path.name != "__init__.py"}
    mirrors = {name: ROOT / "tests" / Path(name).with_name(f"test_{path.name}") for name, path in files.items()}
    missing = {name for name, mirror in mirrors.items() if not mirror.exists()}
    assert sorted(missing - set(UNMIRRORED)) == [], "no tests, and no reason"
    assert sorted(set(UNMIRRORED) - missing) == [], "listed, but mirrored or gone"
    assert [reason for reason in UNMIRRORED.values() if not (ROOT / reason.partition(":")[0]).is_file()] == []


def _python(code: str) -> subprocess.CompletedProcess[str]:
    """Run code in an interpreter of its own."""
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, timeout=60)


def test_import_is_quiet_and_small() -> None:
    """`import sits_mech` says nothing, shows at most 38 names, and leaves heavy leaves alone.

    Twenty-four, `show` for notebooks, `open_sweep` for tables that grow and `terminal_calibration` for readings at
    terminals, five for what the shell does with a calibration's folder, four for cells, one for depths;
    `test_public_names.py` asks for each.
    """
    heavy = "{'matplotlib', 'pyvista', 'vtk', 'gmsh', 'pygmsh', 'distributed', 'pint'}"
    done = _python(
        "import sys, sits_mech\n"
        f"found = {heavy} & set(sys.modules)\n"
        "assert not found, found\n"
        "names = [name for name in dir(sits_mech) if not name.startswith('_')]\n"
        "names = getattr(sits_mech, '__all__', names)\n"
        "assert len(names) <= 38, names\n"
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_the_core_stands_alone() -> None:
    """Without any of the rooms around it a scene is calibrated and a reading inverted."""
    done = _python(
        "import sys\n"
        f"sys.modules |= dict.fromkeys(['sits_mech.' + room for room in {PLUGGED}])  # to import one raises\n"
        "from sits_mech.chain.calibrate import calibrate\n"
        "from sits_mech.chain.plans.plan import plan\n"
        "from sits_mech.chain.simulate import simulate\n"
        "from sits_mech.quantities import Wrench\n"
        "from sits_mech.readout.calibration import calibration\n"
        "from sits_mech.scene.sensor import load_sensor\n"
        "sensor, models = load_sensor('biorob2018'), {'mechanics': 'linear', 'magnetics': 'planar', 'tolerance': 0.1}\n"
        "plan(sensor, [Wrench(0.1, 0.5)])\n"
        "simulate(sensor, Wrench(0.1, 0.5), **models)\n"
        "data = calibrate(sensor, F_x=[-0.2, 0.0, 0.2], F_z=[0.0, 0.5, 1.0], **models)\n"
        "known = calibration(data, [2e-6, 2e-6])\n"
        "forces = known.inverse(known.forward([0.1, 0.4])).forces\n"
        "assert abs(forces - [0.1, 0.4]).max() < 1e-3, forces\n"
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_nothing_reads_outside_the_project() -> None:
    """The package knows no absolute path."""
    for path in FILES:
        for node in nodes_of(path):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                assert not node.value.startswith(("/work", "/home", "/root", "/tmp", "../shared")), path


def posix_only(nodes: Sequence[ast.AST]) -> list[str]:
    """Return what of a module's source is not on every system: modules, functions, signals, paths."""
    names = []
    for node in nodes:
        match node:
            case ast.Import():
                names += [alias.name for alias in node.names]
            case ast.ImportFrom(module=str(module)):
                names += [module, *(f"{module}.{alias.name}" for alias in node.names)]
            case ast.Attribute(value=ast.Name(id=module)):
                names.append(f"{module}.{node.attr}")
            case ast.Constant(value=str(text)) if text.startswith(("/dev", "/etc", "/proc", "/sys", "/tmp", "/usr")):
                names.append(text)
    return [name for name in names if name in POSIX or name.startswith(("/", "signal.SIG")) and name not in PORTABLE]


def test_one_file_knows_the_system() -> None:
    """Paths such as /dev/stdout are known where files are written, peaks of memory in one; nothing else of a system.

    But that one may hold signals back, where workers start: asked for first, since Windows has none to hold.
    """
    knowing = ["sits_mech.batch.executors", "sits_mech.memory", "sits_mech.scene.files"]
    assert [dotted(path) for path in FILES if posix_only(nodes_of(path))] == knowing
    bad = "import fcntl", "from os import fork", "os.killpg(1, 9)", "signal.SIGALRM", "Path('/proc/cpuinfo')"
    assert [source for source in bad if not posix_only(parsed(source))] == []
    assert posix_only(parsed("import os, signal\nos.replace(a, b)\nsignal.signal(signal.SIGINT, signal.SIG_IGN)")) == []
