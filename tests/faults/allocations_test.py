"""Allocations that fail: the program ends with exit code 6 and a sentence, or without the memory; it never crashes."""
import os
import random

import support

SEED = 20261130
MOMENTS = int(os.environ.get("OVERTET_MOMENTS", "25"))  # a command


class Allocations(support.Faults):
    def contents(self):
        """Of the outputs; reports have times."""
        texts = {}
        for file in self.left():
            if file != "r.json":
                with open(os.path.join(self.out, file), "rb") as text:
                    texts[file] = text.read()
        return texts

    def try_all(self, name, words, in_program, failing):
        """Runs with an allocation that fails at moments all over the run, and some early on."""
        count = os.path.join(self.folder, "count")
        env = support.preload(support.FAIL_ALLOCATION, OVERTET_FAIL_AT=0, OVERTET_FAIL_IN=in_program,
                              OVERTET_FAIL_COUNT=count)
        run = self.run_program(words, env=env)
        self.assertEqual(run.returncode, 0, run.stderr)
        with open(count, encoding="ascii") as file:
            total = int(file.read())
        whole = self.contents()
        self.assertGreater(total, 100)
        chosen = random.Random(f"{SEED} {name}")
        moments = [1, 2, 3] + [chosen.randint(1, total) for _ in range(MOMENTS)]
        moments += [chosen.randint(1, min(total, 3500)) for _ in range(MOMENTS // 2)]
        ended = {}
        for moment in sorted(set(moments)):
            for file in self.left():
                os.remove(os.path.join(self.out, file))
            env.update(OVERTET_FAIL_AT=str(moment), OVERTET_FAIL_FOR=str(failing))
            with self.subTest(command=name, allocation=moment, failing=failing, of=total):
                run = self.run_program(words, env=env)
                ended[run.returncode] = ended.get(run.returncode, 0) + 1
                self.assertIn(run.returncode, (0, 6), run.stderr)
                if run.returncode == 6:
                    self.expect_one_sentence(run)
                    self.assertIn(b"memory", run.stderr)
                    # What ends while the report is made leaves the whole output.
                    left = self.contents()
                    self.assertEqual({file: whole[file] for file in left}, left)
                    if not left and self.left():
                        self.assertEqual(self.report()["status"], "limit")
                elif "o.mesh" in self.left():
                    self.expect_right_mesh(self.worm, f"{self.out}/o.mesh")
        print(f"{name}, in {in_program}, {failing} from there on, {total} allocations: exit codes {ended}")

    def test_one_fails(self):
        for name, words in self.commands().items():
            self.try_all(name, words, "overtet", 1)

    def test_nothing_is_thrown_through_gmp(self):
        """mpz_mul() has freed its result's limbs when it asks for more: after an exception they were freed twice."""
        words, count = self.commands()["inspect"], os.path.join(self.folder, "count")
        env = support.preload(support.FAIL_ALLOCATION, OVERTET_FAIL_AT=0, OVERTET_FAIL_IN="overtet", OVERTET_FAIL_COUNT=count)
        self.assertEqual(self.run_program(words, env=env).returncode, 0)
        with open(count, encoding="ascii") as file:
            first = int(.41 * int(file.read()))  # where faces are cut, in fractions
        for moment in range(first, first + 200):
            env.update(OVERTET_FAIL_AT=str(moment))
            with self.subTest(allocation=moment):
                run = self.run_program(words, env=env)
                self.assertIn(run.returncode, (0, 6), run.stderr)

    def test_all_fail_from_there_on(self):
        for name in ("flow", "inspect", "repair"):
            self.try_all(name, self.commands()[name], "overtet", 10**12)

    def test_in_tetgens_process(self):
        for failing in (1, 10**12):
            self.try_all("flow", self.commands()["flow"], "overtet-tetgen", failing)

    def test_little_address_space(self):
        """As `ulimit -v` gives it: threads and helpers, too, may then not begin."""
        if support.FAIL_ALLOCATION == "-":
            self.skipTest("NOT TESTED: sanitizers take more address space than there is")
        import resource
        ended = {}
        for mebibytes in range(60, 700, 40):
            run = self.run_program(self.commands()["flow"], preexec_fn=lambda: resource.setrlimit(
                resource.RLIMIT_AS, (mebibytes << 20, mebibytes << 20)))
            with self.subTest(mebibytes=mebibytes):
                ended[run.returncode] = ended.get(run.returncode, 0) + 1
                # Below, the system cannot even load the program.
                if b"error while loading shared libraries" in run.stderr:
                    continue
                self.assertIn(run.returncode, (0, 6), run.stderr)
                if run.returncode == 6:
                    self.expect_one_sentence(run)
        print(f"address space from 60 MiB on: exit codes {ended}")


if __name__ == "__main__":
    support.main()
