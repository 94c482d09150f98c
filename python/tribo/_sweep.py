"""Plays the rows of a study in processes of this machine or on a cluster. Files keep the rows, so a killed sweep can continue."""

from __future__ import annotations

import fcntl
import json
import math
import multiprocessing
import os
import shutil
import signal
import threading
import warnings
from collections.abc import Iterable, Iterator, Mapping
from concurrent import futures
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ._core import Scenario, ScenarioError, new_error, raised, text
from ._native import ffi, lib
from ._study import MEASURES, Study

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped]
    import pyarrow  # type: ignore[import-untyped]

BLOCK_ROWS_MAX = 1000
BLOCKS = 512  # if a study has as many rows; a kill loses one block per worker
FAR_BLOCKS = 500  # half of the blocks given to the caller's executor at a time
SHARDS_MAX = 100_000
WORKERS_MAX = 1024
WORST = 10  # rows that the report names


class SweepError(OSError):
    """The folder belongs to another sweep, or is in use."""


# --- in a worker ---------------------------------------------------------------------------------------------------


class Job(NamedTuple):
    """The settings of a row, and those of its second run."""

    sets: list[str]
    without: list[str] | None


class Played(NamedTuple):
    """The result of a row, with the measures of both runs."""

    status: str
    message: str
    measures: list[float] | None = None
    without: list[float] | None = None


class How(NamedTuple):
    """The options that all rows share."""

    scenario: str
    is_q31: bool
    timeout_s: float


_last: tuple[How, list[str], list[float]] | None = None  # the last run of `without`, which successive rows can share


def _play(how: How, sets: list[str]) -> tuple[str, str, list[float] | None]:
    try:
        scenario = Scenario(how.scenario)
        error = new_error()
        for assignment in sets:
            if not lib.native_scenario_set(scenario.handle, assignment.encode(errors="surrogateescape"), error):
                raise raised(error)
        if not lib.native_scenario_check(scenario.handle, error):
            raise raised(error)
    except ScenarioError as refusal:
        return "refused", str(refusal), None
    said, ticks = ffi.new("char **"), ffi.new("double *")
    status = text(lib.native_measure(scenario.handle, how.is_q31, how.timeout_s, said, ticks, error))
    if status != "ok":
        return status, str(raised(error)), None
    summary = {**json.loads(ffi.string(said[0])), "window_ticks": ticks[0]}
    lib.native_free(said[0])
    return status, "", [math.nan if summary[name] is None else float(summary[name]) for name in MEASURES]


def _play_job(how: How, job: Job) -> Played:
    global _last
    status, message, measures = _play(how, job.sets)
    if status != "ok" or job.without is None:
        return Played(status, message, measures)
    last = _last
    if last is None or last[:2] != (how, job.without):
        status, message, without = _play(how, job.without)
        if without is None:
            return Played(status, f"without: {message}", measures)
        _last = last = how, job.without, without
    return Played("ok", "", measures, last[2])


def play_block(how: How, jobs: list[Job]) -> list[Played]:
    return [_play_job(how, job) for job in jobs]


def _begin_worker(parent: tuple[int, int], locks: list[int]) -> None:
    """Ends the worker when the sweep closes its pipe or is killed. The sweep itself handles Ctrl-C."""
    for file in (parent[1], *locks):
        os.close(file)
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def wait() -> None:
        os.read(parent[0], 1)
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()


# --- executors -----------------------------------------------------------------------------------------------------


class _Pool:
    """Processes of this machine. They are forked, so a script needs no `__main__` guard and a worker no start-up."""

    def __init__(self, workers: int, locks: list[int]) -> None:
        self.workers, self.locks = workers, locks
        self.begin()

    def begin(self) -> None:
        self._pipe = os.pipe()
        self.executor = futures.ProcessPoolExecutor(self.workers, multiprocessing.get_context("fork"), _begin_worker, (self._pipe, self.locks))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # about threads: a worker calls nothing that waits for a thread
            self.executor.submit(int)  # starts all workers

    def end(self) -> None:
        os.close(self._pipe[1])
        self.executor.shutdown(cancel_futures=True)
        os.close(self._pipe[0])

    def has_lost(self, error: BaseException | None) -> bool:
        """Whether a worker died while it ran its rows."""
        return isinstance(error, futures.BrokenExecutor)

    def alone(self) -> _Pool:
        """A separate pool for a row that may have killed a worker."""
        return _Pool(1, self.locks)


