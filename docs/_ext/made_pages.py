"""Which pages are made of what stands elsewhere? Studies, schemas, modules, keys of answers; all under docs/_pages."""

from __future__ import annotations

import ast
import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import groupby, takewhile
from pathlib import Path
from typing import Any

from sits_mech.labels import described

_QUICK = ("force_calibration", "hysteresis", "paper_outlook")
_WORDS = {"N*m": "N m"}
_NUMBER = re.compile(r"_?[A-Z][A-Z_0-9]*(?:, _?[A-Z][A-Z_0-9]*)* *(?::[^=]*)?= *\(?-?[0-9.]")
_PLURALS = {"quantity": "quantities", "table": "tables", "whole number": "whole numbers", "list of": "lists of",
            "text": "texts"}


def write(path: Path, text: str) -> None:
    """Write a page where it is another one than before, so that Sphinx need not read it again."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def docstring(path: Path) -> str:
    """Return the docstring of a file."""
    return ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""


def studies(here: Path, made: Path) -> None:
    """Make a page of each study: its question, its command, its pictures and tables of a coarse run."""
    given = os.environ.get("SITS_DOCS_STUDIES")
    names = []
    for path in sorted((here.parent / "studies").glob("*.py")):
        folder = Path(given) / path.stem if given else made / "studies" / path.stem
        if not given and path.stem in _QUICK and not folder.exists():
            words = [sys.executable, str(path), "--coarse", "--output", str(folder)]
            subprocess.run(words, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        kept = made / "gallery" / path.stem
        shutil.rmtree(kept, ignore_errors=True)
        if folder.is_dir() and any(folder.glob("*.png")):
            kept.mkdir(parents=True)
            for picture in folder.glob("*.png"):
                shutil.copyfile(picture, kept / picture.name)
        write(here / "_pages" / "studies" / f"{path.stem}.md", "\n".join(_study(path, folder, kept)))
        names.append((path.stem, kept, docstring(path).partition("\n")[0]))
    write(here / "_pages" / "studies_grid.md", "\n".join(_grid(names)))
    benchmarks = sorted((here.parent / "studies" / "benchmarks").glob("*.py"))
    write(here / "_pages" / "benchmarks.md", "\n".join(_benchmarks(benchmarks)))


def _study(path: Path, folder: Path, kept: Path) -> Iterator[str]:
    """Yield the lines of a study's page."""
    question, _, rest = docstring(path).partition("\n")
    yield from (f"# {path.stem.replace('_', ' ').capitalize()}", "", f"**{question}**", "", _escaped(rest), "")
    yield from ("```console", f"$ python studies/{path.name} --output DIR", "```", "")
    pictures = sorted(kept.glob("*.png"))
    if not pictures:
        yield from ("This study draws no picture at coarse settings; run the command for its tables.", "")
        return
    yield from ("The pictures are of a run with `--coarse`: few points and loose tolerances. They show what the study",
                "draws; its results are those of the command above.", "")
    for picture in pictures:
        yield from (f"![{picture.stem.replace('_', ' ')}](/_made/gallery/{path.stem}/{picture.name})", "")


def _benchmarks(paths: list[Path]) -> Iterator[str]:
    """Yield the lines of a table of the benchmarks and what each asks."""
    yield from ("| `python -m benchmarks.` | |", "|---|---|")
    for path in paths:
        yield f"| `{path.stem}` | {_escaped(docstring(path).partition(chr(10))[0])} |"


def _grid(names: list[tuple[str, Path, str]]) -> Iterator[str]:
    """Yield the lines of the cards that lead to the studies, those with pictures first."""
    yield from ("::::{grid} 1 2 2 3", ":gutter: 2", "")
    for name, kept, question in sorted(names, key=lambda each: not each[1].exists()):
        pictures = sorted(kept.glob("*.png"))
        yield from (f":::{{grid-item-card}} {name.replace('_', ' ').capitalize()}", f":link: /_pages/studies/{name}",
                    ":link-type: doc")
        if pictures:
            yield f":img-top: /_made/gallery/{name}/{pictures[0].name}"
        yield from ("", _escaped(question), ":::", "")
    yield from ("::::", "", "```{toctree}", ":hidden:", "")
    yield from (f"/_pages/studies/{name}" for name, *_ in names)
    yield "```"


