"""What can happen to TetGen's process: the program goes on without it or says what was wrong, and takes no harm."""
import os
import shutil
import signal
import subprocess
import time

import support

# What stands in for overtet-tetgen: it has the program's socket as descriptors 0 and 1. MAGIC, DONE, six numbers.
REPLY = "import struct, sys, time, os\nreply = lambda *n: struct.pack('<IIqqqqqq', 0x4f54475a, *n)\n"
HELPERS = {
    "ends at once": "sys.exit(0)",
    "ends with an error": "sys.exit(3)",
    "is killed": "os.kill(os.getpid(), 9)",
    "aborts": "os.abort()",
    "prints garbage": "os.write(1, os.urandom(100000))",
    "prints garbage and stays": "os.write(1, b'x' * 56); time.sleep(1000)",
    "answers half": "os.write(1, reply(0, 0, 0, 1000, 3000, 300, 5)); os.write(1, bytes(1000))",
    "counts what cannot be": "os.write(1, reply(0, 0, 0, 2**60, 2**60, 2**60, 5)); time.sleep(1000)",
    "counts less than nothing": "os.write(1, reply(0, 0, 0, -1, -1, -1, 5))",
    "knows no such end": "os.write(1, reply(99, 0, 0, 0, 0, 0, 5))",
    "has no memory": "os.write(1, reply(3, 0, 0, 0, 0, 0, 5))",
    "names vertices that do not exist": "os.write(1, reply(0, 0, 0, 100000, 10, 10, 5)); "
                                        "os.write(1, bytes(2400000) + b'\\x7f' * 320 + b'\\x7f' * 200)",
    "sends no numbers": "os.write(1, reply(0, 0, 0, 100000, 10, 10, 5)); os.write(1, b'\\xff' * 2400000 + bytes(520))",
}


class Tetgen(support.Faults):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.bin = os.path.join(cls.folder, "bin")
        os.mkdir(cls.bin)
        cls.program = shutil.copy(support.PROGRAM, cls.bin)

    def use(self, body):
        path = os.path.join(self.bin, "overtet-tetgen")
        with open(path, "w", encoding="ascii") as file:
            file.write(f"#!/usr/bin/python3 -SE\n{REPLY}{body}\n")
        os.chmod(path, 0o755)

    def expect_no_harm(self, run):
        self.assertIn(run.returncode, (0, 4, 6), run.stderr)
        if run.returncode == 0:
            self.expect_right_mesh(self.box, f"{self.out}/o.mesh")
        else:
            self.expect_one_sentence(run)
            self.assertEqual(self.left(), ["r.json"])
            self.assertEqual(self.report()["status"], {4: "unsolved", 6: "limit"}[run.returncode])

    def test_helpers_that_go_wrong(self):
        for name, body in HELPERS.items():
            for preset in ("default", "flow"):
                self.use(body)
                with self.subTest(helper=name, preset=preset):
                    run = self.run_program(["mesh", self.box, "--preset", preset, "-o", f"{self.out}/o.mesh", "--report",
                                            f"{self.out}/r.json", "--time-limit", "60"], program=self.program)
                    print(f"{name}, {preset}: exit code {run.returncode}: {run.stderr.decode().strip()[:90]}")
                    self.expect_no_harm(run)
                    for file in self.left():
                        os.remove(os.path.join(self.out, file))

    def test_one_that_hangs_keeps_no_limit_waiting(self):
        self.use("time.sleep(1000)")
        run = self.run_program(["mesh", self.box, "-o", f"{self.out}/o.mesh", "--report", f"{self.out}/r.json", "--time-limit",
                                "2"], program=self.program)
        self.assertEqual(run.returncode, 6, run.stderr)
        self.assertEqual(self.report()["status"], "limit")

    def test_signals_for_the_real_one(self):
        """Killed, and stopped for a while, in the middle of its work."""
        large = os.path.join(self.folder, "large.off")
        support.write_box(large, 60)
        for number in (signal.SIGKILL, signal.SIGTERM, signal.SIGSTOP):
            with self.subTest(signal=number), subprocess.Popen(
                    [support.PROGRAM, "mesh", large, "-o", f"{self.out}/o.mesh", "--report", f"{self.out}/r.json", "-q"],
                    stderr=subprocess.PIPE) as process:
                children = []
                while not children and process.poll() is None:
                    children = support.children_of(process.pid)
                    time.sleep(0.001)
                self.assertTrue(children)
                time.sleep(0.02)
                try:
                    os.kill(children[0], number)
                    time.sleep(0.5)
                    os.kill(children[0], signal.SIGCONT)
                except ProcessLookupError:
                    pass
                said = process.communicate(timeout=support.RUN_AWAY)[1]
                self.assertIn(process.returncode, (0, 4, 6), said)
                self.assertTrue(support.gone(children[0]))


if __name__ == "__main__":
    support.main()