class _Given:
    """The caller's executor, or a Dask client."""

    workers = FAR_BLOCKS

    def __init__(self, executor: Any) -> None:
        self.executor = executor.get_executor() if hasattr(executor, "get_executor") else executor

    def begin(self) -> None:
        pass

    def end(self) -> None:
        pass

    def has_lost(self, error: BaseException | None) -> bool:
        return type(error).__name__ == "KilledWorker"

    def alone(self) -> _Given:
        return self


def _play_alone(how: How, job: Job, pool: _Pool | _Given) -> Played:
    alone = pool.alone()
    try:
        return alone.executor.submit(play_block, how, [job]).result()[0]
    except Exception as error:
        if not pool.has_lost(error):
            raise
        return Played("crashed", "the worker process ended abruptly")
    finally:
        if alone is not pool:
            alone.end()


def _play_blocks(study: Study, blocks: Iterable[range], pool: _Pool | _Given) -> Iterator[tuple[range, list[Played]]]:
    """Yields the blocks as they finish."""
    how = How(study.scenario, study.is_q31, study.timeout_s)
    wanted, pending, lost = iter(blocks), dict[futures.Future[list[Played]], range](), list[range]()
    while True:
        while not lost and len(pending) < 2 * pool.workers and (block := next(wanted, None)) is not None:
            try:
                pending[pool.executor.submit(play_block, how, _jobs(study, block))] = block
            except futures.BrokenExecutor as broken:
                if not pool.has_lost(broken):
                    raise
                lost.append(block)
        if not pending and not lost:
            return
        for future in futures.wait(pending, return_when=futures.FIRST_COMPLETED).done:
            block, error = pending.pop(future), future.exception()
            if pool.has_lost(error):
                lost.append(block)
            else:
                yield block, future.result()
        if lost and not pending:  # a dead worker loses all blocks that were handed out
            pool.end()
            pool.begin()
            for block in lost:
                yield block, [_play_alone(how, job, pool) for job in _jobs(study, block)]
            lost.clear()


def _jobs(study: Study, block: range) -> list[Job]:
    return [Job(study.assignments(row), study.assignments(row, without=True) if study.is_paired else None) for row in block]


# --- rows ----------------------------------------------------------------------------------------------------------


def _table(study: Study, block: range, played: list[Played]) -> pyarrow.Table:
    import pyarrow

    missing = [math.nan] * len(MEASURES)
    labels = zip(*(study.labels(row) for row in block)) if block else [()] * len(study.axes)
    columns: dict[str, Any] = {"row": pyarrow.array(block, pyarrow.int64())}
    for axis, values in zip(study.axes, labels):
        kind, type_ = (int, pyarrow.uint64()) if axis.is_integer else (float, pyarrow.float64()) if axis.is_numeric else (str, pyarrow.string())
        columns[axis.name] = pyarrow.array(map(kind, values), type_)
    for i, name in enumerate(MEASURES):
        columns[name] = pyarrow.array([(one.measures or missing)[i] for one in played], pyarrow.float64())
    if study.is_paired:
        for i, name in enumerate(MEASURES):
            columns[f"without_{name}"] = pyarrow.array([(one.without or missing)[i] for one in played], pyarrow.float64())
        columns["ratio"] = pyarrow.array([one.without[0] / one.measures[0] if one.without and one.measures and one.measures[0] > 0 else math.nan for one in played], pyarrow.float64())
    columns["status"] = pyarrow.array([one.status for one in played], pyarrow.string())
    columns["message"] = pyarrow.array([one.message for one in played], pyarrow.string())
    return pyarrow.table(columns).replace_schema_metadata({"tribo": study.id})


def _worst(study: Study, frame: pandas.DataFrame) -> dict[str, list[dict[str, Any]]]:
    """The rows of lowest ratio, largest error and most chatter, with the commands that play them."""
    worst = {}
    for name, is_lowest in (("ratio", True), ("rms_error_N", False), ("chatter_ticks", False)):
        if name in frame:
            found = frame.dropna(subset=[name]).sort_values(name, ascending=is_lowest, kind="stable").head(WORST)
            worst[name] = [{"row": int(row), "value": float(value), "command": study.command(int(row)), **({"without": study.command(int(row), without=True)} if study.is_paired else {})}
                           for row, value in zip(found["row"], found[name])]
    return worst


