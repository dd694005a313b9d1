"""Runs the program on one model in a process of its own, and describes the machine. Used by suite and compare."""
import json
import os
import platform
import re
import subprocess
import tempfile
import time

SURFACES = (".off", ".obj", ".ply", ".stl")


def models(arguments):
    """The surface files among files and folders, folders in the order of their names."""
    found = []
    for argument in arguments:
        if os.path.isdir(argument):
            found += [os.path.join(argument, f) for f in sorted(os.listdir(argument)) if f.lower().endswith(SURFACES)]
        else:
            found.append(argument)
    return found


def faces_of(model):
    """How many faces a file says that it has (.off, .obj, .ply, binary .stl); 0 where it does not say so."""
    with open(model, "rb") as file:
        if model.lower().endswith(".obj"):
            return sum(line.startswith(b"f ") for line in file)
        if model.lower().endswith(".stl"):
            return int.from_bytes(file.read(84)[80:], "little")
        words = []
        for line in file:
            words += line.split(b"#")[0].split()
            if words[:1] == [b"ply"] and line.strip() == b"end_header":
                return int(words[words.index(b"face") + 1])
            if words[:1] != [b"ply"] and len(words) > 2:
                return int(words[2])
    return 0


def run(program, model, arguments=(), threads=0, time_limit=600.0, grace=5.0, output=None):
    """One whole run: {model, exit_code, status, wall_seconds, cpu_seconds, peak_rss_bytes, bytes_written, report}.

    cpu_seconds and peak_rss_bytes cover the helpers that the program starts; without a report, peak_rss_bytes is that
    of the largest of the processes. A run that is over its time limit by half and the grace (seconds) is killed:
    exit code None, status "killed". output: where the mesh goes; else it is not kept.
    """
    with tempfile.TemporaryDirectory() as folder:
        output = output or os.path.join(folder, "out.mesh")
        report = os.path.join(folder, "report.json")
        command = [program, "mesh", model, "-o", output, "--report", report, "--quiet",
                   "--time-limit", str(time_limit), *arguments]
        if threads:
            command += ["--threads", str(threads)]
        before = time.monotonic()
        with open(os.path.join(folder, "stderr"), "w+b") as stderr:
            process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=stderr, start_new_session=True)
            status, usage = wait(process.pid, before + 1.5 * time_limit + grace)
            wall = time.monotonic() - before
            stderr.seek(0)
            said = stderr.read().decode(errors="replace").strip()
        process.returncode = 0  # it has been waited for
        result = {
            "model": os.path.splitext(os.path.basename(model))[0],
            "threads": threads,
            "exit_code": status,
            "wall_seconds": wall,
            "cpu_seconds": usage.ru_utime + usage.ru_stime,
            "peak_rss_bytes": usage.ru_maxrss * 1024,
            "bytes_written": os.path.getsize(output) if os.path.exists(output) else 0,
            "said": said,
            "report": {},
        }
        if os.path.exists(report):
            with open(report, encoding="utf-8") as file:
                result["report"] = json.load(file)
        result["peak_rss_bytes"] = max(result["peak_rss_bytes"], result["report"].get("peak_rss_bytes", 0))
        result["status"] = result["report"].get("status", "killed" if status is None else "none")
        return result


def wait(pid, deadline):
    """(exit code, resource usage) of a child; None for one that had to be killed, -n for one that signal n ended."""
    killed = False
    while True:
        got, status, usage = os.wait4(pid, 0 if killed else os.WNOHANG)
        if got:
            return (None if killed else os.waitstatus_to_exitcode(status)), usage
        if time.monotonic() > deadline:
            os.killpg(pid, 9)
            killed = True
        else:
            time.sleep(0.002)


def flat(run):
    """A run as one level of names and numbers: what stands in the CSV and what is compared."""
    row = {k: v for k, v in run.items() if k not in ("report", "said")}
    report = run["report"]
    row["message"] = report.get("message", run["said"])
    for name in ("faces", "vertices", "pairs", "hinges"):
        row[name] = report.get("input", {}).get(name)
    for name in ("tets", "dihedral_min", "dihedral_p01"):
        row[name] = report.get("quality", {}).get(name)
    row["result_hash"] = report.get("result_hash")
    seen = {}
    for stage in report.get("stages", []):
        # A stage that ran more than once (after a repair, on the second route) is numbered.
        seen[stage["name"]] = seen.get(stage["name"], 0) + 1
        name = stage["name"] if seen[stage["name"]] == 1 else f"{stage['name']}#{seen[stage['name']]}"
        for key, value in stage.items():
            if key != "name" and isinstance(value, (int, float)):
                row[f"{name}.{key}"] = value
    return row


def tetgen_seconds(row):
    """What TetGen took, its process and the talk with it included, or None."""
    parts = [v for k, v in row.items() if k.endswith("tet_mesh_seconds") or k in ("tet_mesh.seconds",)]
    return sum(parts) if parts else None


def machine(program):
    """What the figures depend on: processor, memory, system, compiler, build type, commit."""
    cpu = ""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            cpu = next((line.split(":", 1)[1].strip() for line in file if line.startswith("model name")), "")
    except OSError:
        pass
    out = {
        "cpu": cpu or platform.processor(),
        "cores": len(os.sched_getaffinity(0)),
        "memory_bytes": os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"),
        "system": platform.platform(),
        "load_average": os.getloadavg()[0],
        "date": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
        "program": os.path.realpath(program),
    }
    out.update(build_of(os.path.realpath(program)))
    return out


def build_of(program):
    """Compiler, build type and commit of the build tree that a program lies in."""
    folder = os.path.dirname(program)
    while folder != os.path.dirname(folder) and not os.path.exists(os.path.join(folder, "CMakeCache.txt")):
        folder = os.path.dirname(folder)
    out = {"build_type": "", "compiler": "", "commit": ""}
    cache_file = os.path.join(folder, "CMakeCache.txt")
    if not os.path.exists(cache_file):
        return out
    with open(cache_file, encoding="utf-8") as file:
        cache = dict(re.findall(r"^(\w+):\w+=(.*)$", file.read(), re.M))
    out["build_type"] = cache.get("CMAKE_BUILD_TYPE", "")
    compiler = cache.get("CMAKE_CXX_COMPILER", "c++")
    out["compiler"] = first_line([compiler, "--version"]) or compiler
    source = cache.get("CMAKE_HOME_DIRECTORY", "")
    commit = first_line(["git", "-C", source, "rev-parse", "--short=12", "HEAD"])
    changed = first_line(["git", "-C", source, "status", "--porcelain", "--untracked-files=no"])
    out["commit"] = commit + ("+changes" if commit and changed else "")
    return out


def first_line(command):
    try:
        text = subprocess.run(command, capture_output=True, text=True, timeout=20, check=False).stdout
    except (OSError, subprocess.SubprocessError):
        return ""
    return text.splitlines()[0].strip() if text.strip() else ""


def describe(about):
    """The machine in one line."""
    return (f"{about['cpu']}, {about['cores']} cores, {about['memory_bytes'] / 2**30:.0f} GiB; {about['compiler']}, "
            f"{about['build_type'] or 'unknown build'}, commit {about['commit'] or 'unknown'}; load {about['load_average']:.1f}")


def quartiles(values):
    """(25 %, median, 75 %), interpolated."""
    values = sorted(values)

    def at(q):
        x = q * (len(values) - 1)
        i = int(x)
        return values[i] + (x - i) * (values[min(i + 1, len(values) - 1)] - values[i])
    return at(0.25), at(0.5), at(0.75)
