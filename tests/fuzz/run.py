"""Fuzz the readers of files, in Python and in the page: `python tests/fuzz/run.py --time 60 --format step`.

Inputs are mutants (mutate.py) of the seeds and of earlier finds. The readers' results guide the search: a mutant with a
new result, or a new error, is mutated further. This needs no instrumented interpreter, and also gets past checks, since
each check has a different message. contract.py defines the contract. Each format has a child process that reads in
process. If a library crashes on damaged files, and the package starts a process for each, children are forked after the
import of the library, one for a few files: that takes milliseconds instead of seconds. A crash there is no failure, nor
is a kill at the time limit.

It prints a line for each format, and fails if a reader breaks its promise; the files are in build/fuzz/failures. Files
that Python loads and the page refuses, or the other way round, are in build/fuzz/differences.
"""

from __future__ import annotations

import argparse
import json
import mmap
import os
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from pathlib import Path
from random import Random
from typing import Any

from contract import APART, LONGEST, MEMORY, BrokenPromise, Watch, kind_of, limits_kept, outcome, read_here
from mutate import mutant

from bobrossnet.completion.weights import WEIGHTS
from bobrossnet.page.files import READ_IN_PAGE
from bobrossnet.support.machine import limit_memory
from bobrossnet.support.paths import VIEWER

HERE = Path(__file__).parent
BUILD = HERE.parents[1] / "build/fuzz"
BATCH = 25
"""Files read by one child with a crashing library.

After a damaged file the child's state is undefined, so only a violation by its first file counts.
"""

STUCK = 100.0
"""Seconds without a result, on a busy machine, before a child is killed."""

FORMATS = sorted({folder.name for folder in (HERE / "seeds").iterdir()} | {"safetensors"})
IN_PAGE = {ending[1:] for ending in READ_IN_PAGE} | {"safetensors"}
PLAIN = {".bin"}
"""Endings of companion files of seeds."""

COUNTS = ("executions", "loaded", "rough", "failures", "differences", "crashes", "kinds")
"""rough: refused with a library's exception, not a sentence; crashes: of crashing libraries; kinds: of results."""


class Counts:
    """Numbers in memory shared by a child and its parent, which survive the child."""

    def __init__(self) -> None:
        self.memory = memoryview(mmap.mmap(-1, 8 * (len(COUNTS) + 1))).cast("q")

    def __getitem__(self, name: str) -> int:
        return self.memory[COUNTS.index(name)]

    def __setitem__(self, name: str, value: int) -> None:
        self.memory[COUNTS.index(name)] = value

    @property
    def last(self) -> int:
        """Number of the current input."""
        return self.memory[-1]

    @last.setter
    def last(self, value: int) -> None:
        self.memory[-1] = value


