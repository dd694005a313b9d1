"""Signals at random moments: the program ends in under two seconds with 128 and the signal's number, and leaves nothing."""
import os
import random
import signal
import subprocess
import time

import support

SEED = 20261130
MOMENTS = int(os.environ.get("OVERTET_MOMENTS", "200"))
SECONDS = 2.0 if support.FAIL_ALLOCATION != "-" else 20.0  # sanitizers make everything ten times as slow
TRIES = 4  # so often the same moment: a machine that is busy with something else makes single ones late


class Signals(support.Faults):
    def ends(self, words, number, moment):
        """Sends the signal after `moment` seconds: (exit code, seconds that the end took, whether all is well)."""
        for file in self.left():
            os.remove(os.path.join(self.out, file))
        with subprocess.Popen([support.PROGRAM, *words], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                              preexec_fn=support.default_signals) as process:
            time.sleep(moment)
            children = support.children_of(process.pid)
            process.send_signal(number)
            begin = time.monotonic()
            try:
                said = process.communicate(timeout=support.RUN_AWAY)[1]
            except subprocess.TimeoutExpired:
                process.kill()
                raise
            took = time.monotonic() - begin
        for child in children:
            self.assertTrue(support.gone(child), "a process is left over")
        left = set(self.left())
        if process.returncode == 0:  # it was done
            return 0, 0.0
        # Before the program has begun the signal itself ends it: the same for a shell.
        self.assertEqual(support.as_shells_say(process.returncode), 128 + number, said)
        if process.returncode > 0:
            self.assertRegex(said.decode(), r"overtet: Interrupted[^\n]*\.\n$")
        self.assertEqual(left, set(), said)
        return 128 + number, took

    def test_random_moments(self):
        chosen = random.Random(SEED)
        large = os.path.join(self.folder, "large.off")
        support.write_box(large, 40)
        commands = self.commands()
        commands["tetgen"] = ["mesh", large, "-o", f"{self.out}/o.mesh", "--report", f"{self.out}/r.json"]
        takes = {}
        for name, words in commands.items():
            begin = time.monotonic()
            subprocess.run([support.PROGRAM, *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
            takes[name] = time.monotonic() - begin
        # Half of the moments for the runs that take longest.
        names = sorted(commands, key=lambda name: -takes[name])
        worst, ended, done = 0.0, 0, 0
        for i in range(MOMENTS):
            name = names[chosen.randrange(2)] if i % 2 else chosen.choice(names)
            number = chosen.choice((signal.SIGINT, signal.SIGTERM, signal.SIGHUP))
            moment = chosen.random() * takes[name]
            with self.subTest(command=name, signal=number, after=moment, seed=SEED):
                for _ in range(TRIES):
                    code, took = self.ends(commands[name], number, moment)
                    if took < SECONDS:
                        break
                self.assertLess(took, SECONDS)
                worst = max(worst, took)
                ended, done = ended + (code != 0), done + (code == 0)
        print(f"{ended} runs interrupted, {done} were done before; the longest end took {worst:.3f} s")
        self.assertGreater(ended, MOMENTS // 4)

    def test_what_nohup_starts_outlives_the_terminal(self):
        large = os.path.join(self.folder, "nohup.off")
        support.write_box(large, 30)
        with subprocess.Popen([support.PROGRAM, "mesh", large, "-o", f"{self.out}/o.mesh", "-q"],
                              preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN)) as process:
            time.sleep(0.05)
            process.send_signal(signal.SIGHUP)
            self.assertEqual(process.wait(timeout=support.RUN_AWAY), 0)

    def test_a_killed_program_leaves_nothing(self):
        large = os.path.join(self.folder, "killed.off")
        support.write_box(large, 40)
        for moment in (0.02, 0.1, 0.3, 0.6):
            with subprocess.Popen([support.PROGRAM, "mesh", large, "-o", f"{self.out}/o.mesh", "-q"]) as process:
                time.sleep(moment)
                children = support.children_of(process.pid)
                process.kill()
            for child in children:
                self.assertTrue(support.gone(child))
            self.assertEqual(self.left(), [] if process.returncode != 0 else ["o.mesh"])
            for file in self.left():
                os.remove(os.path.join(self.out, file))


if __name__ == "__main__":
    support.main()
