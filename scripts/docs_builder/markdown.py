"""Plain text as Markdown."""
import re


def escaped(text):
    """Words as they are: what Markdown would read as a mark gets a backslash. `Code` stays."""
    parts = re.split(r"(``?[^`]+``?)", text)
    return "".join(part if k % 2 else re.sub(r"([\\*_<>\[\]{}$|~])", r"\\\1", part) for k, part in enumerate(parts))


def paragraphs(lines):
    """Lines of a comment: prose with its paragraphs, and what is indented by two blanks or more as it stands."""
    out, block = [], []

    def flush():
        while block and not block[-1].strip():
            block.pop()
        if block:
            shift = min(len(line) - len(line.lstrip()) for line in block if line.strip())
            out.extend(["```text", *(line[shift:] for line in block), "```", ""])
        block.clear()
    for line in lines:
        if line.startswith("  ") or (block and not line.strip()):
            if not block and out and out[-1]:
                out.append("")
            block.append(line)
            continue
        flush()
        line = escaped(line)
        out.append(re.sub(r"^(#|\+|-|\d+\.)", r"\\\1", line))
    flush()
    return "\n".join(out)