class Page:
    """The page's readers, in a process that is restarted after a crash."""

    def __init__(self) -> None:
        self.process: Any = None

    def start(self) -> None:
        if self.process is None:
            self.process = subprocess.Popen(
                [sys.executable, str(HERE / "page.py")],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                text=True,
                preexec_fn=unlimited,  # browsers reserve more memory than they use
            )
            self.process.stdout.readline()  # it is ready

    def read(self, file: Path) -> dict[str, Any]:
        self.start()
        self.process.stdin.write(f"{file}\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        if not line:
            self.close()
            raise BrokenPromise("the page's reader ended")
        answer: dict[str, Any] = json.loads(line)
        if not answer["clear"]:
            raise BrokenPromise(f"the page says {answer['says'][:300]!r}")
        if answer["seconds"] > 2 * LONGEST:
            raise BrokenPromise(f"the page took {answer['seconds']:.1f} s")
        return answer

    def close(self) -> None:
        if self.process is not None:
            self.process.stdin.close()  # it then ends, with its browser
            self.process.wait()
            self.process = None


def unlimited() -> None:
    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    resource.setrlimit(resource.RLIMIT_DATA, (hard, hard))


class Fuzzer:
    """The work of a child on a format."""

    def __init__(self, ending: str, options: argparse.Namespace, counts: Counts, work: Path) -> None:
        self.ending, self.options, self.counts, self.work = ending, options, counts, work
        self.page = Page() if options.page and ending in IN_PAGE else None
        self.kinds: set[str] = set()
        seeds = sorted((HERE / "seeds").glob(f"{ending}/*"))
        for file in (file for file in seeds if file.suffix in PLAIN):
            shutil.copy(file, work)
        self.seeds = [file for file in seeds if file.suffix not in PLAIN]
        if ending == "safetensors":
            self.seeds = [WEIGHTS / "paper.safetensors"]
        self.found = sorted((HERE / "found").glob(f"{ending}/*"))
        corpus = BUILD / "corpus" / ending
        self.corpus = None if options.mutants or ending in APART else corpus
        self.kept = [] if self.corpus is None else sorted(corpus.glob("*"))
        self.first = [*self.seeds, *self.found, *self.kept]
        self.files = [file.read_bytes() for file in self.first]

    def run(self, start: int, until: float) -> None:
        if self.page:  # a browser takes seconds to start
            began = time.monotonic()
            self.page.start()
            until += time.monotonic() - began
        watch = Watch(self.work)
        for number in range(start, len(self.first) + (self.options.mutants or 1 << 62)):
            if time.monotonic() > until:
                break
            if number == start + BATCH and self.ending in APART:
                os._exit(0)
            mutated = number >= len(self.first)
            if mutated:
                random = Random(f"{self.options.seed} {self.ending} {number}")
                # Most finds are refused early, and mutants of them seldom get further.
                few = random.random() < 0.6
                data = mutant(self.ending, random, self.files[: len(self.seeds)] if few else self.files)
            else:
                data = self.files[number]
            file = self.work / f"{number}.{self.ending}"
            file.write_bytes(data)
            self.counts.last = number
            try:
                watch.on = True
                loads, found = outcome(file)
                watch.on = False
                if not loads and not mutated and number < len(self.seeds):
                    raise BrokenPromise(f"a seed does not load: {found}")
                answer = self.page.read(file) if self.page else {"loads": loads, "says": ""}
            except BrokenPromise as error:
                watch.on = False
                if number > start and self.ending in APART:
                    self.counts.last = number - 1
                    os._exit(0)
                self.counts["failures"] += 1
                keep("failures", file, str(error))
                if "memory" in str(error) or "bytes" in str(error):
                    os._exit(0)  # its memory would count against the next child
            else:
                self.counts["loaded"] += loads
                self.counts["rough"] += "could not read it" in found
                if answer["loads"] != loads:
                    self.counts["differences"] += 1
                    keep("differences", file, f"Python: {found}; the page: {answer['says'] or 'loads'}")
                kind = f"{loads} {kind_of(found)} {answer['loads']} {kind_of(answer['says'])}"
                if mutated and kind not in self.kinds and self.corpus is not None:
                    self.corpus.mkdir(parents=True, exist_ok=True)
                    shutil.copy(file, self.corpus / f"{len(self.files):05}-{os.getpid()}.{self.ending}")
                    self.files.append(data)
                self.kinds.add(kind)
                self.counts["kinds"] = len(self.kinds)
            self.counts["executions"] += 1
            file.unlink()
        self.counts.last = -1
        if self.page:
            self.page.close()


def keep(kind: str, file: Path, why: str) -> None:
    """Keep an input, and print the reason."""
    folder = BUILD / kind / file.suffix[1:]
    folder.mkdir(parents=True, exist_ok=True)
    if len(list(folder.iterdir())) < 500:
        shutil.copy(file, folder)
    if kind == "failures":
        print(f"{folder / file.name}: {why[:600]}", file=sys.stderr, flush=True)
    else:
        with (BUILD / f"{kind}.txt").open("a") as log:
            log.write(f"{folder.name}/{file.name}: {why}\n")


def fuzz(ending: str, options: argparse.Namespace) -> Counts:
    """Run a format's children, one after the other."""
    if ending in APART:
        read_here()
    counts = Counts()
    until = time.monotonic() + options.time
    start = 0
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        while counts.last >= 0:
            counts.last = start
            child = os.fork()
            if child == 0:
                os.nice(5)
                limit_memory(MEMORY)
                resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
                silence(ending)
                try:
                    Fuzzer(ending, options, counts, work).run(start, until)
                except BaseException:
                    traceback.print_exc()
                    os._exit(1)
                os._exit(0)
            status = wait(child, counts)
            if counts.last < 0:
                break
            if os.WIFEXITED(status) and os.WEXITSTATUS(status):
                raise SystemExit(f"{ending}: the fuzzer itself failed")
            start = counts.last + 1
            file = work / f"{counts.last}.{ending}"
            if os.WIFSIGNALED(status):
                name = signal.Signals(os.WTERMSIG(status)).name
                counts["executions"] += 1
                if name == "SIGKILL":
                    counts["failures"] += 1
                    keep("failures", file, "no answer")
                elif ending in APART:
                    counts["crashes"] += 1
                else:
                    counts["failures"] += 1
                    keep("failures", file, f"crashed: {name}")
            if file.exists():
                file.unlink()
    return counts


def wait(child: int, counts: Counts) -> int:
    """Return a child's status; it is killed if one file takes too long."""
    last, since = -1, time.monotonic()
    while True:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return status
        if counts.last != last:
            last, since = counts.last, time.monotonic()
        elif time.monotonic() - since > STUCK:
            os.kill(child, signal.SIGKILL)
        time.sleep(0.001)


def silence(ending: str) -> None:
    """Discard the output of libraries that print."""
    if ending in APART:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)


