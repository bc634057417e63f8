"""Compares the guide's options with those of the programs, and the names in its chapters with those in written files.

Every written name must be described, and every described name must be written. The files are the output of the
commands in the guide's pages.
"""
import csv
import json
import re
import sqlite3
import subprocess
import tomllib


def described(guide, page, heading, sometimes=False):
    """Names in the first cells of the tables under a heading. `sometimes` selects names that are not always written."""
    text = (guide / page).read_text()
    start = re.search(rf"^#+ {re.escape(heading)}$", text, re.M)
    if not start:
        raise KeyError(f"{page} has no heading {heading}")
    section = re.split(r"^#", text[start.end():], maxsplit=1, flags=re.M)[0]
    names = []
    for line in section.splitlines():
        cells = line.split(" | ")
        if line.startswith("| `") and (len(cells) < 2 or cells[1].startswith("sometimes:") == sometimes):
            names += re.findall(r"`([^`]+)`", cells[0])
    return names


def fields(value, stop=(), prefix=""):
    """Dotted names of an object's fields and of objects in its lists. Does not descend into fields in `stop`."""
    names = []
    for key, inner in value.items():
        name = prefix + key
        objects = [inner] if isinstance(inner, dict) else [o for o in inner if isinstance(o, dict)] if isinstance(inner, list) else []
        if objects and name not in stop:
            names += [n for one in objects for n in fields(one, stop, name + ".")]
        else:
            names.append(name)
    return names


def columns(file):
    with open(file, newline="") as rows:
        return next(csv.reader(rows))


def written(pages, source):
    """The names that each heading of each chapter must describe: (chapter, heading, names)."""
    research, trainee, instructor = pages / "researcher.md", pages / "trainee.md", pages / "instructor.md"
    store = research / "home/.local/share/stylet/records"
    with sqlite3.connect(f"file:{store / 'store.sqlite'}?mode=ro", uri=True) as index:
        tables = [name for (name,) in index.execute("SELECT name FROM sqlite_schema WHERE type = 'table' AND name NOT LIKE 'sqlite_%'")]
        for table in tables:
            yield "records.md", f"`{table}`", [row[1] for row in index.execute(f"PRAGMA table_info({table})")]
    centre = (source / "app/records/centre.cpp").read_text()
    for table, body in re.findall(r"CREATE TABLE stylet\.(\w+) \((.*?)\n\);", centre, re.S):
        added = "".join(re.findall(rf"ALTER TABLE stylet\.{table} (.*?);", centre, re.S))
        names = re.findall(r"^    ([a-z]\w*) ", body, re.M) + re.findall(r"ADD COLUMN (\w+)", added)
        yield "records.md", f"`stylet.{table}`", names

    attempt = next((store / "attempts").iterdir())
    spreads = [f"frame_ms.{n}" for n in ("whole", "opaque", "volume")] + [f"visuo_haptic.{n}" for n in ("lead_ms", "offset_mm", "offset_deg", "ahead_ms")]
    yield "records.md", "`summary.json`", fields(json.loads((attempt / "summary.json").read_text()), [*spreads, "skips"])
    yield "records.md", "`record.json`", fields(json.loads((attempt / "record/record.json").read_text()), ["result"])
    export = next((instructor / "backup/attempts").iterdir())
    yield "records.md", "`attempt.json`", fields(json.loads((export / "attempt.json").read_text()))
    yield "records.md", "`force-depth.csv`", columns(attempt / "force-depth.csv")
    yield "records.md", "`frames.csv`", columns(pages / "developer.md/recipes/build/straight/record/frames.csv")
    yield "records.md", "`course.csv`", columns(trainee / "debrief/course.csv")

    yield "formats.md", "`hand.csv`", columns(research / "hand.csv")
    patient = research / "truth"
    yield "formats.md", "`patient.toml`", fields(tomllib.loads((patient / "patient.toml").read_text()))
    yield "formats.md", "`verdict.json`", fields(json.loads((research / "built/verdict.json").read_text()))
    yield "formats.md", "`paths.json`", fields(json.loads((research / "study/truth/paths.json").read_text()))

    study = json.loads((research / "study/summary.json").read_text())
    one = study["patients"][0]
    yield "metrics.md", "Patients and all: `summary.json`", list(one)
    yield "metrics.md", "A spread", list(one["rmse_n"])
    yield "metrics.md", "An entry of `tissues`", list(one["tissues"][0])
    yield "metrics.md", "An entry of `causes`", list(one["causes"][0])
    tissue = re.compile(r"^(" + "|".join(re.escape(t["tissue"]) for t in one["tissues"]) + ")_(?=(mean|hausdorff|event)_mm$)")
    yield "metrics.md", "A path: `paths.csv`", [tissue.sub("*_", name) for name in columns(research / "study/truth/paths.csv")]


def unknown_options(guide, source, programs):
    """A line for each option that the guide names but none of our programs and scripts has."""
    def helps(command):
        text = subprocess.run([*command, "--help"], capture_output=True, text=True, check=True).stdout
        inner = text.partition("Subcommands:")[2]
        return text + "".join(helps([*command, name]) for name in re.findall(r"^  (\w[\w-]*)", inner, re.M))

    known = "".join(helps([str(programs / p)]) for p in ("stylet", "stylet-model", "stylet-report", "stylet-study"))
    for script in ("packaging/run", "packaging/test", "packaging/build", "packaging/bench", "packaging/deb", "xr/mock/python/xrmock.py"):
        known += (source / script).read_text()
    others = {"--gtest_brief", "--gtest_list_tests", "--install", "--gtest_filter", "--preset", "--build", "--target", "--test-dir"}
    found = []
    for page in sorted(guide.glob("*.md")):
        for option in sorted(set(re.findall(r"(?<![\w-])--[a-z][\w-]*", page.read_text())) - others):
            if not re.search(rf"{option}(?![\w-])", known):
                found.append(f"{page.name}: no program knows {option}")
    return found


def differences(guide, pages, source):
    """A line for each name that is only in the guide or only in the written files."""
    found, chapters = [], {}
    for page, heading, names in written(pages, source):
        told, maybe = (described(guide, page, heading, s) for s in (False, True))
        chapters.setdefault(page, set()).add(heading)
        found += [f"{page}, {heading}: {n} is written and not described" for n in set(names) - set(told) - set(maybe)]
        found += [f"{page}, {heading}: {n} is described and not written" for n in set(told) - set(names)]
        if not names:
            found.append(f"{page}, {heading}: nothing was written to compare it with")
    # Every heading with the name of a table or file must have been compared above.
    for page in ("records.md", "formats.md"):
        for heading in re.findall(r"^## (`.*`)$", (guide / page).read_text(), re.M):
            if heading not in chapters[page]:
                found.append(f"{page}: {heading} is described, and nothing of that name was looked at")
    return found
