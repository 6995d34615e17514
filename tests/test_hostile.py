"""Hostile input and a machine's limits: a clean error or a result, in seconds and within the memory there is."""

import gzip
import json
import os
import re
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

import sigmatau as st
from conftest import ROOT
from sigmatau.cli import main
from sigmatau.errors import DataError, OptionError
from sigmatau.io.read import read
from sigmatau.record.memory import available

ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT / "python"), "OPENBLAS_NUM_THREADS": "1"}
# Threads that meet in malloc reserve address space, 64 MiB each, by chance; a limit then leaves more or less.
ENVIRONMENT |= {"MALLOC_ARENA_MAX": "1"}
N = 200_000
NAMED = {"gyro_x [rad/s]": 1.0, "gyro_y [rad/s]": 2.0}
LIMITED = "import resource, sys; resource.setrlimit(resource.RLIMIT_AS, (int(sys.argv[1]),) * 2);"
COMMAND = f"""{LIMITED}
from sigmatau.cli import main
code = main(sys.argv[2:])
sys.stdout.flush()
status = open("/proc/self/status").read() if sys.platform == "linux" else "VmHWM: 0"
print(status.partition("VmHWM:")[2].split()[0])
sys.exit(code)
"""
linux = pytest.mark.skipif(sys.platform != "linux", reason="limits of memory as Linux has them")


def command(*argv, space=6 << 30, seconds=60):
    """A command in a process with so much address space: exit code, what it said, memory [bytes], time [s]."""
    begun = os.times()
    done = subprocess.run(
        [sys.executable, "-c", COMMAND, str(space), *map(str, argv)],
        env=ENVIRONMENT, capture_output=True, text=True, timeout=seconds, check=False,
    )  # fmt: skip
    assert "Traceback" not in done.stderr, done.stderr
    assert done.returncode >= 0, done.stderr  # by no signal
    memory = int(done.stdout.split()[-1]) << 10
    ended = os.times()
    seconds = ended.children_user + ended.children_system - begun.children_user - begun.children_system
    return done.returncode, done.stdout + done.stderr, memory, seconds


