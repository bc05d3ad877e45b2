"""A Slurm cluster of one node as processes of a test: munge, a controller and a node on this
machine, with a key, sockets, ports and folders of its own. It needs root, as slurmd does."""

import ctypes
import os
import shutil
import signal
import socket
import subprocess
import time

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "scancel", "sinfo")


def why_not():
    """Returns why there can be no cluster here; None: there can be one."""
    for name in PROGRAMS:
        if find(name) is None:
            return f"{name} is not installed"
    if os.geteuid() != 0:
        return "slurmd needs root"
    return None


def end_with_parent():
    """Called in a daemon before it begins: it gets SIGTERM when the test dies, even by a signal."""
    pr_set_pdeathsig = 1
    ctypes.CDLL(None).prctl(pr_set_pdeathsig, signal.SIGTERM)


def find(name):
    return shutil.which(name, path=os.environ.get("PATH", "") + ":/usr/sbin:/sbin")


def version():
    """Returns the year of Slurm's version, 22 of "slurm-wlm 22.05.8"."""
    text = subprocess.run([find("slurmd"), "-V"], capture_output=True, text=True, check=True).stdout
    return int(text.split()[-1].split(".")[0])


def free_ports(count):
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    ports = [s.getsockname()[1] for s in sockets]
    for s in sockets:
        s.close()
    return ports


class Cluster:
    """Use it with `with`: whatever happens inside, all daemons have ended after it."""

    def __init__(self, folder, cpus=2):
        # Sockets have short names, and munge wants folders that nobody else can write to.
        self.folder = folder
        self.cpus = cpus
        self.daemons = []
        self.environment = dict(os.environ, SLURM_CONF=self.path("slurm.conf"))
        for name in [n for n in self.environment if n.startswith(("SLURM_", "SBATCH_"))]:
            if name != "SLURM_CONF":
                del self.environment[name]

    def path(self, name):
        return os.path.join(self.folder, name)

    def __enter__(self):
        try:
            self.start()
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, *unused):
        self.stop()

    def start(self):
        os.makedirs(self.folder, mode=0o700, exist_ok=True)
        for name in ("state", "spool"):
            os.makedirs(self.path(name), exist_ok=True)
        with open(os.open(self.path("munge.key"), os.O_WRONLY | os.O_CREAT, 0o400), "wb") as key:
            key.write(os.urandom(128))
        self.write_configuration()
        self.spawn([find("munged"), "--foreground", "--force",
                    "--socket=" + self.path("munge.socket"),
                    "--key-file=" + self.path("munge.key"),
                    "--log-file=" + self.path("munged.log"),
                    "--pid-file=" + self.path("munged.pid"),
                    "--seed-file=" + self.path("munge.seed")])
        self.wait_for("munge", lambda: os.path.exists(self.path("munge.socket")))
        self.spawn([find("slurmctld"), "-D", "-i", "-f", self.path("slurm.conf")])
        self.wait_for("the controller", lambda: self.run("scontrol", "ping", check=False)[0] == 0)
        self.spawn([find("slurmd"), "-D", "-f", self.path("slurm.conf")])
        self.wait_for("the node", lambda: "idle" in self.run("sinfo", "-h", "-o", "%T")[1])

    def write_configuration(self):
        host = socket.gethostname().split(".")[0]
        controller, node = free_ports(2)
        with open(self.path("slurm.conf"), "w", encoding="ascii") as file:
            file.write(f"""ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller}
SlurmdPort={node}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
# A requeued job waits until its old credential has expired.
AuthInfo=socket={self.path("munge.socket")},cred_expire=5
CredType=cred/munge
StateSaveLocation={self.path("state")}
SlurmdSpoolDir={self.path("spool")}
SlurmctldPidFile={self.path("slurmctld.pid")}
SlurmdPidFile={self.path("slurmd.pid")}
SlurmctldLogFile={self.path("slurmctld.log")}
SlurmdLogFile={self.path("slurmd.log")}
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/builtin
SchedulerParameters=sched_interval=1,batch_sched_delay=0
MpiDefault=none
ReturnToService=2
JobRequeue=1
KillWait=10
MinJobAge=3600
NodeName={host} NodeAddr=127.0.0.1 CPUs={self.cpus} State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP
""")

        # Later versions would else look for control groups that nobody has given to them; earlier
        # ones do not know the word.
        if version() >= 23:
            with open(self.path("cgroup.conf"), "w", encoding="ascii") as file:
                file.write("CgroupPlugin=disabled\n")

    def spawn(self, command):
        log = open(self.path(os.path.basename(command[0]) + ".out"), "wb")
        self.daemons.append(subprocess.Popen(command, stdout=log, stderr=log,
                                             stdin=subprocess.DEVNULL, env=self.environment,
                                             preexec_fn=end_with_parent))
        log.close()

    def wait_for(self, what, ready, seconds=30):
        end = time.monotonic() + seconds
        while not ready():
            if time.monotonic() > end or any(d.poll() is not None for d in self.daemons):
                raise RuntimeError(f"{what} is not up\n{self.logs()}")
            time.sleep(0.1)

    def logs(self):
        text = ""
        for name in sorted(os.listdir(self.folder)):
            if name.endswith((".log", ".out")):
                with open(self.path(name), encoding="utf-8", errors="replace") as file:
                    text += f"--- {name}\n" + file.read()[-4000:]
        return text

    def run(self, name, *arguments, check=True, cwd=None):
        done = subprocess.run([find(name), *arguments], capture_output=True, text=True, cwd=cwd,
                              env=self.environment, check=False)
        if check and done.returncode != 0:
            raise RuntimeError(f"{name} {' '.join(arguments)}: {done.stdout}{done.stderr}")
        return done.returncode, done.stdout

    def tasks(self):
        """Returns the state of every task: {"12_3": "COMPLETED"}, {"13": "PENDING"}."""
        text = self.run("squeue", "-h", "-a", "-r", "-t", "all", "-o", "%i %T")[1]
        return dict(line.split() for line in text.splitlines())

    def wait_for_end(self, seconds=240):
        """Returns the states once no task runs or waits."""
        end = time.monotonic() + seconds
        while True:
            states = self.tasks()
            if not set(states.values()) & {"PENDING", "RUNNING", "COMPLETING", "CONFIGURING",
                                           "REQUEUED", "SUSPENDED", "SIGNALING"}:
                return states
            if time.monotonic() > end:
                raise RuntimeError(f"tasks do not end: {states}\n{self.logs()}")
            time.sleep(0.2)

    def stop(self):
        if len(self.daemons) == 3:
            self.run("scancel", "-u", "root", "--signal=KILL", check=False)
        # The node ends first, so that the controller hears of it.
        for daemon in reversed(self.daemons):
            if daemon.poll() is None:
                daemon.send_signal(signal.SIGTERM)
            try:
                daemon.wait(10)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()
        self.daemons = []
