#!/usr/bin/env python3
"""Runs every command of the user's guide, page by page, as a reader would: in an empty home and working folder.

    guide_test.py GUIDE BUILD [PAGE...]     the pages in the folder GUIDE, with the programs of the build folder BUILD

The first word after a fence determines what happens with its block:
    sh                  run by bash, with one shell per page; must succeed
    sh exit=N           must end with status N
    sh headset          run with the mock runtime instead of a headset
    sh norun: REASON    not run; NOT_RUN below gives the number of such blocks per page
    text                lines that the previous block must have printed, in this order; "..." matches anything
    files               files (the first word of each line) that must exist and not be empty after the previous block
Any other fence is an error, so that no block of a page remains untested.
"""
import concurrent.futures
import contextlib
import hashlib
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import reference

# Nothing checks a block that is not run. Every new one must be counted here.
NOT_RUN = {
    "README.md": 2,
    "trainee.md": 1,
    "instructor.md": 2,
    "researcher.md": 2,
    "xrmock.md": 2,
    "developer.md": 3,
    "model.md": 0,
    "modelling.md": 0,
    "drainage.md": 0,
    "glossary.md": 0,
    "metrics.md": 0,
    "records.md": 0,
    "formats.md": 0,
}
LONGEST_PAGE = 150  # lines; reference chapters may be longer, and the recipes of developer.md
LONGEST_RECIPES = 380
CHAPTERS = {"model.md", "metrics.md", "records.md", "formats.md"}
LONGEST_BLOCK_S = 600
RECIPES = [2, 3, 3, 1, 1, 5]  # files that each recipe of developer.md may touch


class Wrong(Exception):
    """A page is wrong."""


class Block:
    def __init__(self, page, line, info, text):
        self.place = f"{page}:{line}"
        self.kind, _, self.more = info.partition(" ")
        self.text = text


def blocks_of(page, text):
    found, open_at, info, lines = [], None, "", []
    for number, line in enumerate(text.splitlines(), 1):
        if open_at is None and line.startswith("```"):
            open_at, info, lines = number, line[3:].strip(), []
        elif open_at is not None and line.strip() == "```":
            found.append(Block(page, open_at, info, "\n".join(lines)))
            open_at = None
        elif open_at is not None:
            lines.append(line)
        elif line.lstrip().startswith("```"):
            raise Wrong(f"{page}:{number}: a fence that is indented is not read")
    if open_at is not None:
        raise Wrong(f"{page}:{open_at}: this fence is never closed")
    return found


class Shell:
    """Runs a page's commands. Exported variables and the working folder carry over to the next command."""

    def __init__(self, folder, environment, headset):
        self.folder, self.environment, self.headset = folder, environment, headset
        self.state = folder / ".state"
        self.state.write_text("")

    def run(self, block):
        before, after = "", ""
        if block.more == "headset":
            before, after = f"export XR_RUNTIME_JSON='{self.headset}'", "unset XR_RUNTIME_JSON"
        script = (f"set -euo pipefail\nsource '{self.state}'\n{before}\n{block.text}\n{after}\n"
                  f"{{ export -p; printf 'cd %q\\n' \"$PWD\"; }} >'{self.state}'\n")
        with tempfile.TemporaryFile() as output:
            process = subprocess.Popen(["bash", "-c", script], cwd=self.folder, env=self.environment, stdin=subprocess.DEVNULL,
                                       stdout=output, stderr=subprocess.STDOUT, start_new_session=True)
            try:
                status = process.wait(LONGEST_BLOCK_S)
            except subprocess.TimeoutExpired:
                status = f"none within {LONGEST_BLOCK_S} s"
            # Kill the processes that the block left in the background.
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            output.seek(0)
            return status, output.read().decode(errors="replace")


def check_text(block, output):
    rest = output
    for line in filter(None, (line.strip() for line in block.text.splitlines())):
        pattern = ".*".join(re.escape(part.strip()) for part in line.split("..."))
        match = re.search(pattern, rest)
        if not match:
            raise Wrong(f"{block.place}: was not printed (here): {line}\n--- what was printed:\n{output}")
        rest = rest[match.end():]


