"""The site: its sources put together, built by Sphinx, checked."""
import importlib.util
import os
import re
import shutil
import subprocess
import sys

from . import command_line, cpp, links, python_module, sources

SKIPPED = 77  # what tests end with that could not be run
NEEDED = {"sphinx": "python3-sphinx", "myst_parser": "python3-myst-parser", "furo": "furo"}


def write(folder, name, text):
    path = os.path.join(folder, name)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def gather(root, program, folder):
    """All that Sphinx reads, in a folder of its own."""
    shutil.rmtree(folder, ignore_errors=True)
    pages, files = sources.pages(root), sources.files(root)
    names = {**pages, **files}
    for path, name in pages.items():
        with open(os.path.join(root, path), encoding="utf-8") as file:
            write(folder, name, sources.page_text(root, path, file.read(), names))
    for path, name in files.items():
        os.makedirs(os.path.dirname(os.path.join(folder, name)), exist_ok=True)
        shutil.copy2(os.path.join(root, path), os.path.join(folder, name))
    shutil.copytree(os.path.join(root, "examples"), os.path.join(folder, "examples"),
                    ignore=shutil.ignore_patterns("*.md", "__pycache__"))
    for made in (command_line.pages(program), cpp.pages(root), python_module.pages(root)):
        for name, text in made.items():
            write(folder, os.path.join("reference", name), sources.reference_text(text, names))


def join_scripts(html):
    """Debian's Furo has its script in two modules, which pages load as one plain script: so it is made one."""
    folder = os.path.join(html, "_static", "scripts")
    path = os.path.join(folder, "furo.js")
    with open(path, encoding="utf-8") as file:
        text = file.read()
    match = re.match(r'import Gumshoe from "\./([\w.-]+)";\n', text)
    if match:
        with open(os.path.join(folder, match.group(1)), encoding="utf-8") as file:
            text = file.read() + text[match.end():]
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)


def version(root):
    with open(os.path.join(root, "include", "overtet", "version.h"), encoding="utf-8") as file:
        return ".".join(line.split()[2] for line in file if line.startswith("#define OVERTET_VERSION_"))


def build(root, program, out):
    missing = [package for module, package in NEEDED.items() if not importlib.util.find_spec(module)]
    if missing:
        print(f"SKIPPED: the documentation site was NOT built: {', '.join(missing)} (Debian) not installed; "
              "`scripts/setup --docs` does that.")
        return SKIPPED
    if not os.access(program, os.X_OK):
        print(f"{program}: no such program. Build it (scripts/build release overtet), or name it with --program.", file=sys.stderr)
        return 1
    gathered, html = os.path.join(out, "sources"), os.path.join(out, "html")
    gather(root, os.path.abspath(program), gathered)
    shutil.rmtree(html, ignore_errors=True)
    release = version(root)
    done = subprocess.run(
        [sys.executable, "-B", "-m", "sphinx", "-W", "--keep-going", "-q", "-n", "-E", "-b", "html", "-c", os.path.join(root, "docs", "site"),
         "-d", os.path.join(out, "doctrees"), "-D", f"version={release}", "-D", f"release={release}", gathered, html],
        env=dict(os.environ, PYTHONDONTWRITEBYTECODE="1"), check=False)
    if done.returncode != 0:
        print("Sphinx has warnings or failed: see above.", file=sys.stderr)
        return 1
    join_scripts(html)
    checked, wrong = links.check(html)
    for message in wrong:
        print(message, file=sys.stderr)
    if wrong:
        return 1
    print(f"{os.path.join(html, 'index.html')}: {checked['pages']} pages; {checked['inside']} links inside and {checked['addresses']} "
          "addresses of other sites are as they should be; nothing is loaded from elsewhere.")
    return 0