def browser_is_there() -> bool:
    sys.path.append(str(HERE.parent))
    from browser import NAMES

    return any(map(shutil.which, NAMES))


def warm_up(ending: str) -> None:
    """Import a format's libraries before its children are forked."""
    if ending in APART:
        # Libraries fill their tables with the first file. The core has threads, which a fork would lose.
        seed = next((HERE / "seeds" / ending).iterdir())
        if ending == "3dm":
            from bobrossnet.adapters.rhino import read_here as read

            read(seed)
        else:
            from bobrossnet.adapters.occ import read_assembly

            before = os.dup(1)
            silence(ending)
            with limits_kept():
                read_assembly(ending.upper(), str(seed))
            os.dup2(before, 1)
            os.close(before)
    import xml.etree.ElementTree  # noqa: F401
    import zipfile  # noqa: F401

    import safetensors.numpy  # noqa: F401


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--format", choices=FORMATS, action="append", help="all by default; may be repeated")
    parser.add_argument("--time", type=float, default=60, help="seconds for each format")
    parser.add_argument("--mutants", type=int, default=0, help="stop after so many, always the same ones")
    parser.add_argument("--seed", default="0", help="of the random choices")
    parser.add_argument("--no-page", dest="page", action="store_false", help="only Python's readers")
    parser.add_argument("file", nargs="*", type=Path, help="only say what becomes of these")
    options = parser.parse_args()
    options.page = options.page and browser_is_there() and (VIEWER / "core.wasm").is_file()
    if options.file:
        return say(options.file, options.page)
    failures = 0
    for ending in options.format or FORMATS:
        warm_up(ending)
        start = time.monotonic()
        counts = fuzz(ending, options)
        seconds = time.monotonic() - start
        rate = counts["executions"] / seconds
        others = ", ".join(f"{counts[name]:,} {name}" for name in COUNTS[1:])
        print(f"{ending}: {counts['executions']:,} executions, {rate:,.0f}/s, {others}", flush=True)
        failures += counts["failures"]
    return 1 if failures else 0


def say(files: list[Path], page: bool) -> int:
    """Print the results of single files, by the readers as shipped."""
    broken = 0
    for file in files:
        try:
            print(outcome(file))
            if page and file.suffix[1:] in IN_PAGE:
                print(Page().read(file.resolve()))
        except BrokenPromise as error:
            broken = 1
            print(f"{file}: {error}")
    return broken


if __name__ == "__main__":
    sys.exit(main())