class TestShrinking:
    """A file that another process shortens while it is read; mapped, it would end the program by SIGBUS."""

    def saved(self, folder, kind):
        table = np.zeros(N, dtype=[(name, "f8") for name in NAMED])
        for name, value in NAMED.items():
            table[name] = value + np.arange(N) % 3
        path = folder / f"log.{kind}"
        if kind == "npy":
            np.save(path, table)
        elif kind == "columns":
            np.save(folder / "log.npy", np.asfortranarray(table.view("f8").reshape(N, 2)))
            return folder / "log.npy", {"channels": {"gyro_x": 1, "gyro_y": 2}, "unit": {"gyro": "rad/s"}}
        elif kind == "raw":
            table.tofile(path)
            return path, {"layout": "<f8 gyro_x[rad/s],f8 gyro_y[rad/s]"}
        elif kind == "mat":
            savemat(path, {"gyro_x": table["gyro_x [rad/s]"][:, None], "gyro_y": table["gyro_y [rad/s]"][:, None]})
            return path, {"unit": {"gyro": "rad/s"}}
        else:
            feather = pytest.importorskip("pyarrow.feather")
            pa = pytest.importorskip("pyarrow")
            feather.write_feather(pa.table({n: table[n] for n in NAMED}), path, compression="uncompressed")
        return path, {}

    @pytest.mark.parametrize("kind", ["npy", "columns", "raw"])
    def test_columns_that_stay_in_the_file(self, tmp_path, kind):
        path, options = self.saved(tmp_path, kind)
        record = read(path, rate=100, **options)
        stream = record.streams[0]
        assert stream.column("gyro_y")[4] == 3.0
        os.truncate(path, path.stat().st_size // 2)
        with pytest.raises(DataError, match="the file changed while it was being read"):
            stream.column("gyro_y")
        with pytest.raises(DataError, match="the file changed while it was being read"):
            st.analyze(record)

    @pytest.mark.parametrize("kind", ["mat", "arrow"])
    def test_columns_that_are_loaded(self, tmp_path, kind):
        """The record is complete, whatever becomes of the file."""
        path, options = self.saved(tmp_path, kind)
        record = read(path, rate=100, **options)
        os.truncate(path, 100)
        np.testing.assert_array_equal(record.streams[0].column("gyro_y"), 2.0 + np.arange(N) % 3)

    @pytest.mark.parametrize("kind", ["npy", "raw"])
    def test_pieces_are_those_of_the_whole(self, tmp_path, kind):
        path, options = self.saved(tmp_path, kind)
        stream = read(path, rate=100, **options).streams[0].cut(1000, 150_000)
        pieces = np.concatenate(list(stream.chunks(70_001)))
        np.testing.assert_array_equal(pieces, np.column_stack([stream.column(c) for c in stream.channels]))
        np.testing.assert_array_equal(pieces[:, 0], 1.0 + np.arange(1000, 150_000) % 3)


class TestBombs:
    def test_rows_by_the_hundred_million(self, tmp_path):
        path = tmp_path / "log.csv.gz"
        path.write_bytes(gzip.compress(b"gyro_x [deg/s]\n") + gzip.compress(b"0\n" * (1 << 20)) * 375)
        code, said, memory, seconds = command("analyze", path, "--rate", 100)
        assert code == 1
        assert "--max-expansion" in said
        assert memory < 1 << 30
        assert seconds < 10
        with pytest.raises(OptionError, match="max_expansion` must be a number, 1 or more"):
            read(path, rate=100, max_expansion=0)

    def test_arrays_of_zeros(self, tmp_path):
        path = tmp_path / "log.npz"
        np.savez_compressed(path, gyro_x=np.zeros(20_000_000))
        with pytest.raises(DataError, match=r"gyro_x\.npy expands from 0\.\d+ MB to 160 MB: .*`max_expansion=\d+`"):
            read(path, rate=100, unit={"gyro": "deg/s"})
        assert read(path, rate=100, unit={"gyro": "deg/s"}, max_expansion=2000).streams[0].grid.n == 20_000_000

    @pytest.mark.parametrize("kind", ["parquet", "arrow", "one batch", "mat"])
    def test_numbers_that_are_all_the_same(self, tmp_path, kind):
        """Half a megabyte or less that expands to 240 MB and more, in two pieces of an Arrow file or in one."""
        n = 5_000_000
        path = tmp_path / f"log.{kind.replace('one batch', 'arrow')}"
        if kind == "mat":
            savemat(path, {"gyro": np.zeros((2 * n, 3))}, do_compression=True)
        else:
            pa = pytest.importorskip("pyarrow")
            table = pa.table({f"gyro_{axis}": np.zeros(2 * n if kind == "one batch" else n) for axis in "xyz"})
            if kind == "parquet":
                pq = pytest.importorskip("pyarrow.parquet")
                with pq.ParquetWriter(path, table.schema, compression="zstd", use_dictionary=False) as writer:
                    writer.write_table(table)
                    writer.write_table(table)
            else:
                packed = pa.ipc.IpcWriteOptions(compression="zstd")
                with pa.OSFile(str(path), "wb") as file, pa.ipc.new_file(file, table.schema, options=packed) as writer:
                    writer.write_table(table)
                    if kind == "arrow":
                        writer.write_table(table)
        self.refused(path)

    def refused(self, path):
        """In seconds, and without the memory that the numbers take."""
        assert path.stat().st_size < 500_000
        code, said, memory, seconds = command("analyze", path, "--rate", 100, "--unit", "gyro=deg/s")
        assert (code, "--max-expansion" in said) == (1, True), said
        assert memory < 400 << 20
        assert seconds < 10
        code, said, _, _ = command("inspect", path, "--rate", 100, "--unit", "gyro=deg/s")
        assert code in (1, 4), said  # 4: the tables are listed, and what is wrong with them
        assert "--max-expansion" in said

    def test_a_buffer_that_declares_a_terabyte(self, tmp_path):
        pa = pytest.importorskip("pyarrow")
        path = tmp_path / "log.arrow"
        table = pa.table({f"gyro_{axis}": np.zeros(12_345) for axis in "xyz"})
        packed = pa.ipc.IpcWriteOptions(compression="zstd")
        with pa.OSFile(str(path), "wb") as file, pa.ipc.new_file(file, table.schema, options=packed) as writer:
            writer.write_table(table)
        data = path.read_bytes()
        assert data.count(struct.pack("<q", 8 * 12_345)) == 3
        path.write_bytes(data.replace(struct.pack("<q", 8 * 12_345), struct.pack("<q", 1 << 40)))
        self.refused(path)

    @pytest.mark.parametrize("shape", ["(1000000000000, 0)", "(1000000000000, 3)", "(0, 3)", "(3, 1000000000000)"])
    @pytest.mark.parametrize("name", ["inspect", "analyze"])
    def test_shapes_of_arrays(self, tmp_path, shape, name, capsys):
        head = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}"
        head += " " * (-(10 + len(head) + 1) % 64) + "\n"
        path = tmp_path / "log.npy"
        path.write_bytes(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head.encode())
        argv = [name, str(path), "--rate", "100", "--channels", "gyro=1:3", "--unit", "gyro=deg/s"]
        assert main(argv) in (1, 2, 4)
        capsys.readouterr()

    def test_a_length_beyond_any_file(self, tmp_path):
        """The record after the first one is said to begin beyond 2⁶³."""
        path = tmp_path / "log.mcap"
        magic = b"\x89MCAP0\r\n"
        path.write_bytes(magic + b"\x01" + struct.pack("<Q", (1 << 64) - 20) + bytes(200) + magic)
        with pytest.raises(DataError):
            read(path)


