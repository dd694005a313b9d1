"""Files, folders, names and clocks that misbehave."""
import json
import os
import resource
import shutil
import signal
import stat
import subprocess
import tempfile
import threading
import time

import support

# Bytes, because not all are UTF-8.
NAMES = [b"with space", b"with\nnew line", b"it's \"quoted\"", b"-leading", b"--version", b"tab\tand\x01control\x7f", b"not utf-8 \xff\xfe",
         b"half a character \xc3", b"$(touch no) `x`; rm *", b"\\back\\slash", b"%s%n%d", b".hidden", b"caf\xc3\xa9 \xe2\x82\xac", b"x" * 200,
         b"x" * 250]


def write_while(path, until, how):
    """Goes on writing to a file until it is told not to."""
    with open(path, "rb") as file:
        whole = file.read()
    while not until.is_set():
        if how == "replace":
            with open(path + ".new", "wb") as file:
                file.write(whole)
            os.rename(path + ".new", path)
        else:
            with open(path, "r+b" if how == "rewrite" else "wb") as file:
                file.write(whole)
                if how == "grow":
                    file.write(b"# more\n" * 100)


class Files(support.Faults):
    def test_hostile_names(self):
        for name in NAMES:
            folder = os.path.join(self.out.encode(), name)
            os.mkdir(folder)
            source = os.path.join(folder, name[:250] + b".off")
            shutil.copy(self.worm, source)
            out, report, surface = (os.path.join(folder, (b"o" + name)[:247] + ending) for ending in (b".mesh", b".json", b".ply"))
            with self.subTest(name=name):
                run = self.run_program(["mesh", source, "-o", out, "--report", report])
                self.assertEqual(run.returncode, 0, run.stderr)
                self.assertEqual(run.stderr.count(b"\n"), 1, run.stderr)  # a message is one line
                with open(report, "rb") as file:
                    text = file.read().decode("utf-8")  # JSON is UTF-8
                data = json.loads(text)
                if b"\xff" not in name and b"\xc3" != name[-1:]:
                    self.assertEqual(data["options"]["input"], source.decode())
                for words in (["verify", source, out, "--json"], ["inspect", source, "--json"]):
                    run = self.run_program(words)
                    self.assertEqual(run.returncode, 0, run.stderr)
                    json.loads(run.stdout.decode("utf-8"))
                for words in (["repair", source, "-o", surface, "--report", report],
                              ["prepare", source, "--all", "-o", surface, "--report", report],
                              ["convert", out, os.path.join(folder, b"c.vtu")],
                              ["mesh", source, "-o", out, "--save-map", report, "--save-surface", surface]):
                    run = self.run_program(words)
                    self.assertEqual(run.returncode, 0, run.stderr)
                    if report in words:
                        with open(report, "rb") as file:
                            json.loads(file.read().decode("utf-8"))
                # From inside the folder, where names begin with dashes.
                run = self.run_program(["inspect", "--", name[:250] + b".off"], cwd=folder)
                self.assertEqual(run.returncode, 0, run.stderr)
                # What is wrong with such a file is said on one line, in a report that is JSON.
                with open(source, "wb") as file:
                    file.write(b"OFF\n3 1 0\n")
                run = self.run_program(["mesh", source, "-o", out, "--report", report])
                self.assertEqual(run.returncode, 3, run.stderr)
                self.assertEqual(run.stderr.count(b"\n"), 1, run.stderr)
                with open(report, "rb") as file:
                    self.assertEqual(json.loads(file.read().decode("utf-8"))["status"], "bad-input")

    def test_names_that_are_too_long(self):
        for words in (["inspect", "x" * 300], ["inspect", "x/" * 3000], ["mesh", self.worm, "-o", f"{self.out}/{'x' * 300}.mesh"],
                      ["mesh", self.worm, "-o", f"{self.out}/o.mesh", "--report", "x/" * 3000 + "r.json"]):
            run = self.run_program(words)
            self.assertEqual(run.returncode, 7, run.stderr)
            self.expect_one_sentence(run)
            self.assertEqual(self.left(), [])

    def test_links(self):
        """Links are followed, and what they lead to is replaced; broken and circular ones are errors of reading."""
        real = os.path.join(self.out, "real.off")
        shutil.copy(self.worm, real)
        os.symlink(real, f"{self.out}/link.off")
        os.symlink(f"{self.out}/there.mesh", f"{self.out}/link.mesh")
        os.symlink("nowhere.off", f"{self.out}/broken.off")
        os.symlink("circle.off", f"{self.out}/circle.off")
        run = self.run_program(["mesh", f"{self.out}/link.off", "-o", f"{self.out}/link.mesh"])
        self.assertEqual(run.returncode, 0, run.stderr)
        self.expect_right_mesh(real, f"{self.out}/link.mesh")
        run = self.run_program(["mesh", f"{self.out}/link.off", "-o", f"{self.out}/o.mesh", "--report", f"{self.out}/link.off"])
        self.assertEqual(run.returncode, 2, run.stderr)
        for name in ("broken.off", "circle.off"):
            run = self.run_program(["mesh", f"{self.out}/{name}", "-o", f"{self.out}/o.mesh"])
            self.assertEqual(run.returncode, 7, run.stderr)
            self.expect_one_sentence(run)
        run = self.run_program(["mesh", self.worm, "-o", f"{self.out}/circle.off/o.mesh"])
        self.assertEqual(run.returncode, 7, run.stderr)

    def test_files_that_change_while_they_are_read(self):
        for how, codes in (("grow", [7]), ("truncate", [7]), ("rewrite", [7]), ("replace", [0])):
            for command in ("mesh", "inspect", "prepare", "repair"):
                source = os.path.join(self.out, "in.off")
                shutil.copy(self.worm, source)
                words = [source if word == self.worm else word for word in self.commands()[command]]
                with self.subTest(how=how, command=command):
                    run = self.run_program(words, env=support.preload(support.ODD_SYSTEM, OVERTET_CHANGE=source, OVERTET_HOW=how))
                    self.assertIn(run.returncode, codes, run.stderr)
                    if how == "replace":  # what was opened is read to its end
                        continue
                    self.expect_one_sentence(run)
                    self.assertIn(b"changed while it was read", run.stderr)
                    self.assertLessEqual(set(self.left()), {"in.off", "r.json"})
                for file in self.left():
                    os.remove(os.path.join(self.out, file))

    def test_files_that_somebody_writes_to(self):
        for how in ("rewrite", "truncate", "grow", "replace"):
            source = os.path.join(self.out, "in.off")
            shutil.copy(self.worm, source)
            until = threading.Event()
            writer = threading.Thread(target=write_while, args=(source, until, how))
            writer.start()
            ended = {}
            try:
                for _ in range(40):
                    run = self.run_program(["inspect", source])
                    ended[run.returncode] = ended.get(run.returncode, 0) + 1
                    self.assertIn(run.returncode, (0, 3, 7), run.stderr)
            finally:
                until.set()
                writer.join()
            print(f"a file that somebody writes to ({how}): exit codes {ended}")

    def test_the_clock_is_set_meanwhile(self):
        env = support.preload(support.ODD_SYSTEM, OVERTET_CLOCK=1)
        for name, words in self.commands().items():
            with self.subTest(command=name):
                run = self.run_program([*words, "--time-limit", "100"], env=env)
                self.assertEqual(run.returncode, 0, run.stderr)
                if "r.json" in self.left():
                    self.assertTrue(0 <= self.report()["seconds"] < 100)
        with open(self.mesh, "rb") as one, open(f"{self.out}/o.mesh", "rb") as other:
            text = other.read()
            self.assertTrue(one.read() == text or b"Tetrahedra" in text)
        large = os.path.join(self.out, "large.off")
        support.write_box(large, 100)
        before = time.monotonic()
        run = self.run_program(["mesh", large, "-o", f"{self.out}/l.mesh", "--time-limit", "0.3"], env=env)
        self.assertEqual(run.returncode, 6, run.stderr)
        self.assertLess(time.monotonic() - before, 60)  # days, if it looked at the time of day

    def test_a_limit_of_the_size_of_files(self):
        """`ulimit -f` sends a signal that ends programs."""
        for name, words in self.commands().items():
            for limit in (0, 1, 1000, 20000):
                with self.subTest(command=name, bytes=limit):
                    run = self.run_program(words, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
                    self.assertIn(run.returncode, (0, 7), run.stderr)
                    if run.returncode == 7:
                        self.expect_one_sentence(run)
                        self.assertLessEqual(set(self.left()), {"r.json"} if limit < 20000 else {"r.json", "o.mesh", "o.off"})
                    for file in self.left():
                        os.remove(os.path.join(self.out, file))
        with open(f"{self.out}/printed", "wb") as printed:
            run = subprocess.run([support.PROGRAM, "inspect", self.worm, "--json"], stdout=printed, stderr=subprocess.PIPE, check=False,
                                 preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100)))
        self.assertEqual(run.returncode, 7, run.stderr)

    def test_a_disk_that_is_full(self):
        disk = os.path.join(self.out, "disk")
        os.mkdir(disk)
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "none", disk], capture_output=True, check=False).returncode != 0:
            self.skipTest("NOT TESTED: a small disk can only be mounted by root")
        try:
            for room in (0, 4096, 20000, 48000):
                with open(f"{disk}/fill", "wb") as file:
                    file.write(bytes(65536 - room))
                for name, words in self.commands().items():
                    words = [word.replace(self.out, disk) for word in words]
                    with self.subTest(command=name, room=room):
                        run = self.run_program(words)
                        self.assertIn(run.returncode, (0, 7), run.stderr)
                        if run.returncode == 7:
                            self.expect_one_sentence(run)
                        left = set(os.listdir(disk)) - {"fill"}
                        self.assertFalse([file for file in left if file.startswith(".")], "unfinished files")
                        if name in ("mesh", "flow") and "o.mesh" in left:
                            self.expect_right_mesh(self.worm, f"{disk}/o.mesh")
                        for file in left:
                            os.remove(os.path.join(disk, file))
                os.remove(f"{disk}/fill")
        finally:
            subprocess.run(["umount", disk], check=True)

    def test_the_output_folder_goes_away(self):
        for number in range(20):
            folder = os.path.join(self.out, "there")
            os.mkdir(folder)
            words = [word.replace(self.out, folder) for word in self.commands()["flow"]]
            with subprocess.Popen([support.PROGRAM, *words, "-q"], stderr=subprocess.PIPE) as process:
                time.sleep(0.02 * number)
                shutil.rmtree(folder, ignore_errors=True)
                said = process.communicate(timeout=support.RUN_AWAY)[1]
            self.assertIn(process.returncode, (0, 7), said)
            if process.returncode == 7:
                self.assertRegex(said.decode(), r"there is no folder|has gone since the run began|No such file")
            shutil.rmtree(folder, ignore_errors=True)

    def test_folders_that_cannot_be_written_to(self):
        folder = os.path.join(self.out, "closed")
        os.mkdir(folder)
        os.chmod(folder, stat.S_IRUSR | stat.S_IXUSR)
        if os.access(folder, os.W_OK):
            self.skipTest("NOT TESTED: root may write everywhere")
        run = self.run_program(["mesh", self.worm, "-o", f"{folder}/o.mesh"])
        self.assertEqual(run.returncode, 7, run.stderr)
        self.expect_one_sentence(run)

    def test_who_reads_what_is_printed_goes_away(self):
        for name in ("inspect", "verify"):
            with subprocess.Popen([support.PROGRAM, *self.commands()[name]], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                  preexec_fn=lambda: signal.signal(signal.SIGPIPE, signal.SIG_DFL)) as process:
                process.stdout.close()
                said = process.stderr.read()
            self.assertEqual(process.wait(), 7, said)


if __name__ == "__main__":
    support.main()
