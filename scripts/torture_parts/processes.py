"""The solver as processes: started with limits, watched, signalled, killed, and what came of it."""

import os
import pathlib
import shlex
import shutil
import signal
import subprocess
import time
from dataclasses import dataclass, field

ROOT = pathlib.Path(__file__).resolve().parents[2]
NOISE = ("MPI_ABORT", "PETSC ERROR", "terminate called", "Segmentation", "internal error",
         "Caught signal", "HDF5-DIAG", "Assertion", "corrupted", "stack smashing",
         "Sanitizer", "runtime error:")


def environment() -> dict[str, str]:
    """The variables of scripts/environment, and waiting that leaves the cores to others."""
    text = subprocess.run(["bash", "-c", f". '{ROOT}/scripts/environment'; env -0"], check=True,
                          capture_output=True, text=True).stdout
    found = dict(line.split("=", 1) for line in text.split("\0") if "=" in line)
    # A run of one rank without mpirun would start a daemon of Open MPI's of its own.
    return {**found, "OMP_WAIT_POLICY": "passive", "OMPI_MCA_ess_singleton_isolated": "1",
            "OMPI_MCA_pml": "ob1", "OMPI_MCA_btl": "self,vader,tcp",
            # mpirun otherwise sleeps for two seconds after each status that is not 0.
            "OMPI_MCA_odls_base_sigkill_timeout": "0"}


@dataclass
class Command:
    """One run of the program: what stands on its command line, and around it."""
    options: list[str]
    ranks: int = 0  # 0: without mpirun
    threads: int = 1
    limits: list[str] = field(default_factory=list)  # of prlimit, such as --fsize=1000
    variables: dict[str, str] = field(default_factory=dict)
    stdin: bytes | None = None

    def words(self, binary: str) -> list[str]:
        words = [binary, *self.options]
        if self.limits:
            words = ["prlimit", *self.limits, *words]
        if self.ranks:
            words = ["mpirun", "--quiet", "--oversubscribe", "--bind-to", "none", "-n",
                     str(self.ranks), *words]
        return words

    def settings(self) -> dict[str, str]:
        return {"OMP_NUM_THREADS": str(self.threads), **self.variables}

    def shell(self, binary: str, stdin: str) -> str:
        """The same for a person's shell; `stdin` is the file that holds what was piped in."""
        settings = [f"{name}={shlex.quote(value)}" for name, value in self.settings().items()]
        line = " ".join(settings + [shlex.join(self.words(binary))])
        if self.stdin is not None:
            line = f"cat {stdin} | {line}"
        return line


@dataclass
class Outcome:
    """How a run ended: the status as a shell gives it, or none after a time-out."""
    status: int | None
    output: str
    errors: str

    def error_lines(self) -> list[str]:
        return [line for line in self.errors.splitlines() if line.startswith("nanoweft: error:")]

    def complaint(self, *allowed: int) -> str | None:
        """What is wrong with this end, where these statuses are allowed."""
        if self.status is None:
            return "hangs"
        lines = self.error_lines()
        if self.status not in allowed:
            told = lines[0] if lines else (self.errors.strip().splitlines() or [""])[-1]
            return f"status {self.status}: {told[:200]}"
        for noise in NOISE:
            if noise in self.output or noise in self.errors:
                return f"noise: {noise}"
        if self.status in (1, 2) and len(lines) != 1:
            return f"status {self.status} with {len(lines)} lines 'nanoweft: error: ...'"
        if self.status in (0, 3) and lines:
            return f"status {self.status} with the line '{lines[0][:200]}'"
        return None


def descendants(root: int) -> list[int]:
    """The process and all below it, as long as they live."""
    parents: dict[int, list[int]] = {}
    for entry in os.listdir("/proc"):
        if entry.isdigit():
            try:
                text = pathlib.Path(f"/proc/{entry}/stat").read_text()
            except OSError:
                continue
            state, parent = text.rpartition(")")[2].split()[:2]
            if state != "Z":
                parents.setdefault(int(parent), []).append(int(entry))
    found, waiting = [], [root]
    while waiting:
        found.append(waiting.pop())
        waiting += parents.get(found[-1], [])
    return found