def check_files(block, shell):
    words = shell.state.read_text().splitlines()[-1]
    folder = pathlib.Path(subprocess.run(["bash", "-c", f"{words}; pwd"], capture_output=True, text=True, check=True).stdout.strip())
    for line in filter(str.strip, block.text.splitlines()):
        file = folder / line.split()[0]
        if not file.exists() or (file.is_file() and file.stat().st_size == 0):
            there = sorted(str(f.relative_to(folder)) for f in file.parent.glob("*")) if file.parent.exists() else []
            raise Wrong(f"{block.place}: is not there, or empty: {line.split()[0]}\n--- beside it: {there}")


def run_page(page, text, shell, say):
    """Returns the places of the blocks that were not run, each with its reason."""
    left_out, output = [], None
    for block in blocks_of(page, text):
        if block.kind == "sh" and block.more.startswith("norun:"):
            left_out.append(f"{block.place}: {block.more[6:].strip()}")
            output = None
        elif block.kind == "sh":
            wanted = re.fullmatch(r"(?:|headset|exit=(\d+))", block.more)
            if not wanted:
                raise Wrong(f"{block.place}: unknown: {block.more}")
            began = time.monotonic()
            status, output = shell.run(block)
            say(f"{block.place}: {time.monotonic() - began:.1f} s")
            if status != int(wanted.group(1) or 0):
                raise Wrong(f"{block.place}: exit status {status}:\n{block.text}\n--- it printed:\n{output}")
        elif block.kind in ("text", "files"):
            if output is None:
                raise Wrong(f"{block.place}: nothing was run before that could be looked at")
            check_text(block, output) if block.kind == "text" else check_files(block, shell)
        else:
            raise Wrong(f"{block.place}: a fence must say sh, text or files")
    return left_out


def check_links(guide, page, text):
    for target in re.findall(r"\]\(([^)#\s]+)", re.sub(r"```.*?```", "", text, flags=re.S)):
        if "://" in target:
            continue
        if not (guide / target).exists():
            raise Wrong(f"{page}: links to {target}, which is not there")
        file, source = (guide / target).resolve(), guide.parent.parent
        installed = (source / "packaging" / "CMakeLists.txt").read_text()
        if not file.is_relative_to(guide) and str(file.relative_to(source)) not in installed:
            raise Wrong(f"{page}: links to {target}, which packaging/CMakeLists.txt does not install")


def check_citation(source):
    version = re.search(r"project\(Stylet VERSION (\S+)", (source / "CMakeLists.txt").read_text()).group(1)
    if f"\nversion: {version}\n" not in (source / "CITATION.cff").read_text():
        raise Wrong(f"CITATION.cff: another version than the project's, {version}")


def check_recipes(text, copy):
    """Each recipe is a commit in its copy of the sources. Checks the number of files that it changes or adds."""
    log = subprocess.run(["git", "log", "--reverse", "--name-only", "--format=%x00"], cwd=copy, capture_output=True, text=True, check=True)
    files = [len(commit.split()) for commit in log.stdout.split("\0")[2:]]  # without the commit of all sources
    headings = [int(n) for n in re.findall(r"^### \d+\. .*: (\d+) files?$", text, re.M)]
    if not files == headings == RECIPES:
        raise Wrong(f"developer.md: the recipes touch {files} files, their headings say {headings}, and RECIPES says {RECIPES}")


def check_refusals(folder):
    """Checks that wrong pages are detected."""
    shell = Shell(folder, dict(os.environ), "")
    for text in ("```sh\nfalse\n```", "```sh\nfalse | true\n```", "```sh exit=1\ntrue\n```", "```sh\ntrue", "```bash\ntrue\n```",
                 "```sh\necho a; echo b\n```\n```text\nb\na\n```", "```sh\n:\n```\n```files\nnone.txt\n```",
                 "```sh\n: >empty\n```\n```files\nempty\n```", "```text\nanything\n```", "```sh\nno-such-program\n```"):
        try:
            run_page("(a page that is wrong)", text, shell, lambda _: None)
        except Wrong:
            continue
        raise Wrong(f"this page should have been found wrong:\n{text}")


def compiler_cache():
    """The caller's ccache, if there is one, for the builds of developer.md. A page's own home folder is empty."""
    if not shutil.which("ccache"):
        return {}
    folder = subprocess.run(["ccache", "--get-config", "cache_dir"], capture_output=True, text=True, check=False).stdout.strip()
    # As in packaging/lib.sh. Without the sloppiness nothing that uses precompiled headers is cached.
    return {"CCACHE_DIR": folder, "CCACHE_SLOPPINESS": "pch_defines,time_macros"} if folder else {}


