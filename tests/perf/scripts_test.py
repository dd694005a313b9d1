"""usage: scripts_test.py PROGRAM SOURCE_FOLDER"""
import csv
import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

PROGRAM, SOURCE = sys.argv[1], sys.argv[2]


def script(*arguments, python=sys.executable):
    return subprocess.run([python, "-B", *arguments], capture_output=True, text=True, timeout=100, check=False)


def python_with_numpy():
    """The first of this one and the system's that has numpy, or None."""
    return next((p for p in (sys.executable, "/usr/bin/python3")
                 if os.access(p, os.X_OK) and script("-c", "import numpy", python=p).returncode == 0), None)


class Scripts(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.models = os.path.join(cls.folder.name, "models")
        os.mkdir(cls.models)
        cls.worm = os.path.join(cls.models, "worm.off")
        made = script(os.path.join(SOURCE, "scripts/make_sample"), cls.worm, "420", "8")
        assert made.returncode == 0, made.stderr
        with open(os.path.join(cls.models, "broken.off"), "w", encoding="utf-8") as file:
            file.write("OFF\n3 1 0\n0 0 0\n")
        cls.result = os.path.join(cls.folder.name, "result")
        cls.suite = script(os.path.join(SOURCE, "perf/suite/suite"), "--program", PROGRAM, "--threads", "1,2", "--repeat",
                           "2", "--output", cls.result, cls.models, "--", "--improve", "10")

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def made_and_meshed(self, generator, *options, and_then=()):
        """The report of the mesh of a model that a generator of perf/suite makes; the model and the mesh."""
        model, mesh, report = (os.path.join(self.folder.name, name) for name in ("made.off", "made.mesh", "made.json"))
        made = script(os.path.join(SOURCE, "perf/suite", generator), model, *options)
        self.assertEqual(made.returncode, 0, made.stderr)
        run = subprocess.run([PROGRAM, "mesh", model, "-o", mesh, "--report", report, *and_then],
                             capture_output=True, text=True, timeout=300, check=False)
        self.assertEqual(run.returncode, 0, run.stderr)
        with open(report, encoding="utf-8") as file:
            return json.load(file), model, mesh

    def test_the_flow_route_has_a_table(self):
        result = os.path.join(self.folder.name, "flow")
        run = script(os.path.join(SOURCE, "perf/paper/flow"), "--program", PROGRAM, self.models, "--check",
                     PROGRAM + " verify --quiet", "--output", result)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        self.assertIn("1 of 1 exact", run.stdout)
        with open(result + ".json", encoding="utf-8") as file:
            rows = json.load(file)
        self.assertEqual([(row["model"], row["status"], row["refused"]) for row in rows], [("worm", "exact", [])])
        self.assertIn("patch", {stage["name"] for stage in rows[0]["stages"]})

    def test_limits_are_measured(self):
        """Limits that fall into a run; by how much they are missed belongs to no test."""
        result = os.path.join(self.folder.name, "limits.json")
        run = script(os.path.join(SOURCE, "perf/limits/limits"), "--program", PROGRAM, "--commands", "mesh,inspect", "--points", "2",
                     "--repeat", "1", "--shortest", "0.01", "--least", "1", "--allow", "1e9", "--json", result, self.worm)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        with open(result, encoding="utf-8") as file:
            rows = json.load(file)
        self.assertEqual({row["kind"] for row in rows}, {"time", "memory"})
        self.assertIn("memory: ", run.stdout)

    def test_tangles_with_high_windings_are_meshed(self):
        for tori, turns, least in ((3, 2, 5), (1, 7, 7)):
            data = self.made_and_meshed("make_tangle", str(tori), str(turns), "2000", and_then=("--improve", "0"))[0]["input"]
            self.assertEqual(data["hinges"], 0)
            self.assertGreaterEqual(data["winding_max"], least)

    def test_prints_with_needles_are_meshed(self):
        for options in (("plate", "fan", "400"), ("plate", "strip", "400"), ("plate", "ears", "100"), ("ring", "strip", "600"),
                        ("gear", "ears", "500"), ("gear-ring", "ears", "450", "1")):
            self.made_and_meshed("make_print", *options, and_then=("--improve", "0"))

    def test_surfaces_with_many_hinges_are_repaired(self):
        for kind, faces, least in (("csg", 600, 20), ("scan", 1500, 2)):
            data, model, mesh = self.made_and_meshed("make_hinges", kind, str(faces), and_then=("--on-infeasible", "repair"))
            self.assertGreaterEqual(data["input"]["hinges"], least)
            self.assertEqual(data["status"], "repaired")
            angles = data["moved"]["angles"]
            self.assertLessEqual(angles["least"], angles["bound_as_moved"] + 1e-9)
            verified = subprocess.run([PROGRAM, "verify", model, mesh, "--max-move", "6"], capture_output=True, text=True,
                                      timeout=100, check=False)
            self.assertEqual(verified.returncode, 0, verified.stdout)

    def test_suite_writes_all_runs(self):
        self.assertEqual(self.suite.returncode, 0, self.suite.stdout + self.suite.stderr)
        self.assertIn("1 of 2 solved", self.suite.stdout)
        with open(self.result + ".json", encoding="utf-8") as file:
            data = json.load(file)
        for key in ("cpu", "cores", "memory_bytes", "compiler", "build_type", "commit", "date"):
            self.assertIn(key, data["machine"])
        self.assertEqual(len(data["runs"]), 8)
        worm = [r for r in data["runs"] if r["model"] == "worm"]
        for run in worm:
            self.assertEqual(run["exit_code"], 0)
            self.assertEqual(run["status"], "exact")
            self.assertGreater(run["wall_seconds"], 0)
            self.assertGreater(run["cpu_seconds"], 0)
            self.assertGreater(run["peak_rss_bytes"], 1 << 20)
            self.assertGreater(run["bytes_written"], 1000)
            self.assertEqual(run["report"]["options"]["improve"], 10)
        self.assertEqual(len({r["report"]["result_hash"] for r in worm}), 1)
        self.assertEqual({r["exit_code"] for r in data["runs"] if r["model"] == "broken"}, {3})
        with open(self.result + ".csv", encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), 8)
        self.assertGreater(float(next(r for r in rows if r["model"] == "worm")["verify.seconds"]), 0)

    def test_suite_notices_a_program_that_hangs(self):
        slow = os.path.join(self.folder.name, "slow")
        with open(slow, "w", encoding="utf-8") as file:
            file.write("#!/bin/sh\nsleep 60\n")
        os.chmod(slow, 0o755)
        done = script(os.path.join(SOURCE, "perf/suite/suite"), "--program", slow, "--time-limit", "0.2",
                      "--grace", "0.2", self.worm)
        self.assertEqual(done.returncode, 1)
        self.assertIn("killed", done.stdout)

    def test_compare_lays_results_side_by_side(self):
        done = script(os.path.join(SOURCE, "perf/compare/compare"), self.result + ".json", self.result + ".json", "--key",
                      "tets")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("wall_seconds: B / A median 1.000 [1.000, 1.000]", done.stdout)
        self.assertNotIn("other result", done.stdout)

    def test_compare_runs_two_programs_in_turns(self):
        done = script(os.path.join(SOURCE, "perf/compare/compare"), "--programs", PROGRAM, PROGRAM, "--rounds", "2",
                      "--output", os.path.join(self.folder.name, "turns"), self.worm)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        for letter in "ab":
            with open(os.path.join(self.folder.name, f"turns_{letter}.json"), encoding="utf-8") as file:
                self.assertEqual(len(json.load(file)["runs"]), 2)

    def test_compare_says_what_fails_only_in_b(self):
        bad = os.path.join(self.folder.name, "bad")
        with open(bad, "w", encoding="utf-8") as file:
            file.write("#!/bin/sh\nexit 4\n")
        os.chmod(bad, 0o755)
        done = script(os.path.join(SOURCE, "perf/compare/compare"), "--programs", PROGRAM, bad, "--rounds", "1", self.worm)
        self.assertEqual(done.returncode, 1)
        self.assertIn("PROBLEM worm", done.stdout)

    def test_batch_compares_two_programs(self):
        output = os.path.join(self.folder.name, "batch")
        done = script(os.path.join(SOURCE, "perf/batch/batch"), "--program", PROGRAM, "--program", PROGRAM, "--jobs", "2",
                      "--rounds", "2", "--output", output, self.worm, self.worm)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("2 meshed", done.stdout)
        self.assertIn("0 of 2 results differ", done.stdout)
        with open(output + ".json", encoding="utf-8") as file:
            data = json.load(file)
        self.assertEqual(len(data["runs"]), 8)
        self.assertEqual({run["exit_code"] for run in data["runs"]}, {0})
        with open(self.worm, encoding="utf-8") as file:
            self.assertEqual({run["faces"] for run in data["runs"]}, {int(file.read().split()[2])})

    def test_paper_prints_its_table(self):
        output = os.path.join(self.folder.name, "paper")
        done = script(os.path.join(SOURCE, "perf/paper/paper"), "--program", PROGRAM, "--only", "worm", "--presets",
                      "paper,default", "--output", output)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("| **Cheese** | 15944 |", done.stdout)
        with open(output + ".json", encoding="utf-8") as file:
            rows = json.load(file)
        self.assertEqual([(row["preset"], row["status"]) for row in rows], [("paper", "exact"), ("default", "exact")])
        with open(output + ".md", encoding="utf-8") as file:
            self.assertEqual(file.read(), done.stdout)

    def test_batch_names_what_is_not_answered(self):
        bad = os.path.join(self.folder.name, "crashing")
        with open(bad, "w", encoding="utf-8") as file:
            file.write("#!/bin/sh\nkill -SEGV $$\n")
        os.chmod(bad, 0o755)
        done = script(os.path.join(SOURCE, "perf/batch/batch"), "--program", PROGRAM, "--program", bad, "--rounds", "1",
                      self.models)
        self.assertEqual(done.returncode, 1)
        self.assertIn("A: ", done.stdout)
        self.assertIn("1 meshed, 1 bad input", done.stdout)
        self.assertIn("PROBLEM B: worm.off ended with -11", done.stdout)
        self.assertNotIn("PROBLEM A", done.stdout)

    def peers(self, *arguments):
        python = python_with_numpy()
        if python is None:
            self.skipTest("numpy is missing")
        return script(os.path.join(SOURCE, "perf/peers/peers"), *arguments, python=python)

    def test_peers_judges_all_alike_and_says_who_refuses(self):
        found = [p for p in ("tetgen", "gmsh") if shutil.which(p)]
        programs = ["overtet", "overtet-0"] + ["tetgen-q"] * ("tetgen" in found) + ["hxt"] * ("gmsh" in found)
        tube, output = os.path.join(self.folder.name, "print.off"), os.path.join(self.folder.name, "peers")
        made = script(os.path.join(SOURCE, "perf/suite/make_tangle"), tube, "1", "1", "800")
        self.assertEqual(made.returncode, 0, made.stderr)
        done = self.peers("--overtet", PROGRAM, "--programs", ",".join(programs), "--threads", "1", "--repeat", "2",
                          "--output", output, tube, self.worm)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        with open(output + ".json", encoding="utf-8") as file:
            rows = json.load(file)["runs"]
        self.assertEqual(len(rows), 4 * len(programs))
        for row in rows:
            crosses, own = row["model"] == "worm", row["program"].startswith("overtet")
            self.assertEqual(row["end"], "refused" if crosses and not own else "meshed", row)
            self.assertEqual(bool(row["reason"]), row["end"] == "refused", row)
            self.assertGreater(row["peak_bytes"], 1 << 20)
            if row["end"] == "meshed":
                self.assertGreater(row["tets"], 100)
                self.assertLess(row["least"], row["percent"])
        self.assertIn("| worm | ", done.stdout)

    def test_peers_shows_runs_over_their_limits(self):
        done = self.peers("--overtet", PROGRAM, "--programs", "overtet", "--threads", "1", "--repeat", "2",
                          "--memory-limit", "1", self.worm)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("killed: memory limit", done.stdout)

    def test_angles_of_written_meshes_are_those_of_the_report(self):
        report = os.path.join(self.folder.name, "angles.json")
        for extension in (".msh", ".node"):
            mesh = os.path.join(self.folder.name, "angles" + extension)
            run = subprocess.run([PROGRAM, "mesh", self.worm, "-o", mesh, "--report", report], capture_output=True, text=True,
                                 timeout=100, check=False)
            self.assertEqual(run.returncode, 0, run.stderr)
            with open(report, encoding="utf-8") as file:
                quality = json.load(file)["quality"]
            done = self.peers("--judge", mesh)
            self.assertEqual(done.returncode, 0, done.stderr)
            judged = json.loads(done.stdout)
            self.assertEqual(judged["tets"], quality["tets"])
            self.assertEqual(judged["turned"], 0)
            self.assertAlmostEqual(judged["least"], quality["dihedral_min"], 9)
            self.assertAlmostEqual(judged["percent"], quality["dihedral_p01"], delta=.3)  # the next of few angles
            self.assertAlmostEqual(judged["volume"] / quality["volume"], 1, 12)

    def test_the_program_starts_without_what_few_runs_need(self):
        loaded = subprocess.run([PROGRAM], env={**os.environ, "LD_TRACE_LOADED_OBJECTS": "1"}, capture_output=True, text=True,
                                timeout=100, check=True).stdout
        self.assertIn("libtbb", loaded)
        for library in ("libcholmod", "libblas", "libgomp"):
            self.assertNotIn(library, loaded)

    def test_wrong_usage(self):
        for arguments in (["perf/suite/suite", "--program", PROGRAM, "no_such_file.off"],
                          ["perf/batch/batch", "--program", PROGRAM, "no_such_file.off"],
                          ["perf/paper/paper", "--program", PROGRAM, "--presets", "none"],
                          ["perf/peers/peers", "--overtet", PROGRAM, "--programs", "overtet", "no_such_file.off"],
                          ["perf/compare/compare", "no_such_file.json", "no_such_file.json"],
                          ["scripts/profile", "--program", PROGRAM, "no_such_file.off"]):
            self.assertEqual(script(os.path.join(SOURCE, arguments[0]), *arguments[1:]).returncode, 2, arguments)

    def test_profile_names_rooms(self):
        done = script(os.path.join(SOURCE, "scripts/profile"), "--program", PROGRAM, self.worm)
        if done.returncode == 1:  # neither sampling nor valgrind here: said in one sentence
            self.assertNotIn("Traceback", done.stderr)
            return
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("Rooms", done.stdout)
        self.assertIn("src/", done.stdout)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
