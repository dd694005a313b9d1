"""A Slurm of two nodes on this machine, without systemd: everything that it has is in one folder, on ports of its own."""
import getpass
import os
import socket
import subprocess

from .processes import descendants, die_with_parent, kill, parent, run, wait_for

CONFIGURATION = """\
ClusterName=overtet
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
AuthType=auth/munge
# A requeued job waits for cred_expire seconds (120 unless told, no less than 5) before it starts again.
AuthInfo=socket={folder}/munge/socket,cred_expire=5
SlurmUser={user}
SlurmdUser={user}
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SwitchType=switch/none
MpiDefault=none
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool-%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd-%n.pid
SlurmctldLogFile={folder}/log/slurmctld
SlurmdLogFile={folder}/log/slurmd-%n
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
SchedulerParameters=batch_sched_delay=0,bf_interval=1,sched_interval=1,sched_min_interval=0
SlurmdParameters=config_overrides
ReturnToService=2
SlurmdTimeout=10
KillWait=2
{nodes}
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def free_ports(count):
    """Ports of 127.0.0.1 on which nothing listens."""
    sockets = [socket.socket() for _ in range(count)]
    for s in sockets:
        s.bind(("127.0.0.1", 0))
    ports = [s.getsockname()[1] for s in sockets]
    for s in sockets:
        s.close()
    return ports


class LocalSlurm:
    """To be used with `with`: started at its beginning, all of it gone after its end."""

    NODES = ("n1", "n2")

    def __init__(self, folder):
        self.folder = folder
        self.configuration = os.path.join(folder, "slurm.conf")
        self.environment = dict(os.environ, SLURM_CONF=self.configuration)
        self.running = {}

    def __enter__(self):
        for name in ("munge", "state", "log", "spool-n1", "spool-n2"):
            os.makedirs(os.path.join(self.folder, name), mode=0o755)
        host = socket.gethostname().split(".")[0]
        ports = free_ports(1 + len(self.NODES))
        nodes = "\n".join(f"NodeName={name} NodeHostname={host} NodeAddr=127.0.0.1 Port={port} CPUs=1 RealMemory=2000"
                          for name, port in zip(self.NODES, ports[1:]))
        with open(self.configuration, "w", encoding="utf-8") as f:
            f.write(CONFIGURATION.format(host=host, ports=ports, folder=self.folder, user=getpass.getuser(), nodes=nodes))
        key = os.path.join(self.folder, "munge", "key")
        with open(os.open(key, os.O_WRONLY | os.O_CREAT, 0o600), "wb") as f:
            f.write(os.urandom(1024))
        try:
            munge = os.path.join(self.folder, "munge")
            self.start("munged", "--foreground", "--force", f"--key-file={key}", f"--socket={munge}/socket",
                       f"--pid-file={munge}/pid", f"--log-file={munge}/log", f"--seed-file={munge}/seed")
            wait_for("the socket of munged", lambda: os.path.exists(f"{munge}/socket"), 10)
            self.start("slurmctld", "-D", "-f", self.configuration)
            for node in self.NODES:
                self.start_node(node)
            wait_for("two idle nodes", lambda: self.ask("sinfo", "-h", "-o", "%T %D").strip() == "idle 2", 30)
        except BaseException:
            self.__exit__()
            raise
        return self

    def start(self, *command, name=None):
        self.running[name or command[0]] = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            env=self.environment, start_new_session=True, preexec_fn=die_with_parent)

    def start_node(self, node):
        self.start("slurmd", "-D", "-N", node, "-f", self.configuration, name=node)

    def crash_node(self, node, batch):
        """The node with all that runs on it is gone at once, as when the power fails; Slurm is told that it is down."""
        daemon = self.running.pop(node)
        step = batch  # the topmost process of the job: slurmstepd, a child of the daemon or an orphan
        while parent(step) not in (0, 1, daemon.pid):
            step = parent(step)
        kill([daemon.pid] + descendants(step))
        daemon.wait()
        self.ask("scontrol", "update", f"NodeName={node}", "State=DOWN", "Reason=test")

    def ask(self, *command):
        return run(*command, env=self.environment, fails=True)

    def jobs(self):
        """Jobs that have not ended."""
        return self.ask("squeue", "-h", "-r", "-o", "%i %T %N").strip()

    def job(self, number):
        """What Slurm knows of a job or of a task of an array ("12_3")."""
        shown = self.ask("scontrol", "show", "job", "--oneliner", number)
        return dict(word.split("=", 1) for word in shown.split() if "=" in word)

    def __exit__(self, *_):
        if "slurmctld" in self.running:
            self.ask("scancel", "--user", getpass.getuser(), "--full", "--signal=KILL")
            self.ask("scancel", "--user", getpass.getuser())
        for process in reversed(list(self.running.values())):
            process.terminate()
            try:
                process.wait(timeout=5)
            except subprocess.TimeoutExpired:
                kill(descendants(process.pid))
                process.wait()
        self.running = {}