def _escaped(text: str) -> str:
    """Return a docstring's prose as Markdown: what Markdown would take for its own is kept as it is."""
    lines = [line if line.startswith("    ") or "`" in line else re.sub(r"([*_\[\]<>|$])", r"\\\1", line)
             for line in text.strip().splitlines()]
    return "\n".join(lines)


def schemas(here: Path, made: Path) -> None:
    """Write the schemas, and tables of the keys of files."""
    from sits_mech.schemas import SCHEMAS, schema_of

    for name in SCHEMAS:
        found = schema_of(name)
        write(made / "extra" / "schemas" / f"{name}.schema.json", json.dumps(found, indent=1) + "\n")
    scene = schema_of("scene")
    lines = list(_keys(scene, "Top of the file"))
    places = {"coils": "Coil", "target": "Target", "elastomer": "Elastomer", "elastomer.layers": "Layer",
              "cover": "Cover", "conductors": "Conductor", "readout": "Readout"}
    for key, part in places.items():
        title = f"`[[{key}]]`" if key in ("coils", "elastomer.layers", "conductors") else f"`[{key}]`"
        lines += _keys(scene["$defs"][part], title)
    write(here / "_pages" / "scene_keys.md", "\n".join(lines))
    asked = schema_of("requirements")
    lines = [line for part in ("loads", "require", "tolerance", "goal") for line in _part(asked, part, part)]
    write(here / "_pages" / "requirement_keys.md", "\n".join(lines))
    study = schema_of("study")
    lines = [*_keys(study, "Top of the file", 3), *_part(study, "adaptive", "Adaptive")]
    lines += [*_part(study, "then", "StageTable"), *_arguments(study)]
    write(here / "_pages" / "study_keys.md", "\n".join(lines))
    write(here / "_pages" / "bench_headings.md", "\n".join(_headings(schema_of("bench"))))
    write(here / "_pages" / "laws.md", "\n".join(_laws(scene)))


def _part(schema: dict[str, Any], key: str, part: str) -> Iterator[str]:
    """Yield a table of the keys of a file's table, with what the file's schema says of it."""
    said = schema["properties"][key]
    title = f"In `[[{key}]]`" if said.get("type") == "array" else f"In `[{key}]`"
    yield from _keys({"description": said["description"]} | schema["$defs"][part], title, 3)


def _arguments(study: dict[str, Any]) -> Iterator[str]:
    """Yield a table of the arguments of each request of a study."""
    yield from ("### Arguments of requests", "", "In `[vary]`, `[derive]`, `[fixed]`, beside keys of the scene.", "")
    yield from ("| request | arguments |", "|---|---|")
    for name in study["properties"]["request"]["enum"]:
        yield f"| `{name}` | {', '.join(f'`{key}`' for key in study['$defs'][name]['properties'])} |"
    yield ""


def _headings(bench: dict[str, Any]) -> Iterator[str]:
    """Yield a table of the headings of a bench file."""
    yield from ("| heading | is |", "|---|---|")
    columns = ((pattern[1:].partition("\\s")[0], entry) for pattern, entry in bench["patternProperties"].items())
    for meaning, group in groupby(columns, key=lambda column: column[1]["description"]):
        names = [(re.sub(r"\(.*\)", "1", name).replace("?", ""), entry["x-unit"]) for name, entry in group]
        shown = (f"`{name}`" if unit == "1" else f"`{name} [{_WORDS.get(unit, unit)}]`" for name, unit in names)
        yield f"| {', '.join(shown)} | {meaning} |"
    yield ""


def _keys(schema: dict[str, Any], title: str, level: int = 2) -> Iterator[str]:
    """Yield a table of the keys of an object."""
    yield from (f"{'#' * level} {title}", "", schema.get("description", ""), "")
    yield from ("| key | is | meaning |", "|---|---|---|")
    needed = schema.get("required", ())
    for key, entry in schema["properties"].items():
        default = entry.get("default")
        usual = f" ({json.dumps(default)})" if default not in (None, [], {}, "") else ""
        more = " (needed)" if key in needed else usual
        said = entry.get("description", "as the tables below").replace("|", "\\|")
        yield f"| `{key}`{more} | {_kind(entry)} | {said} |"
    yield ""


