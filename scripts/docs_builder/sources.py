"""The files that become pages, and the links in them."""
import glob
import os
import re

# Folders of the repository: what is written like a path in one of them must be there.
FOLDERS = "cmake|docs|examples|include|kernels|perf|python|scripts|src|tests"
PATH = re.compile(rf"(?<![\w./-])(?:{FOLDERS})/[\w./-]*[\w/]")
LINK = re.compile(r"(!?)\[([^\]\n]*)\]\(([^)\s]+)\)")
FENCE = re.compile(r"^ {0,3}(```+|~~~+)")
URL = re.compile(r"https?://[A-Za-z0-9-]+(\.[A-Za-z0-9-]+)+(:\d+)?(/[^\s<>\"]*)?$")


def pages(root):
    """The page of each file: path in the repository -> name on the site."""
    found = {"README.md": "readme.md", "CHANGELOG.md": "changes.md", "CONTRIBUTING.md": "contributing.md",
             "examples/README.md": "examples.md", "examples/python/README.md": "examples-python.md"}
    for path in sorted(glob.glob(os.path.join(root, "docs", "*.md")) + glob.glob(os.path.join(root, "docs", "site", "*.md"))):
        found[os.path.relpath(path, root)] = os.path.basename(path)
    if len(set(found.values())) != len(found):
        raise ValueError("Two files would become the same page.")
    return found


def files(root):
    """Pictures and data that pages show or link to: path in the repository -> name on the site."""
    found = {}
    for pattern, folder in (("docs/*.svg", ""), ("docs/*.png", ""), ("docs/*.json", ""), ("docs/pictures/*", "pictures/")):
        for path in sorted(glob.glob(os.path.join(root, pattern))):
            found[os.path.relpath(path, root)] = folder + os.path.basename(path)
    return found


def prose(text):
    """The lines of a Markdown file: (number, line, whether it is code)."""
    fence = ""
    for number, line in enumerate(text.split("\n"), 1):
        mark = FENCE.match(line)
        if mark and (not fence or line.strip().startswith(fence)):
            yield number, line, True
            fence = "" if fence else mark.group(1)
        else:
            yield number, line, bool(fence) or line.startswith("    ")


def target_of(root, path, link):
    """The path in the repository that a link of this file leads to, and the anchor."""
    where, _, anchor = link.partition("#")
    if not where:
        return path, anchor
    return os.path.relpath(os.path.normpath(os.path.join(root, os.path.dirname(path), where)), root), anchor


def check(root):
    """What is wrong with the links of all pages' sources, as messages."""
    wrong = []
    with open(os.path.join(root, "docs", "site", "index.md"), encoding="utf-8") as file:
        listed = re.findall(r"^(?:.* <)?([\w-]+)>?$", file.read(), re.MULTILINE)
    for path, name in pages(root).items():
        if name != "index.md" and listed.count(name[:-3]) != 1:
            wrong.append(f"{path}: name this page, {name[:-3]}, once in the lists of docs/site/index.md.")
    for path in [*pages(root), "perf/README.md"]:
        with open(os.path.join(root, path), encoding="utf-8") as file:
            text = file.read()
        for number, line, code in prose(text):
            for _, _, link in [] if code else LINK.findall(re.sub(r"`[^`]*`", "", line)):
                if re.match(r"[a-z]+:", link):
                    if not URL.match(link):
                        wrong.append(f"{path}:{number}: {link} is no address of a page.")
                elif not is_there(root, path, link):
                    wrong.append(f"{path}:{number}: {link} leads nowhere.")
            # Paths that are named: upper-case words are for the reader to fill in (read_NAME.cpp).
            for named in [] if path == "CHANGELOG.md" else PATH.findall(line):
                if re.search(r"[A-Z]{3}", named.replace("README", "")):
                    continue
                if not any(glob.glob(os.path.join(root, folder, named) + "*") for folder in ("", os.path.dirname(path))):
                    wrong.append(f"{path}:{number}: {named} is not there.")
    return wrong


def is_there(root, path, link):
    target, _ = target_of(root, path, link)
    # Pages that are made while the site is built.
    return target.startswith("docs/site/reference/") or os.path.exists(os.path.join(root, target))


def page_text(root, path, text, names):
    """A file as a page: links lead to pages of the site, what has no page is only named.

    names: path in the repository -> name on the site, of pages and files.
    """
    def link(match):
        picture, words, where = match.groups()
        if re.match(r"[a-z]+:", where):
            return match.group(0)
        target, anchor = target_of(root, path, where)
        if target.startswith("docs/site/reference/"):
            name = target[len("docs/site/"):]
        elif target in names:
            name = names[target]
        else:
            return words
        return f"{picture}[{words}]({name}{'#' + anchor if anchor else ''})"

    return "\n".join(line if code else LINK.sub(link, with_links(line, names)) for _, line, code in prose(text))


def with_links(line, names, prefix=""):
    """A line of prose in which files that are named, and have a page, are links to that."""
    def named(match):
        name = names.get(match.group(0))
        return f"[{match.group(0)}]({prefix}{name})" if name and name.endswith(".md") else match.group(0)
    # What stands between backticks stays, and so do links.
    parts = re.split(r"(`[^`]*`|!?\[[^\]\n]*\]\([^)\s]+\))", line)
    return "".join(part if k % 2 else PATH.sub(named, part) for k, part in enumerate(parts))


def reference_text(text, names):
    """A page of a reference, in a folder of its own, with links to what it names."""
    return "\n".join(line if code else with_links(line, names, "../") for _, line, code in prose(text))