class Display:
    """A virtual X display for the windows."""

    def __enter__(self):
        read, write = os.pipe()
        self.server = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "1280x800x24", "-nolisten", "tcp"],
                                       pass_fds=[write], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as told:
            return ":" + told.readline().strip()

    def __exit__(self, *_):
        self.server.terminate()
        self.server.wait()


def place_for(page, temp, source, build):
    """A folder that contains only what a reader has in a clone with its build."""
    folder = temp / page
    (folder / "build").mkdir(parents=True)
    (folder / "home").mkdir()
    for name in source.iterdir():
        if name.name not in ("build", ".git"):
            (folder / name.name).symlink_to(name)
    for name in ("release", "mock"):
        (folder / "build" / name).symlink_to(build)
    return folder


def main():
    guide, build = (pathlib.Path(a).resolve() for a in sys.argv[1:3])
    source = guide.parent.parent
    pages = sys.argv[3:] or sorted(p.name for p in guide.glob("*.md"))
    # The same folder in every run: CMake writes its path into the sources that it unites, so the compiler cache needs it.
    temp = pathlib.Path(tempfile.gettempdir()) / f"stylet-guide-{hashlib.sha256(str(build).encode()).hexdigest()[:8]}"
    shutil.rmtree(temp, ignore_errors=True)
    temp.mkdir(mode=0o700)
    began, failed = time.monotonic(), []
    # No OpenXR runtime except the one that a block selects. One shared cache, because making a patient takes seconds.
    bare = {k: v for k, v in os.environ.items() if not re.match("STYLET_|GIT_|XDG_|XR_|XRMOCK_|LC_|LANG|WAYLAND_DISPLAY", k)}
    bare |= {"PATH": f"{build}/bin:{os.environ['PATH']}", "XDG_CACHE_HOME": str(temp / "cache")} | compiler_cache()

    def test(page):
        lines, text = [], (guide / page).read_text()
        folder = place_for(page, temp, source, build)
        shell = Shell(folder, bare | {"HOME": str(folder / "home"), "PWD": str(folder)}, str(build / "lib" / "xrmock.json"))
        try:
            check_links(guide, page, text)
            longest = LONGEST_RECIPES if page == "developer.md" else LONGEST_PAGE
            if page not in CHAPTERS and len(text.splitlines()) > longest:
                raise Wrong(f"{page}: more than {longest} lines")
            left_out = run_page(page, text, shell, lines.append)
            lines += [f"not run: {one}" for one in left_out]
            if page == "developer.md":
                check_recipes(text, folder / "recipes")
            if len(left_out) != NOT_RUN[page]:
                raise Wrong(f"{page}: {len(left_out)} blocks are not run, and NOT_RUN says {NOT_RUN[page]}")
        except Wrong as wrong:
            failed.append(page)
            lines.append(f"WRONG: {wrong}")
        if lines:
            print("\n".join(lines), flush=True)

    try:
        if not sys.argv[3:] and set(pages) != set(NOT_RUN):
            raise Wrong(f"pages are {pages}, and NOT_RUN has {sorted(NOT_RUN)}")
        (temp / "wrong").mkdir()
        check_refusals(temp / "wrong")
        check_citation(source)
        unknown = reference.unknown_options(guide, source, build / "bin")
        if unknown:
            raise Wrong("\n".join(unknown))
        with Display() as display, concurrent.futures.ThreadPoolExecutor(2) as pool:
            bare["DISPLAY"] = display
            # The longest page first. The second one makes the patient that the others load from the cache.
            pages.sort(key=lambda p: ["researcher.md", "trainee.md", "developer.md", "instructor.md", p].index(p))
            list(pool.map(test, pages))
        if not failed and not sys.argv[3:]:
            different = reference.differences(guide, temp, source)
            if different:
                raise Wrong("\n".join(different))
    except Wrong as wrong:
        failed.append("guide")
        print(f"WRONG: {wrong}")
    finally:
        shutil.rmtree(temp, ignore_errors=True)
    print(f"{len(pages)} pages, {sum(NOT_RUN.get(p, 0) for p in pages)} blocks not run, {time.monotonic() - began:.0f} s: "
          + (f"FAILED: {', '.join(sorted(failed))}" if failed else "all as the guide says"))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
