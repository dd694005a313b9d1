"""The reference of the Python module, from its signatures and docstrings. Nothing is imported, so nothing need be built."""
import ast
import inspect
import os
import re

from .markdown import escaped


def source(root, name):
    with open(os.path.join(root, "python", "overtet", name), encoding="utf-8") as file:
        text = file.read()
    return text, ast.parse(text)


def signature(node):
    """Without the types, which the stubs have."""
    arguments = node.args
    out, defaults = [], [None] * (len(arguments.args) - len(arguments.defaults)) + arguments.defaults
    for argument, default in zip(arguments.args, defaults):
        if argument.arg != "self":
            out.append(argument.arg + ("" if default is None else "=" + ast.unparse(default)))
    if arguments.kwonlyargs:
        out.append("*")
    for argument, default in zip(arguments.kwonlyargs, arguments.kw_defaults):
        out.append(argument.arg + ("" if default is None else "=" + ast.unparse(default)))
    return ", ".join(out)


def prose(docstring):
    lines = [line if line.startswith("    ") else re.sub(r"^(#|\+|-|\d+\.)", r"\\\1", escaped(line))
             for line in inspect.cleandoc(docstring or "").split("\n")]
    return "\n".join(lines)


def function(node, kind="function"):
    return [f"`````{{py:{kind}}} {node.name}({signature(node)})", "", prose(ast.get_docstring(node)), "`````", ""]


def members(text, node):
    """The fields of a dataclass, with their comments (`#: ...`)."""
    lines, found = text.split("\n"), []
    for item in node.body:
        if isinstance(item, ast.AnnAssign) and not item.target.id.startswith("_"):
            comment = re.search(r"#: (.*)$", lines[item.end_lineno - 1])
            found.append((item.target.id, ast.unparse(item.annotation), comment.group(1) if comment else ""))
    return found


def class_(text, node):
    bases = [b.id for b in node.bases if isinstance(b, ast.Name)]
    made_by = [item for item in node.body if isinstance(item, ast.FunctionDef) and item.name == "__init__"]
    out = [f"``````{{py:class}} {node.name}" + (f"({signature(made_by[0])})" if made_by else ""), ""]
    if bases and bases != ["Exception"]:
        out += ["Is also: " + ", ".join(f"`{b}`" for b in bases) + ".", ""]
    out += [prose(ast.get_docstring(node)), ""]
    fields = members(text, node)
    if fields and not any(b.endswith("Error") or b == "Exception" for b in bases):
        out += ["| field | type | |", "|---|---|---|"]
        out += ["| `%s` | `%s` | %s |" % (n, t.replace("|", "\\|"), escaped(c)) for n, t, c in fields] + [""]
    for item in node.body:
        if isinstance(item, ast.FunctionDef) and not item.name.startswith("_") and ast.get_docstring(item):
            kind = "property" if any(getattr(d, "id", "") == "property" for d in item.decorator_list) else "method"
            if kind == "property":
                out += [f"`````{{py:property}} {item.name}", "", prose(ast.get_docstring(item)), "`````", ""]
            else:
                out += function(item, kind)
    return out + ["``````", ""]


def pages(root):
    text, module = source(root, "__init__.py")
    public = next(ast.literal_eval(node.value) for node in module.body
                  if isinstance(node, ast.Assign) and node.targets[0].id == "__all__")
    nodes = {}
    files = sorted(f for f in os.listdir(os.path.join(root, "python", "overtet")) if f.startswith("_") and f.endswith(".py"))
    for name in files:
        text, tree = source(root, name)
        for node in tree.body:
            if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and node.name in public:
                nodes[node.name] = (text, node)
    missing = [name for name in public if name not in nodes]
    if missing:
        raise ValueError(f"python/overtet: {', '.join(missing)} not found.")
    out = ["# Python", "", prose(ast.get_docstring(module)), "", "This page is made of the module's docstrings; docs/python.md says how it is "
           "installed and what errors, threads and Ctrl-C do.", "", "```{py:module} overtet", "```", ""]
    kinds = (("Functions", lambda n: isinstance(n, ast.FunctionDef)),
             ("Data", lambda n: isinstance(n, ast.ClassDef) and not is_error(n)),
             ("Exceptions", lambda n: isinstance(n, ast.ClassDef) and is_error(n)))
    for title, belongs in kinds:
        out += [f"## {title}", ""]
        for name in public:
            text, node = nodes[name]
            if belongs(node):
                out += function(node) if isinstance(node, ast.FunctionDef) else class_(text, node)
    return {"python-module.md": "\n".join(out)}


def is_error(node):
    return any(isinstance(b, ast.Name) and (b.id in ("Exception", "Error", "Limit") or b.id.endswith("Error")) for b in node.bases)
