"""The batch with each engine, interrupted in every way that the engine knows, and what must have come of it."""
import os
import signal
import subprocess
import time

from .local_slurm import LocalSlurm
from .processes import Failure, batch_of, die_with_parent, hold, kill, run, stop_worker, wait_for, workers_of
from .results import Snapshot, check_results, finished, lines_of

CLUSTER = os.path.join(os.path.dirname(os.path.realpath(__file__)), "..")
SECONDS = 60  # that anything may take at most
MEMORY = 900  # MiB of a job: a node of the test has 2000


class Test:
    """What all engines get: the models, the wanted answers, and folders."""

    def __init__(self, program, folder, models, wanted):
        self.program, self.folder, self.models, self.wanted = program, folder, models, wanted
        self.environment = dict(os.environ, OVERTET=program)

    def out(self, name):
        return os.path.join(self.folder, name)

    def hold_half_done(self, out, shards, engine=None):
        """Waits until one of these shards has finished a model and is at work on another; stops its batch. Both."""
        def half_done():
            if engine and engine.poll() is not None:
                raise Failure(f"the engine ended with {engine.returncode} before any of the shards {' '.join(shards)} was "
                              f"half done: {self.log(engine)}")
            for shard in shards:
                batch = batch_of(out, shard) if finished(out, shard) else 0
                if batch and hold(batch):
                    return shard, batch
            return None
        return wait_for(f"one of the shards {' '.join(shards)} to be half done", half_done, SECONDS)

    def log_path(self, command):
        return os.path.join(self.folder, os.path.basename(command[0]) + ".log")

    def log(self, process):
        """The last lines that a program has written, which `start` began."""
        return b"".join(lines_of(self.log_path(process.args))[-20:]).decode(errors="replace")

    def start(self, *command, **more):
        """A program whose output goes to a file, in a session of its own, as a terminal would give it."""
        with open(self.log_path(command), "a", encoding="utf-8") as log:
            return subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True,
                                    preexec_fn=die_with_parent, env=self.environment, cwd=self.folder, **more)

    def check(self, out, snapshots):
        done = max(s.check() for s in snapshots)
        seen = check_results(out, self.wanted)
        before = finished(out)
        run(self.program, "batch", self.models, "-o", out, "--resume")  # the whole list, after its shards
        if finished(out) != before:
            raise Failure(f"a batch of the whole list does again what its shards have done into {out}")
        return f"{seen}; of {done} done at the last interruption none was repeated"


def say(text):
    print(f"{time.strftime('%H:%M:%S')} {text}", flush=True)


def interrupt_group(process):
    """Ctrl-C in the terminal of a process, and again if it takes it for a hint."""
    for _ in range(2):
        try:
            os.killpg(process.pid, signal.SIGINT)
        except ProcessLookupError:
            pass
        try:
            return process.wait(timeout=10)
        except subprocess.TimeoutExpired:
            pass
    raise Failure("Ctrl-C did not end it in 20 s")


def kill_and_interrupt(test, engine, out, shards, goes_on):
    """Kills the batch of a shard that is half done (and waits until it goes on), then presses Ctrl-C. What was done then."""
    all_shards = [f"{i}/{shards}" for i in range(1, shards + 1)]

    killed, batch = test.hold_half_done(out, all_shards, engine)
    snapshots = [Snapshot(out)]
    kill([batch])
    if goes_on:
        wait_for(f"shard {killed} to go on", lambda: batch_of(out, killed) not in (0, batch), SECONDS)
    _, batch = test.hold_half_done(out, [s for s in all_shards if s != killed], engine)
    snapshots.append(Snapshot(out))
    batches = [b for b in (batch_of(out, s) for s in all_shards) if b]
    workers = [w for b in batches for w in workers_of(b)]
    kill([batch], signal.SIGCONT)
    if interrupt_group(engine) == 0:
        raise Failure("the engine ended with 0 although it was interrupted")
    wait_for("no batch and no worker after Ctrl-C",
             lambda: not any(os.path.exists(f"/proc/{pid}") for pid in batches + workers), 20)
    return snapshots


# --- Slurm

def hurt(slurm, test, out, job, shards):
    """One sort of interruption for each shard, when it is half done. What was done then."""
    snapshots = []

    def half_done(shard):
        _, batch = test.hold_half_done(out, [f"{shard}/{shards}"])
        snapshots.append(Snapshot(out))
        return batch

    def requeued(shard, what, by):
        wait_for(f"shard {shard} to be requeued", lambda: int(slurm.job(f"{job}_{shard}").get("Restarts", 0)) > 0, SECONDS)
        say(f"  shard {shard}: {what}; requeued by {by}")

    # The first waits for Slurm to look at the time, on one node, while the other node has the rest.
    stop_worker(half_done(1))
    slurm.ask("scontrol", "update", f"JobId={job}_1", "TimeLimit=1")
    kill([half_done(2)])
    requeued(2, "its batch killed (kill -9)", "slurm_job")
    kill(stop_worker(half_done(3)))
    say("  shard 3: a worker killed (kill -9); the batch tries its model again")
    half_done(4)
    slurm.ask("scontrol", "requeue", f"{job}_4")
    requeued(4, "scontrol requeue", "Slurm")
    batch = half_done(5)
    node = slurm.job(f"{job}_5")["NodeList"]
    slurm.crash_node(node, batch)
    requeued(5, f"its node {node} down, all processes there killed", "Slurm")
    slurm.start_node(node)
    snakemake = start_snakemake_on_slurm(slurm, test)
    requeued(1, "its workers stopped, so that it met the time limit of its job", "slurm_job")
    return snapshots, snakemake


