"""Limits at many places of a run: exit code 6 and a report that says so, nothing left over. (perf/limits measures by how much
they are missed: times belong to no test.)"""
import os
import subprocess
import time

import support

POINTS = 12


class Limits(support.Faults):
    def free(self, words):
        """Seconds and MiB of a run without limits."""
        begin = time.monotonic()
        process = subprocess.Popen([support.PROGRAM, *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        self.assertEqual(process.returncode, 0)
        return time.monotonic() - begin, usage.ru_maxrss / 1024

    def expect_limit_or_success(self, words, kind, limit):
        for file in self.left():
            os.remove(os.path.join(self.out, file))
        with subprocess.Popen([support.PROGRAM, *words, f"--{kind}-limit", f"{limit:.6f}"], stdout=subprocess.DEVNULL,
                              stderr=subprocess.PIPE) as process:
            children = set()
            while process.poll() is None:
                children.update(support.children_of(process.pid))
                time.sleep(0.002)
            said = process.stderr.read().decode()
        self.assertIn(process.returncode, (0, 6), said)
        for child in children:
            self.assertTrue(support.gone(child), "a process is left over")
        if process.returncode == 0:
            if "o.mesh" in self.left():
                self.expect_right_mesh(words[1], f"{self.out}/o.mesh")
            return 0
        self.assertRegex(said, rf"overtet: [^\n]*{kind}[^\n]*--{kind}-limit\.\n$")
        self.assertLessEqual(set(self.left()), {"r.json"})
        if "--report" in words and self.left():
            self.assertEqual(self.report()["status"], "limit")
        return 6

    def try_all(self, kind):
        large = os.path.join(self.folder, "large.off")
        support.write_box(large, 30)
        commands = self.commands()
        commands["tetgen"] = ["mesh", large, "-o", f"{self.out}/o.mesh", "--report", f"{self.out}/r.json"]
        commands["diagnosis"] = ["inspect", large]
        for name, words in commands.items():
            whole = self.free(words)[0 if kind == "time" else 1]
            ended = {}
            for i in range(1, POINTS + 1):
                with self.subTest(command=name, limit=whole * i / POINTS):
                    code = self.expect_limit_or_success(words, kind, whole * i / POINTS)
                    ended[code] = ended.get(code, 0) + 1
            print(f"{name}: {kind} limits at parts of {whole:.3g}: exit codes {ended}")
            with self.subTest(command=name):
                self.expect_limit_or_success(words, kind, 1e-6)
                self.assertEqual(self.expect_limit_or_success(words, kind, 1e6), 0)

    def test_time(self):
        self.try_all("time")

    def test_memory(self):
        self.try_all("memory")

    def test_a_full_pipe_does_not_hold_up_the_end(self):
        """What is printed is not read, nor what is said."""
        words = self.commands()["inspect"]
        read, write = os.pipe()
        os.set_blocking(write, False)
        try:
            while True:
                os.write(write, bytes(4096))
        except BlockingIOError:
            os.set_blocking(write, True)
        with subprocess.Popen([support.PROGRAM, *words, "--time-limit", "1"], stdout=write, stderr=write) as process:
            self.assertEqual(process.wait(timeout=support.RUN_AWAY), 6)
        os.close(read)
        os.close(write)


if __name__ == "__main__":
    support.main()