def _frame(study: Study, tables: list[pyarrow.Table]) -> pandas.DataFrame:
    import pyarrow

    frame = pyarrow.concat_tables(tables).to_pandas() if tables else _table(study, range(0), []).to_pandas()
    frame = frame.sort_values("row", ignore_index=True)
    frame.attrs = {"study": study.path, "id": study.id, "axes": [axis.name for axis in study.axes], "relative": [axis.name for axis in study.axes if axis.is_relative],
                   "worst": _worst(study, frame)}
    return frame


# --- the folder ----------------------------------------------------------------------------------------------------


@contextmanager
def _locked(folder: Path, shard: tuple[int, int] | None) -> Iterator[list[int]]:
    """Locks the folder: for a whole sweep alone, or shared by shards, each of them once."""
    names = [(".lock", fcntl.LOCK_SH if shard else fcntl.LOCK_EX), *([(f".lock-{shard[0]}-of-{shard[1]}", fcntl.LOCK_EX)] if shard else [])]
    files: list[int] = []
    try:
        for name, kind in names:
            files.append(os.open(folder / name, os.O_RDWR | os.O_CREAT, 0o666))
            try:
                fcntl.flock(files[-1], kind | fcntl.LOCK_NB)
            except BlockingIOError:
                raise SweepError(f"{folder}: another sweep is writing there") from None
        yield files
    finally:
        for file in files:
            os.close(file)


class _Folder:
    """DIR/parts has a file for each finished block; DIR/rows.parquet replaces them when all are finished."""

    def __init__(self, study: Study, folder: Path) -> None:
        self._study = study
        self.rows = folder / "rows.parquet"
        self.parts = folder / "parts"

    def _path(self, block: range) -> Path:
        return self.parts / f"{block.start:08}.parquet"

    def _read(self, path: Path) -> pyarrow.Table:
        import pyarrow
        import pyarrow.parquet  # type: ignore[import-untyped]

        try:
            table = pyarrow.parquet.read_table(path)
        except (OSError, pyarrow.ArrowException) as error:
            raise SweepError(f"{path}: cannot be read: {str(error).splitlines()[0]}: remove the file") from None
        return table

    def _refuse(self, path: Path) -> SweepError:
        return SweepError(f"{path}: belongs to another study, or to an earlier version of this one: remove it, or give another folder")

    def whole(self) -> pandas.DataFrame | None:
        """The frame of a finished sweep, or None."""
        if not self.rows.exists():
            return None
        table = self._read(self.rows)
        attrs = json.loads((table.schema.metadata or {}).get(b"PANDAS_ATTRS", b"{}"))
        if attrs.get("id") != self._study.id:
            raise self._refuse(self.rows)
        import pandas

        return pandas.read_parquet(self.rows)

    def played(self, blocks: list[range]) -> dict[int, pyarrow.Table]:
        """The tables of the finished blocks, by their first row."""
        self.parts.mkdir(exist_ok=True)
        found = {}
        for block in blocks:
            path = self._path(block)
            if path.exists():
                table = self._read(path)
                if (table.schema.metadata or {}).get(b"tribo") != self._study.id.encode() or table["row"].to_pylist() != list(block):
                    raise self._refuse(path)
                found[block.start] = table
        return found

    def write(self, block: range, table: pyarrow.Table) -> None:
        import pyarrow.parquet

        with _made(self._path(block)) as path:
            pyarrow.parquet.write_table(table, path)

    def finish(self, frame: pandas.DataFrame) -> None:
        with _made(self.rows) as path:
            frame.to_parquet(path, index=False)
        shutil.rmtree(self.parts)


@contextmanager
def _made(path: Path) -> Iterator[Path]:
    """Writes a file wholly or not at all."""
    part = path.with_suffix(".part")
    try:
        yield part
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


# --- a sweep -------------------------------------------------------------------------------------------------------