class TestMemory:
    @linux
    def test_the_limit_of_the_process_counts(self):
        code = f"{LIMITED} from sigmatau.record.memory import available; print(available())"
        done = subprocess.run(
            [sys.executable, "-c", code, str(2 << 30)], env=ENVIRONMENT, capture_output=True, text=True, check=True
        )
        assert 0 < int(done.stdout) < 2 << 30
        assert available() is not None

    def test_the_limit_of_the_control_group_counts(self, monkeypatch):
        """100 MB left by the group above: 1000 less 950 used, of which 50 are of files."""
        words = {
            "/proc/self/cgroup": "0::/above/below\n",
            "/sys/fs/cgroup/above/below/memory.max": "max\n",
            "/sys/fs/cgroup/above/memory.max": "1000000000\n",
            "/sys/fs/cgroup/above/memory.current": "950000000\n",
            "/sys/fs/cgroup/above/memory.stat": "anon 1\ninactive_file 50000000\n",
        }
        read_text = Path.read_text
        monkeypatch.setattr(Path, "read_text", lambda p, *a, **k: words.get(str(p)) or read_text(p, *a, **k))
        assert available() == 100_000_000

    @linux
    def test_an_array_is_analysed_in_pieces(self, tmp_path):
        """480 MB, more than a process of 700 MB has free."""
        space = 700 << 20
        path = tmp_path / "log.npy"
        array = np.lib.format.open_memmap(path, "w+", "f4", (20_000_000, 6))
        rng = np.random.default_rng(5)
        for start in range(0, len(array), 1_000_000):  # noise that repeats has lines, which take seconds to model
            array[start : start + 1_000_000] = rng.standard_normal((1_000_000, 6), np.float32)
        del array
        options = ("-v", "--rate", 1000, "--channels", "gyro=1:3", "--unit", "gyro=deg/h")
        code, said, memory, _ = command("analyze", path, *options, space=space, seconds=500)
        assert code == 0, said
        assert "clusters start at every" in " ".join(said.split()), said
        assert memory < space

    @linux
    def test_a_table_is_inspected_where_it_is_analysed(self, tmp_path):
        """Three million rows of six axes: 144 MB of numbers, of which the checks held copies."""
        path = tmp_path / "log.csv"
        rows = np.random.default_rng(6).integers(1000, 9999, (30_000, 6)).tolist()
        some = [",".join(f"0.{x}" for x in row) + "\n" for row in rows]
        first = np.random.default_rng(7).integers(len(some), size=120).tolist()  # a period would make lines
        units = {"gyro": "deg/s", "accel": "m/s^2"}
        names = ",".join(f"{sensor}_{axis} [{unit}]" for sensor, unit in units.items() for axis in "xyz")
        with path.open("w") as file:
            file.write(names + "\n")
            for k in first:
                file.writelines(some[k:] + some[:k])
        for name in ("analyze", "inspect"):
            code, said, memory, _ = command(name, path, "--rate", 100, space=480 << 20)
            assert code == 0, (name, said)
            assert memory < 480 << 20
        assert "3600000 rows" in said

    @linux
    @pytest.mark.parametrize("space", [300, 450])
    def test_a_table_that_does_not_fit_is_refused(self, tmp_path, space):
        path = tmp_path / "log.csv"
        path.write_bytes(
            b"gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s]\n" + b"0.125,-1.5,17\n1.25,1.5,18\n" * 2_500_000
        )
        code, said, _, _ = command("analyze", path, "--rate", 100, space=space << 20)
        assert code in (0, 1)
        assert code == 0 or any(w in said for w in ("memory", "failed to map segment", "cannot allocate")), said