def start_snakemake_on_slurm(slurm, test):
    """A manifest of a few of the models, as every job of this kind starts Snakemake once more."""
    names = sorted(test.wanted)[::4]
    manifest = os.path.join(test.models, "some.txt")
    with open(manifest, "w", encoding="utf-8") as f:
        f.writelines(f"{name}.off\n" for name in names)
    submit = "sbatch --parsable --cpus-per-task={threads} --mem={resources.mem_mb} --output=/dev/null"
    process = test.start("snakemake", "-s", f"{CLUSTER}/Snakefile", "--jobs", "2", "--latency-wait", "20", "--retries", "1",
                         "--cluster", submit, "--cluster-status", f"{CLUSTER}/slurm_status", "--config",
                         f"models={manifest}", f"out={test.out('some out')}", "shards=2", "threads=1", f"mem_mb={MEMORY}")

    def running():
        jobs = [line.split() for line in slurm.ask("squeue", "-h", "-o", "%i %T %j").splitlines()]
        return next((job for job, state, name in jobs if state == "RUNNING" and name.startswith("snakejob.shard")), None)
    slurm.ask("scancel", wait_for("a job of Snakemake to run", running, 2 * SECONDS))
    return process, names


def test_slurm(test):
    out = test.out("slurm out")
    shards = 5
    with LocalSlurm(test.out("daemons")) as slurm:
        say(f"Slurm: {slurm.ask('sinfo', '--version').strip()}, nodes {' '.join(slurm.NODES)} on this machine")
        test.environment["SLURM_CONF"] = slurm.configuration
        submitted = run(os.path.join(CLUSTER, "slurm"), test.models, out, "--shards", str(shards), "--cpus-per-task=1",
                        f"--mem={MEMORY}", "--time=10", env=test.environment, cwd=test.folder)
        say(f"  {submitted.strip().splitlines()[-1]}")
        job = submitted.split("as job ")[1].split(",")[0]
        snapshots, (snakemake, names) = hurt(slurm, test, out, job, shards)
        wait_for("the summary", lambda: slurm.job(submitted.split("as job ")[2].split(".")[0])["JobState"] == "COMPLETED",
                 2 * SECONDS)
        say(f"  {test.check(out, snapshots)}")
        if not all(0 < e["memory_limit_bytes"] <= MEMORY * 2**20 for e in finished(out)):
            raise Failure(f"models were allowed more than the {MEMORY} MiB of the job")
        if not any(e["tries"] == 2 for e in finished(out, f"3/{shards}")):
            raise Failure("the journal of shard 3 does not say that a model was tried twice, whose worker was killed")
        if snakemake.wait(timeout=2 * SECONDS) != 0:
            raise Failure(f"Snakemake with --cluster sbatch: exit code {snakemake.returncode}; see snakemake.log")
        if not any(b"Trying to restart job" in line for line in lines_of(test.out("snakemake.log"))):
            raise Failure("Snakemake has not restarted the job that was cancelled")
        say(f"Snakemake, --cluster sbatch, {len(names)} models of a manifest, one of two jobs cancelled:")
        say(f"  {check_results(test.out('some out'), {name: test.wanted[name] for name in names})}")


# --- Snakemake on this machine

def test_snakemake(test):
    out = test.out("snakemake out")
    command = ("snakemake", "-s", f"{CLUSTER}/Snakefile", "--cores", "2", "--retries", "1", "--rerun-incomplete",
               "--config", f"models={test.models}", f"out={out}", "shards=3", "threads=1", f"mem_mb={MEMORY}")
    snakemake = test.start(*command)
    snapshots = kill_and_interrupt(test, snakemake, out, 3, goes_on=True)
    say("Snakemake: a shard killed (kill -9), which goes on by --retries; Ctrl-C")
    run(*command, env=test.environment, cwd=test.folder)
    say(f"  the same command again: {test.check(out, snapshots)}")


# --- GNU parallel

def test_parallel(test):
    out = test.out("parallel out")
    machines = test.out("machines")
    test.environment["SSH_LOG"] = machines
    command = (f"{CLUSTER}/parallel", test.models, out, "--shards", "4", "--ssh", f"{CLUSTER}/testing/ssh",
               "--sshlogin", "first,second", "--", "--jobs", "1")
    snapshots = kill_and_interrupt(test, test.start(*command), out, 4, goes_on=False)
    say("GNU parallel, two machines behind a stand-in for ssh: a shard killed (kill -9); Ctrl-C while two are at work")
    run(*command, env=test.environment, cwd=test.folder)
    say(f"  the same command again: {test.check(out, snapshots)}")
    before = lines_of(os.path.join(out, "parallel", "joblog"))
    run(*command, env=test.environment, cwd=test.folder)
    if lines_of(os.path.join(out, "parallel", "joblog")) != before:
        raise Failure("the same command runs shards again that are done")
    say("  and again: no shard is run")
    with open(machines, encoding="ascii") as f:
        if set(f.read().split()) != {"first", "second"}:
            raise Failure("GNU parallel did not use both machines")


ENGINES = {"slurm": test_slurm, "snakemake": test_snakemake, "parallel": test_parallel}
