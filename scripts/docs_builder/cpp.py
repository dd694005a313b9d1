"""The reference of the C++ library, from the public headers: each comment, with the declaration that follows it."""
import glob
import os
import re

from .markdown import paragraphs

# What a declaration declares.
NAME = re.compile(r"^(?:enum class|struct|class|using) (\w+)|^(?:\[\[nodiscard\]\] )?(?:inline |static )?[\w:<>,\s*&]*?[\s*&](\w+)\(")


def comment_lines(lines):
    return [re.sub(r"^\s*// ?", "", line) for line in lines]


def parsed(text):
    """The comment on top of a header, and its declarations: (comment lines, declaration lines)."""
    lines = text.split("\n")
    top = 0
    while lines[top].startswith("//"):
        top += 1
    head = comment_lines(lines[:top])
    inside = [k for k, line in enumerate(lines) if line.startswith("namespace overtet {")]
    end = max(k for k, line in enumerate(lines) if line.startswith("}  // namespace overtet"))
    macros = [line for line in lines if line.startswith("#define ")]
    items, comment, code, depth = [], [], [], 0
    for line in lines[inside[0] + 1:end] if inside else []:
        if not depth and not code and line.startswith("//"):
            comment.append(line)
        elif not line.strip() and not depth and not code:
            if comment:  # of what follows in general, not of one declaration
                items.append((comment_lines(comment), []))
            comment = []
        else:
            code.append(line)
            depth += line.count("{") - line.count("}") + line.count("(") - line.count(")")
            ended = not depth and re.search(r"[;}]\s*(//.*)?$", line)
            if ended:
                items.append((comment_lines(comment), code))
                comment, code = [], []
    return head, macros, items


def name_of(code):
    text = " ".join(line.strip() for line in code if not line.strip().startswith("//"))
    text = re.sub(r"^template <[^>]*>\s*", "", text)
    text = re.sub(r"^class \[\[nodiscard\]\]", "class", text)
    match = NAME.match(text)
    return (match.group(1) or match.group(2)) if match else None


def page(path):
    name = os.path.basename(path)
    with open(path, encoding="utf-8") as file:
        head, macros, items = parsed(file.read())
    out = [f"# overtet/{name}", "", f"    #include <overtet/{name}>", "", paragraphs(head), ""]
    if macros:
        out += ["```cpp", *macros, "```", ""]
    groups = []  # declarations of one name that follow each other belong together
    for comment, code in items:
        if re.fullmatch(r"(class|struct) \w+;.*", " ".join(code)):
            continue  # declared elsewhere
        declared = name_of(code) if code else None
        if declared and groups and groups[-1][0] == declared:
            groups[-1][1].append((comment, code))
        elif declared is None and groups and code and not comment:
            groups[-1][1].append((comment, code))
        else:
            groups.append((declared, [(comment, code)]))
    declared_names = []
    for declared, parts in groups:
        if declared:
            declared_names.append(declared)
            out += [f"## {declared}", ""]
        for comment, code in parts:
            if comment:
                out += [paragraphs(comment), ""]
            if code:
                out += ["```cpp", *code, "```", ""]
    return "\n".join(out), head, declared_names


def first_sentence(head):
    text = " ".join(line.strip() for line in head)
    return re.split(r"(?<=[.?])\s", text)[0]


def pages(root):
    made, listed = {}, []
    for path in sorted(glob.glob(os.path.join(root, "include", "overtet", "*.h"))):
        name = os.path.basename(path)[:-2]
        if name == "overtet":
            continue  # includes the others
        text, head, names = page(path)
        made[f"cpp-{name}.md"] = text
        listed.append((name, first_sentence(head), names))
    out = ["# C++", "", "`#include <overtet/overtet.h>` includes all of these. All names are in the namespace `overtet`. These pages are made "
           "of the headers' own comments.", "", "| header | | declares |", "|---|---|---|"]
    for name, text, names in listed:
        words = ", ".join(f"[{n}](cpp-{name}.md#{n.lower()})" for n in dict.fromkeys(names))
        out.append(f"| [overtet/{name}.h](cpp-{name}.md) | {paragraphs([text])} | {words} |")
    out += ["", "```{toctree}", ":hidden:", *(f"cpp-{name}" for name, _, _ in listed), "```", ""]
    made["cpp.md"] = "\n".join(out)
    return made
