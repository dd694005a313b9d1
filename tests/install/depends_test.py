"""What the Debian packages say by themselves that they depend on is there: the packages are installed here, in versions
that fit, since the build needs them. (Shared libraries are found by dpkg-shlibdeps.)

usage: depends_test.py BUILD
"""
import os
import re
import shutil
import subprocess
import sys


def main():
    if not shutil.which("dpkg-query"):
        print("SKIPPED: the Debian packages' dependencies were NOT checked: no dpkg-query here")
        sys.exit(77)
    with open(os.path.join(sys.argv[1], "CPackConfig.cmake"), encoding="utf-8") as file:
        config = file.read()
    lists = re.findall(r'set\(CPACK_DEBIAN_\w+_PACKAGE_DEPENDS "([^"]*)"\)', config)
    version = re.search(r'set\(CPACK_PACKAGE_VERSION "([^"]*)"\)', config).group(1)
    wrong = checked = 0
    for dependency in sorted({d.strip() for depends in lists for d in depends.split(",")}):
        match = re.fullmatch(r"([a-z0-9][a-z0-9+.-]+)(?: \((>=|<<|=) (\d[\w.:+~-]*\w)\))?", dependency)
        if match and match.group(1) == "overtet":  # one of these packages
            right = match.group(3) == version
        else:
            found = match and subprocess.run(["dpkg-query", "-W", "-f", "${db:Status-Status} ${Version}", match.group(1)],
                                             stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True).stdout.split()
            right = bool(found) and found[0] == "installed" and (not match.group(2) or subprocess.run(
                ["dpkg", "--compare-versions", found[1], match.group(2), match.group(3)]).returncode == 0)
        checked += 1
        print("ok   " if right else "WRONG", dependency)
        wrong += not right
    if wrong or not checked:
        sys.exit(f"{wrong} of {checked} dependencies are wrong: no such package is installed here, or its version does not fit.")


main()