def _kind(entry: dict[str, Any]) -> str:
    """Return what a key holds, in words."""
    if "x-unit" in entry:
        unit = entry["x-unit"]
        return "number" if unit == "1" else f"quantity [{_WORDS.get(unit, unit)}]"
    if "enum" in entry or "const" in entry:
        return " or ".join(f"`{json.dumps(each)}`" for each in entry.get("enum", [entry.get("const")]))
    options = [each for each in entry.get("anyOf", ()) if each.get("type") != "null"]
    if options:
        return _kind(options[0])
    if "$ref" in entry:
        return {"Silicone": "name or table"}.get(entry["$ref"].rpartition("/")[2], "table")
    kind = entry.get("type")
    if kind == "array":
        inner = entry.get("items") or entry.get("prefixItems", [{}])[0]
        kind = _kind(inner) if isinstance(inner, dict) and inner else ""
        for one, many in _PLURALS.items():
            kind = kind.replace(one, many)
        return f"list of {kind}" if kind else "list"
    words = {"string": "text", "number": "number", "integer": "whole number", "boolean": "true or false"}
    return words.get(str(kind), "table")


def _laws(scene: dict[str, Any]) -> Iterator[str]:
    """Yield a table of the laws of silicones and their constants."""
    yield from ("| `law` | constants beside `bulk_modulus` |", "|---|---|")
    for each in scene["$defs"]["Silicone"]["anyOf"][1:-1]:
        names = [key for key in each.get("required", ()) if key not in ("law", "bulk_modulus")]
        yield f"| `{each['title']}` | {', '.join(f'`{name}`' for name in names)} |"


_ROOMS = {
    "silicone": "Silicone: laws, stability, rate and history",
    "mechanics": "Mechanics: wrench to pose",
    "magnetics": "Magnetics: pose to impedance",
    "maps": "Maps: smooth functions through solved points",
    "readout": "Readout: impedance to force",
    "chain": "Chain: the two halves joined",
    "analysis": "Analysis: what is asked of a sensor, and what tests and benches tell of it",
    "synthesis": "Synthesis: a design for requirements",
}


def modules(here: Path) -> None:
    """Make a page a room of what its files open with: forms, conditions, formulas, sources, ranges."""
    for room, title in _ROOMS.items():
        lines = [f"# {title}", "", "What each file opens with, as it stands in the source.", ""]
        for path in sorted((here.parent / "sits_mech" / room).rglob("*.py")):
            text = docstring(path)
            if text and path.name != "__init__.py":
                lines += [f"## `{path.relative_to(here.parent).as_posix()}`", "", "```text", text, "```", ""]
        write(here / "_pages" / "modules" / f"{room}.md", "\n".join(lines))


def numbers(here: Path) -> None:
    """Make the page of the numbers that decide: a table a room, each number with its words as they stand beside it."""
    lines: list[str] = []
    root = here.parent / "sits_mech"
    for room, paths in groupby(sorted(root.rglob("*.py")), key=lambda path: path.relative_to(root).parts[0]):
        rows = [f"| `{name}` | `{value}` | {_escaped(words)} | `{path.relative_to(root).as_posix()}` |"
                for path in paths for name, value, words in numbers_of(path.read_text(encoding="utf-8"))]
        if rows:
            lines += ["", f"## `{room}`", "", "| name | value | what it is | file |", "|---|---|---|---|", *rows]
    write(here / "_pages" / "numbers.md", "\n".join(lines) + "\n")


def numbers_of(text: str) -> Iterator[tuple[str, str, str]]:
    """Yield name, value and words of each named number of a file; words stand behind it, below it or above it."""
    lines, body = text.splitlines(), ast.parse(text).body
    for node, after in zip(body, [*body[1:], None], strict=True):
        if not isinstance(node, ast.Assign | ast.AnnAssign) or not _NUMBER.match(lines[node.lineno - 1]):
            continue
        target = node.target if isinstance(node, ast.AnnAssign) else node.targets[0]
        above = takewhile(lambda line: line.startswith("#"), reversed(lines[: node.lineno - 1]))
        words = [line.lstrip("# ") for line in reversed(list(above))]
        words += [lines[node.end_lineno - 1].partition("  # ")[2]]
        if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant):
            words += str(after.value.value).splitlines()
        value = " ".join((ast.get_source_segment(text, node.value) or "").split())
        yield ast.unparse(target).strip("()"), value, " ".join(filter(None, words))


