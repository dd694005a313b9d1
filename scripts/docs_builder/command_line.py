"""The reference of the command line, from the man pages that the program prints of itself."""
import re
import subprocess

from .markdown import escaped


def manual(program, *command):
    return subprocess.run([program, "manual", *command], check=True, stdout=subprocess.PIPE, text=True).stdout


def plain(text):
    """Without roff's fonts and escapes."""
    return re.sub(r"\\f[BIR]", "", text).replace("\\-", "-").replace("\\&", "").replace("\\e", "\\").replace("\\(aq", "'")


def sections(roff):
    """The sections of a man page: title -> lines."""
    found, title = {}, ""
    for line in roff.split("\n"):
        if line.startswith(".SH "):
            title = line[4:]
            found[title] = []
        elif title:
            found[title].append(line)
    return found


def entries(lines):
    """What .TP lists: (term, text)."""
    found = []
    for k, line in enumerate(lines):
        if line == ".TP":
            text = []
            for more in lines[k + 2:]:
                if more == ".TP":
                    break
                text.append(plain(more))
            found.append((plain(lines[k + 1]), " ".join(text).strip()))
    return found


def commands(program):
    """(name, what it does), as the program lists them."""
    return entries(sections(manual(program))["COMMANDS"])


def sentence(text):
    return text if text.endswith((".", ":")) else text + "."


def page(program, name):
    parts = sections(manual(program, name))
    usage = re.sub(r"\s+", " ", plain(" ".join(re.sub(r"^\.[BI] ", "", line) for line in parts["SYNOPSIS"]))).strip()
    out = [f"# overtet {name}", "", escaped(" ".join(map(plain, parts["DESCRIPTION"]))).strip(), "", "```text", usage, "```", ""]
    listed = entries(parts["OPTIONS"])
    values = [entry for entry in listed if not entry[0].startswith("-")]
    if values:
        out += ["## Arguments", ""]
        for term, text in values:
            out += [f"`{term}`", f": {escaped(sentence(text))}", ""]
    out += ["## Options", "", f"```{{program}} overtet {name}", "```", ""]
    for term, text in listed:
        if term.startswith("-"):
            out += [f"````{{option}} {term}", escaped(sentence(text)), "````", ""]
    notes = [plain(line) for line in parts.get("NOTES", []) if line != ".br"]
    if notes:
        out += ["## Notes", "", *(escaped(line) + "\n" for line in notes)]
    return "\n".join(out)


def pages(program):
    listed = commands(program)
    parts = sections(manual(program))
    out = ["# Command line", "", escaped(" ".join(map(plain, parts["DESCRIPTION"]))), "",
           "These pages are made of what `overtet manual` prints.", "", "| command | |", "|---|---|"]
    out += [f"| [overtet {name}](command-{name}.md) | {escaped(text)} |" for name, text in listed]
    out += ["", *(escaped(plain(line)) + "\n" for line in parts["NOTES"] if line != ".br")]
    out += ["```{toctree}", ":hidden:", *(f"command-{name}" for name, _ in listed), "```", ""]
    made = {"command-line.md": "\n".join(out)}
    for name, _ in listed:
        made[f"command-{name}.md"] = page(program, name)
    return made