def _blocks(study: Study, shard: tuple[int, int] | None) -> list[range]:
    size = min(max(study.rows // BLOCKS, 1), BLOCK_ROWS_MAX)
    blocks = [range(start, min(start + size, study.rows)) for start in range(0, study.rows, size)]
    return blocks[shard[0] - 1 :: shard[1]] if shard else blocks


def _check(workers: int | None, shard: tuple[int, int] | None, executor: Any, out: Any) -> None:
    if out is not None and not os.fspath(out):
        raise ValueError("out: is empty: the name of a folder is expected")
    if shard is not None and not (1 <= shard[0] <= shard[1] <= SHARDS_MAX):
        raise ValueError(f"shard {shard[0]}/{shard[1]}: i of n is expected, with i from 1 to n, at most {SHARDS_MAX}")
    if shard is not None and out is None:
        raise ValueError("a shard needs a folder, which all shards share")
    if workers is not None and not 1 <= workers <= WORKERS_MAX:
        raise ValueError(f"workers={workers}: a number from 1 to {WORKERS_MAX} is expected")
    if workers is not None and executor is not None:
        raise ValueError("workers and executor exclude each other")


def _play_all(study: Study, blocks: list[range], found: dict[int, pyarrow.Table], folder: _Folder | None, pool: _Pool | _Given, progress: bool | None) -> None:
    from tqdm.auto import tqdm  # type: ignore[import-untyped]

    missing = [block for block in blocks if block.start not in found]
    try:
        with tqdm(total=sum(map(len, blocks)), initial=sum(len(block) for block in blocks if block.start in found), unit="row", disable=None if progress is None else not progress) as bar:
            for block, played in _play_blocks(study, missing, pool):
                found[block.start] = _table(study, block, played)
                if folder is not None:
                    folder.write(block, found[block.start])
                bar.update(len(block))
    finally:
        pool.end()


def sweep(study: Study | str | os.PathLike[str] | Mapping[str, Any], out: str | os.PathLike[str] | None = None, *, workers: int | None = None,
          shard: tuple[int, int] | None = None, executor: Any = None, progress: bool | None = None) -> pandas.DataFrame:
    """Plays a study and returns a frame with a row for each set of values; docs/sweep.md describes the columns. A failed row has a `status` and a `message`.

    `study`: the path of a study's file, the name of one in the studies folder, or a mapping of the same keys.
    `out`: a folder that keeps the rows; after a kill the same call continues from it. Without it nothing is written.
    `workers`: number of processes; one for each core if left out.
    `shard=(i, n)`: plays only the i-th of n parts; the call without it gathers the results of the shards in `out`.
    `executor`: a client of dask.distributed or any executor of the concurrent.futures kind, used instead of local processes.
    `progress`: whether to draw a bar; if left out, it is drawn on a terminal.

    Raises ScenarioError if the study is refused, and SweepError (an OSError) if the folder belongs to another study or a running sweep.

    >>> frame = sweep({"scenario": "triangle", "set": {"duration_s": 1, "metrics.start_s": 0}, "grid": {"compensator.gain": [0.5, 1]}}, workers=1)
    >>> frame["compensator.gain"].tolist(), frame.status.tolist()
    ([0.5, 1.0], ['ok', 'ok'])
    """
    _check(workers, shard, executor, out)
    missing = [name for name in ("pandas", "pyarrow", "tqdm") if find_spec(name) is None]
    if missing:
        raise ImportError(f"tribo.sweep needs {', '.join(missing)}: pip install 'tribo[sweep]'")
    study = study if isinstance(study, Study) else Study(study)
    blocks = _blocks(study, shard)

    def play(found: dict[int, Any], folder: _Folder | None, locks: list[int]) -> pandas.DataFrame:
        pool = _Given(executor) if executor is not None else _Pool(workers or len(os.sched_getaffinity(0)), locks)
        _play_all(study, blocks, found, folder, pool, progress)
        return _frame(study, list(found.values()))

    if out is None:
        return play({}, None, [])
    try:
        Path(out).mkdir(parents=True, exist_ok=True)
        with _locked(Path(out), shard) as locks:
            folder = _Folder(study, Path(out))
            whole = folder.whole()
            if whole is None:
                whole = play(folder.played(blocks), folder, locks)
                if shard is None:
                    folder.finish(whole)
                return whole
            shutil.rmtree(folder.parts, ignore_errors=True)
            rows = {row for block in blocks for row in block} if shard else None
            return whole if rows is None else whole[whole["row"].isin(rows)].reset_index(drop=True)
    except SweepError:
        raise
    except FileExistsError as error:
        raise SweepError(f"{error.filename}: is not a folder") from None
    except OSError as error:
        raise SweepError(f"{error.filename or out}: {error.strerror or error}") from None


def sweep_report(frame: pandas.DataFrame, folder: str | os.PathLike[str]) -> list[Path]:
    """Writes report.md into a folder: a table for each axis and the worst rows with the commands that play them; and ratio, rms and chatter against
    each axis as .png. Returns their paths."""
    from tribo_plot import sweeps  # type: ignore[import-untyped]

    return sweeps.report(frame, Path(folder))  # type: ignore[no-any-return]