def left_out(here: Path) -> None:
    """Make the table of what each model leaves out of a load on a pad with ends, by its own description."""
    from sits_mech.chain.models import MAGNETICS, MECHANICS
    from sits_mech.description import Question
    from sits_mech.quantities import Wrench
    from sits_mech.report.left_out import RELATIVE, reason, size_text
    from sits_mech.scene.sensor import load_sensor

    load, lines = (Wrench(F_z=0.2),), ["| model | leaves out | size | of |", "|---|---|---|---|"]
    spiral = load_sensor("biorob2018", [f'coils.{name}.winding="spiral"' for name in ("C1", "C2")])
    for known in (MECHANICS, MAGNETICS):
        for name, model in known.items():
            every = model.omissions(spiral, Question(loads=load))
            counted = [item for item in every if item.counts and item.size != 0.0]
            lines += [
                f"| `{name}` | {item.kind}: {reason(item)} | {size_text(item)} | {RELATIVE[item.relative_to]} |"
                for item in counted
            ] or [f"| `{name}` | nothing that counts | | |"]
    head = "Under 0.2 N on `biorob2018`, with spiral windings, as estimated before anything is solved:"
    write(here / "_pages" / "left_out.md", "\n".join([head, "", *lines]) + "\n")


def answer_keys(here: Path, made: Path) -> None:
    """Make the page of the keys that answers have: those of real answers, each with its meaning.

    Raises
    ------
    ValueError
        For a key of an answer that docs/reference/json_keys.toml does not explain, or one there that no answer has.
    """
    asked = tomllib.loads((here / "reference" / "json_keys.toml").read_text(encoding="utf-8"))
    meanings, used, missing = asked["meaning"], set(), []
    lines: list[str] = []
    with ThreadPoolExecutor(max_workers=2) as pool:
        answers = list(pool.map(lambda command: _answer(command, made), asked["command"].values()))
    for name, answer in zip(asked["command"], answers, strict=True):
        lines += ["", f"## {name}", "", f"`{asked['command'][name]}`", "", "| key | meaning |", "|---|---|"]
        for key in dict.fromkeys(_short(key, asked["short"]) for key in answer):
            parts = key.split(".")
            tails = (".".join(parts[k:]) for k in range(len(parts)))
            own = next((tail for tail in tails if tail in meanings), "")
            said = meanings[own] if own else described(parts[-1])
            used |= {own} - {""}
            if said:
                lines.append(f"| `{key}` | {said} |")
            else:
                missing.append(f"{name}: {key}")
    if missing or set(meanings) - used:
        idle = sorted(set(meanings) - used)
        raise ValueError(f"docs/reference/json_keys.toml: must explain {missing}; explains {idle}, which no answer has")
    write(here / "_pages" / "answer_keys.md", "\n".join(lines) + "\n")


def _short(key: str, patterns: dict[str, str]) -> str:
    """Return a key with one word for what has many names: forces, coils, figures."""
    for pattern, word in patterns.items():
        key = re.sub(pattern, word, key)
    return key


def _answer(command: str, made: Path) -> list[str]:
    """Return the dotted keys of a command's JSON, those of lists by []; kept from build to build."""
    from executed import package_stamp

    stamp = package_stamp(command, Path(__file__).parents[2] / "sits_mech")
    kept = made / "answers" / f"{stamp}.json"
    if not kept.exists():
        done = subprocess.run(["bash", "-c", command], cwd=made, capture_output=True, text=True)
        if done.returncode not in (0, 3, 4):
            raise ValueError(f"{command}: ended with {done.returncode}: {done.stderr}")
        write(kept, done.stdout)
    return list(dict.fromkeys(_dotted(json.loads(kept.read_text(encoding="utf-8")))))


def _dotted(record: Any, before: str = "") -> Iterator[str]:
    """Yield the dotted names of what is in a record."""
    if isinstance(record, dict) and record:
        for key, item in record.items():
            yield from _dotted(item, f"{before}.{key}" if before else key)
    elif isinstance(record, list) and record and isinstance(record[0], dict):
        for item in record:
            yield from _dotted(item, f"{before}[]")
    elif before:
        yield before