def send(process: int, number: int) -> None:
    try:
        os.kill(process, number)
    except ProcessLookupError:
        pass


def alive(process: int) -> bool:
    try:
        state = pathlib.Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


def _printer(path: pathlib.Path) -> subprocess.Popen[bytes]:
    with path.open("wb") as file:
        return subprocess.Popen(["cat"], stdin=subprocess.PIPE, stdout=file,
                                start_new_session=True)


class Running:
    """A run under way in a folder; what it prints goes to out.txt and err.txt beside the folder."""

    def __init__(self, binary: str, command: Command, folder: pathlib.Path, prints: pathlib.Path,
                 base: dict[str, str]) -> None:
        self.prints, self.ranks_asked = prints, command.ranks
        self.name = pathlib.Path(binary).name[:15]
        session = prints / "mpi"
        session.mkdir(parents=True, exist_ok=True)
        variables = {**base, "OMPI_MCA_orte_tmpdir_base": str(session),
                     "OMPI_MCA_btl_vader_backing_directory": str(session), **command.settings()}
        # Through a pipe, since a limit on the size of files is none on what is printed.
        self.printers = [_printer(prints / name) for name in ("out.txt", "err.txt")]
        out, err = (printer.stdin for printer in self.printers)
        self.process = subprocess.Popen(
            command.words(binary), cwd=folder, env=variables, stdout=out, stderr=err,
            stdin=subprocess.DEVNULL if command.stdin is None else subprocess.PIPE,
            start_new_session=True)
        for pipe in (out, err):
            if pipe:
                pipe.close()
        if command.stdin is not None and self.process.stdin:
            try:
                (prints / "stdin.txt").write_bytes(command.stdin)
                self.process.stdin.write(command.stdin)
                self.process.stdin.close()
            except BrokenPipeError:
                pass

    def settle(self) -> None:
        """Until all that was printed is there; something left behind may hold the pipe open."""
        for printer in self.printers:
            try:
                printer.wait(10)
            except subprocess.TimeoutExpired:
                printer.kill()
                printer.wait()

    def over(self) -> bool:
        return self.process.poll() is not None

    def ranks(self) -> list[int]:
        """Processes of the program itself."""
        if not self.ranks_asked:
            return [self.process.pid]
        found = []
        for process in descendants(self.process.pid):
            try:
                if pathlib.Path(f"/proc/{process}/comm").read_text().strip() == self.name:
                    found.append(process)
            except OSError:
                pass
        return found

    def kill(self) -> None:
        """Kills mpirun and all ranks at once, and waits until they are gone."""
        everyone = descendants(self.process.pid)
        for process in everyone:
            send(process, signal.SIGKILL)
        self.process.wait()
        self.settle()
        while any(alive(process) for process in everyone):
            time.sleep(0.001)

    def stacks(self) -> None:
        """Where a run that hangs waits, beside what it printed, if there is a debugger."""
        if not shutil.which("gdb"):
            return
        with (self.prints / "stacks.txt").open("w") as file:
            for process in self.ranks():
                subprocess.run(["gdb", "-batch", "-p", str(process), "-ex", "thread apply all bt"],
                               stdout=file, stderr=subprocess.DEVNULL, timeout=120, check=False)

    def wait(self, seconds: float) -> Outcome:
        try:
            status: int | None = self.process.wait(seconds)
        except subprocess.TimeoutExpired:
            self.stacks()
            self.kill()
            status = None
        if status is not None and status < 0:
            status = 128 - status
        self.settle()
        texts = [(self.prints / name).read_bytes().decode("utf-8", "replace")
                 for name in ("out.txt", "err.txt")]
        return Outcome(status, *texts)