class TestNames:
    EVIL = "gyro_x\n\x1b[31mINJECTED: 1"

    def shown(self, capsys, *argv):
        code = main([str(one) for one in argv])
        got = capsys.readouterr()
        text = got.out + got.err
        assert code in (0, 1, 2), text
        assert "INJECTED" in text
        assert all(c.isprintable() or c == "\n" for c in text)
        assert not any(line.lstrip().startswith(("INJECTED", "[31m")) for line in text.splitlines())

    def test_of_arrays(self, tmp_path, capsys):
        np.savez(tmp_path / "log.npz", **{self.EVIL: np.arange(100.0)})
        self.shown(capsys, "inspect", tmp_path / "log.npz")

    @pytest.mark.parametrize(
        "argv", [("plan", "--term", "rate_random_walk", "--rate", "100"), ("predict", "--after", "60s")]
    )
    def test_of_models(self, tmp_path, capsys, argv):
        path = tmp_path / "model.toml"
        st.NoiseModel(channels={self.EVIL: {"random_walk": 1e-4, "rate_random_walk": 1e-6}}).write(path)
        self.shown(capsys, argv[0], path, *argv[1:])

    @pytest.mark.parametrize(
        "argv",
        [
            ("plan", "--term", "bias_instability"),
            ("predict", "--after", "60s"),
            ("compare", "--table"),
            ("export", "--to", "ieee952"),
        ],
    )
    def test_of_results(self, tmp_path, capsys, argv):
        samples = np.random.default_rng(8).standard_normal(3000)
        result = st.analyze(st.Record.from_arrays(rate=100, unit={"gyro": "deg/s"}, gyro_x=samples)).to_dict()
        path = tmp_path / "result.json"
        path.write_text(json.dumps(result).replace("gyro_x", json.dumps(self.EVIL)[1:-1]))
        self.shown(capsys, argv[0], path, *argv[1:])

    def test_of_text(self, tmp_path, capsys):
        (tmp_path / "log.csv").write_bytes("gyro_x,\u202eINJECTED\x85,gyro_z\n".encode() + b"1,2,3\n4,5,7\n" * 100)
        self.shown(capsys, "inspect", tmp_path / "log.csv", "--rate", "100")


@pytest.mark.parametrize("name", ["inspect", "psd", "deviation", "analyze"])
@pytest.mark.parametrize("rate", ["1e300", "5e-324", "1e10", "nan", "inf"])
def test_rates_that_no_sensor_has(tmp_path, capsys, name, rate):
    path = tmp_path / "log.csv"
    path.write_text("gyro_x [deg/s]\n" + "1\n2\n4\n3\n" * 200)
    more = ["--kind", "hadamard"] if name == "deviation" else []
    assert main([name, str(path), "--rate", rate, *more]) == 2
    assert "--rate must be a positive number" in capsys.readouterr().err


@pytest.mark.parametrize("size", [1e200, 1e-200, 0.0])
@pytest.mark.parametrize("name", ["psd", "deviation"])
def test_no_density_of_what_cannot_be_squared(tmp_path, capsys, name, size):
    values = size * np.random.default_rng(3).standard_normal(2000)
    np.savez(tmp_path / "log.npz", gyro_x=values, gyro_y=np.random.default_rng(4).standard_normal(2000))
    argv = [name, str(tmp_path / "log.npz"), "--rate", "100", "--unit", "gyro=rad/s", "--plot", str(tmp_path / "p.png")]
    code = main([*argv, *(["--kind", "hadamard"] if name == "deviation" else [])])
    got = capsys.readouterr()
    assert "nan" not in got.out
    assert "gyro_x" in got.err
    assert (code, "gyro_y" in got.out) == (0, True)


@pytest.mark.parametrize("name", ["inspect", "analyze", "psd"])
def test_signalling_nans_are_missing_numbers(tmp_path, capsys, name):
    """A flipped bit of a single-precision number makes one; to convert it is an invalid operation."""
    rng = np.random.default_rng(7)
    columns = {f"{s}_{a}": rng.normal(size=3000).astype("f4") for s in ("gyro", "accel") for a in "xyz"}
    columns["gyro_x"].view("u4")[[5, 2000]] = columns["accel_z"].view("u4")[0] = 0x7FA00001
    np.savez(tmp_path / "log.npz", **columns)
    assert main([name, str(tmp_path / "log.npz"), "--rate", "100", "--unit", "gyro=rad/s,accel=g"]) == 0
    assert not re.search(r"\bnan\b", capsys.readouterr().out)


def test_a_subinterpreter_analyses():
    """The numbers of the main interpreter, which must not have NumPy: NumPy starts once in a process."""
    code = """
import numpy as np, sigmatau as st
rates = 1e-3 * np.random.default_rng(1).standard_normal(5000)
print(st.analyze(st.Record.from_arrays(rate=100, gyro_x=rates)).to_json(), flush=True)
"""
    sub = f"""
try:
    import _interpreters as interpreters
except ImportError:
    import _xxsubinterpreters as interpreters
interpreters.run_string(interpreters.create(), {code!r})
"""
    results = []
    for program in (code, sub):
        command = [sys.executable, "-W", "ignore", "-c", program]
        results.append(subprocess.run(command, env=ENVIRONMENT, capture_output=True, text=True, check=True).stdout)
    assert results[0] == results[1]
    assert json.loads(results[0])["channels"]["gyro_x"]["fit"]["verdict"] == "adequate"
