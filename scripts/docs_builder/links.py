"""Checks built pages: links and anchors lead somewhere, and nothing is loaded from another place."""
import html.parser
import os
import re
import urllib.parse

from .sources import URL

LOADED = {"img": "src", "script": "src", "link": "href", "iframe": "src", "source": "src", "video": "src", "object": "data"}


class Page(html.parser.HTMLParser):
    def __init__(self):
        super().__init__()
        self.anchors, self.links, self.loaded = set(), [], []

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        for key in ("id", "name"):
            if attributes.get(key):
                self.anchors.add(attributes[key])
        if tag == "a" and attributes.get("href") is not None:
            self.links.append(attributes["href"])
        if tag in LOADED and attributes.get(LOADED[tag]):
            if tag == "link" and attributes.get("rel") in ("canonical", "search", "next", "prev", "index", "author"):
                self.links.append(attributes["href"])
            else:
                self.loaded.append(attributes[LOADED[tag]])


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def check(folder):
    """Counts, and messages about what is wrong."""
    pages, wrong = {}, []
    for where, _, names in os.walk(folder):
        for name in sorted(names):
            path = os.path.join(where, name)
            if name.endswith(".html"):
                page = pages[os.path.normpath(path)] = Page()
                page.feed(read(path))
            elif name.endswith(".js") and re.search(r"^import\b", read(path), re.MULTILINE):
                wrong.append(f"{os.path.relpath(path, folder)} is a module; pages that are opened as files cannot load it.")
            elif name.endswith(".css"):
                for address in re.findall(r"(?:url\(|@import)\s*['\"]?((?:https?:)?//[^)'\"\s]+)", read(path)):
                    wrong.append(f"{os.path.relpath(path, folder)} loads {address}.")
    counts = {"pages": len(pages), "inside": 0, "addresses": 0}
    for path, page in sorted(pages.items()):
        here = os.path.relpath(path, folder)
        far = [link for link in page.loaded if re.match(r"(https?:)?//", link)]
        wrong += [f"{here} loads {link} from another place." for link in far]
        for link in page.links + [x for x in page.loaded if x not in far and not x.startswith("data:")]:
            if re.match(r"[a-z][a-z0-9+.-]*:|//", link):
                counts["addresses"] += 1
                if not URL.match(link):
                    wrong.append(f"{here}: {link} is no address of a page.")
                continue
            counts["inside"] += 1
            where, _, anchor = link.partition("#")
            where = urllib.parse.unquote(where.partition("?")[0])
            target = os.path.normpath(os.path.join(os.path.dirname(path), where)) if where else path
            if not os.path.isfile(target):
                wrong.append(f"{here}: {link} leads nowhere.")
            elif anchor and target in pages and urllib.parse.unquote(anchor) not in pages[target].anchors:
                wrong.append(f"{here}: {link}: that page has no such place.")
    return counts, wrong
