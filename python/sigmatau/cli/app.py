"""The commands by name. The module of a command is imported when it is called."""

from __future__ import annotations

from cyclopts import App

from sigmatau._version import __version__

_EXIT_CODES = (
    "Exit codes: 0 done · 1 a file or its data cannot be used · 2 an option is wrong or missing"
    " · 3 a unit does not meet its specification (lot) · 4 done with the readable part of a damaged file, or some units"
    " of a lot are not judged (lot)"
    " · 5 the sensor is not at rest or the record too short to tell, so that there are no coefficients (analyze)"
    " · 130 interrupted · 143 terminated."
    " Tables and JSON go to standard output, messages to standard error."
)

# name: (summary, examples)
_COMMANDS = {
    "analyze": (
        "Analyse a log of a sensor at rest: Allan deviation and noise coefficients of every axis.",
        """\
sigmatau analyze static.csv --report static.html
sigmatau analyze imu.txt --channels time=1,gyro=2:4,accel=5:7 --unit time=s,gyro=rad/s,accel=g
sigmatau analyze counts.csv --rate 100 --unit gyro=deg/s --scale gyro=0.0061 --json result.json
sigmatau analyze laser_gyro.csv --input increments --unit gyro=arcsec,accel=m/s
sigmatau analyze static.csv --export kalibr=imu.yaml
sigmatau analyze night1.csv night2.csv --jobs 2 --json results
sigmatau analyze day1.csv day2.csv --joint --json unit.json
sigmatau analyze night1.csv night2.csv --overlay nights.png""",
    ),
    "inspect": (
        "Show the contents of a log and its faults: topics, columns, rates, damage.",
        """\
sigmatau inspect static.csv
sigmatau inspect counts.csv --unit gyro=deg/s --scale gyro=0.0061 --rate 100 --json found.json""",
    ),
    "deviation": (
        "Compute another deviation of every axis: modified Allan, Hadamard, parabolic, total, time, Theo, MTIE, TIE rms.",
        """\
sigmatau deviation static.csv --kind hadamard --noise random_walk --plot hadamard.png
sigmatau deviation static.csv --kind mtie --taus 0.1,1 --json mtie.json""",
    ),
    "psd": (
        "Compute power spectral densities of every axis, two-sided, with intervals; compare them with a noise model.",
        """\
sigmatau psd static.csv --plot psd.svg --json psd.json
sigmatau psd static.csv --segment 1s --axes gyro,accel_x
sigmatau psd static.csv --method multitaper --tapers 20 --f-max 5Hz
sigmatau psd static.csv --method multitaper --model result.json""",
    ),
    "density": (
        "Turn a measured power spectral density into Allan deviations and a noise model.",
        """\
sigmatau density density.csv --sided one --unit "(rad/s)^2/Hz"
sigmatau density density.csv --sided one --unit "(rad/s)^2/Hz" --averages 50 -o measured.toml --csv deviations.csv""",
    ),
    "curve": (
        "Fit the noise terms to Allan deviations of another program, or of a figure (SVG, PDF, clicked points).",
        """\
sigmatau curve adev.csv --rate 100 --hours 2 -o imu.toml --plot adev.png
sigmatau curve stable32.txt --rate 100 --hours 2 --columns tau=2,gyro_x=6 --unit deg/h --content deviation
sigmatau curve figure.svg --list
sigmatau curve figure.svg --unit deg/h --line 1 -o imu.toml
sigmatau curve clicks.csv --unit deg/h --x-axis 80=0.01,480=100 --y-axis 310=1,30=1000""",
    ),
    "bandwidth": (
        "Find the bandwidth and filter of a sensor, its noise without aliasing, and the rate to sample at.",
        """\
sigmatau bandwidth 50Hz.csv 500Hz.csv --plot fig12.png
sigmatau bandwidth fast.csv --json bandwidth.json
sigmatau bandwidth slow.txt fast.txt --rate 50,500 --channels gyro=1:3 --unit gyro=deg/s""",
    ),
    "tune": (
        "Find which noise of a filter is wrong, and by which factor, from its innovations.",
        """\
sigmatau tune innovations.csv
sigmatau tune innovations.csv --noise gyro="0.35 deg/sqrt(h)" --walk gyro="120 deg/h/sqrt(h)" --plot white.png
sigmatau tune run.csv --columns gyro_x=r0:s0,gyro_y=r1:s1 --model imu.toml --json tune.json""",
    ),
    "simulate": (
        "Simulate a sensor at rest from its noise model, and write the log.",
        """\
sigmatau simulate imu.toml --hours 2 --rate 100 --seed 1 -o simulated.csv
sigmatau simulate imu.toml --hours 2 --rate 100 --level accel_x=1g --lsb gyro=0.01deg/s,accel=1mg --gaps 0.1% -o real.csv
sigmatau simulate imu.toml --hours 2 --rate 100 --temperature start=20degC,end=35degC --sensitivity gyro=5deg/h/K -o warm.npy
sigmatau simulate rlg.toml --hours 2 --rate 100 --input increments --lsb gyro=0.1arcsec --jitter 20us -o laser.csv.gz""",
    ),
    "plan": (
        "Plan the length of a record that shows a noise term, or the smallest value that a record shows.",
        """\
sigmatau plan imu.toml --term bias_instability --rate 100 --hours 2
sigmatau plan imu.toml --term rate_random_walk --rate 100 --value "20 deg/h/sqrt(h)"
sigmatau plan result.json --term bias_instability --hours 12""",
    ),
    "predict": (
        "Predict the error growth of unaided inertial navigation at rest: attitude, velocity, position, by noise term.",
        """\
sigmatau predict imu.toml --after 60s,10min --calibration 5min
sigmatau predict result.json --after 1s,10s,100s --calibration 100s --json
sigmatau predict imu.toml --after 1min --turn-on gyro="10 deg/h" --turn-on accel_x="1 mg" --plot errors.png""",
    ),
    "export": (
        "Write the parameters for Kalibr, OpenVINS, VINS, ORB-SLAM3, GTSAM, LIO-SAM, FAST-LIO …, in their units.",
        """\
sigmatau export --list
sigmatau export result.json --to kalibr -o imu.yaml
sigmatau export --from-datasheet bmi088 --to kalibr --filter-rate 200 -o imu.yaml
sigmatau export imu.toml --to vins --filter-rate 200 --rate-random-walk "accel=1e-5 m/s^3/sqrt(Hz)\"""",
    ),
    "watch": (
        "Follow a log while it is written: print curve and coefficients of all samples so far.",
        """\
logger | sigmatau watch --rate 200 --channels gyro=1:3 --unit gyro=deg/s
sigmatau watch growing.csv --idle 60 --json last.json""",
    ),
    "compare": (
        "Compare runs of a unit: repeatability, spread between runs with its interval, outlying runs.",
        """\
sigmatau compare day1.json day2.json day3.json --plot forest.png
sigmatau compare results --table --csv repeatability.csv
sigmatau compare table1.csv
sigmatau compare --store lab.db --unit "A*\"""",
    ),
    "lot": (
        "Judge a production lot against a specification, unit by unit; exit code 3 if one fails, 4 if one is unjudged.",
        """\
sigmatau lot unit1.json unit2.json --spec spec.toml -o lot.html
sigmatau lot shift --expect 2 --spec spec.toml -o lot.pdf -o lot.xml --results results
sigmatau lot shift --expect units.txt --spec spec.toml --fail-on warning""",
    ),
    "temperature": (
        "Measure noise and bias over temperature from a ramp, a soak or runs; write parameters of PX4 and ArduPilot.",
        """\
sigmatau temperature ramp.csv --report ramp.html
sigmatau temperature ramp.csv --axes gyro --mean=-20,25,60 --export px4=tc.params --export ardupilot=tcal.parm
sigmatau temperature runs --temperature-from 'T(-?[0-9]+)' --unit-from '(SN[0-9]+)' --csv matrix.csv""",
    ),
    "array": (
        "Combine several sensors of one axis: correlation of their noise, optimal weights, and the virtual sensor's noise.",
        """\
sigmatau array board.csv --channels gyro_1=2,gyro_2=3,gyro_3=4,gyro_4=5 --unit gyro=deg/s --plot array.png
sigmatau array board.csv --channels gyro_1=2,gyro_2=3,gyro_3=4,gyro_4=5 --unit gyro=deg/s --target 10s --write fused.csv
sigmatau array board.csv --channels gyro_1=2,gyro_2=3,gyro_3=4 --unit gyro=deg/s --common --json hat.json""",
    ),
    "datasheet": (
        "List published values of common sensors with their sources; print a sensor as a noise model.",
        """\
sigmatau datasheet list
sigmatau datasheet show ism330dhcx
sigmatau datasheet show ism330dhcx --model --sided one --bias minimum""",
    ),
    "fleet": (
        "Analyse many logs, or very long ones, on several processes or hosts, and add the results to a store.",
        """\
sigmatau fleet analyze 'logs/**' --store lab.db --workers 2
sigmatau fleet analyze 'night/*.csv' --store lab.db --unit-from '(unit[0-9]+)' --model ICM-42688-P --method gls""",
    ),
    "app": (
        "Open the workbench in the browser: choose columns and units, analyse, read off by eye, export.",
        """\
sigmatau app static.csv
sigmatau app logs --port 8765 --no-browser
sigmatau app --serial /dev/ttyUSB0 --rate 100 --channels gyro=1:3 --unit gyro=rad/s --save static.csv""",
    ),
    "demo": (
        "Simulate two hours of one of the paper's three units, analyse the log, and compare the result with the truth.",
        """sigmatau demo --output demo
sigmatau demo --unit motionpak2 --output mems""",
    ),
}

# Subcommands of `store`, in the same form.
_STORE = {
    "add": (
        "Add results of analyze to a store, each once.",
        """\
sigmatau store add results --store lab.db --unit A123 --model tactical --date 2026-05-01
sigmatau store add results --store lab.db --unit-from folder --temperature 25""",
    ),
    "list": (
        "List the units or the runs of a store.",
        """\
sigmatau store list --store lab.db
sigmatau store list runs --store lab.db --unit "A*" --since 2026-01-01 --json""",
    ),
    "show": (
        "Show the latest result of a unit, with intervals.",
        "sigmatau store show A123 --store lab.db",
    ),
    "trend": (
        "Follow a coefficient over time: median, spread and drift.",
        """\
sigmatau store trend --store lab.db --term random_walk --by month
sigmatau store trend --store lab.db --term bias_instability --channel gyro_x --by quarter --json trend.json""",
    ),
    "export": (
        "Export a table of a store to Parquet or CSV.",
        """\
sigmatau store export --store lab.db -o coefficients.parquet
sigmatau store export --store lab.db --what runs -o runs.csv""",
    ),
}

_MODULES = {"app": "workbench"}  # commands whose module has another name

# Usage of commands with optional arguments, which the library does not print.
_USAGE = {
    "analyze": "LOGS...",
    "app": "[PATHS...]",
    "bandwidth": "LOGS...",
    "export": "[SOURCE]",
    "watch": "[SOURCE]",
    "compare": "[RESULTS...]",
    "lot": "[UNITS...]",
    "temperature": "[LOGS...]",
    "array": "LOGS...",
    "datasheet": "ACTION [NAME]",
    "fleet": "ACTION [LOGS...]",
    "store add": "RESULTS...",
    "store list": "[WHAT]",
}


def _usage(name: str) -> str | None:
    return f"Usage: sigmatau {name} [OPTIONS] {_USAGE[name]}" if name in _USAGE else None


EXAMPLES = {
    name: examples
    for name, (_, examples) in (_COMMANDS | {f"store {name}": part for name, part in _STORE.items()}).items()
}
"""Command lines of the help pages, which the tests run."""

app: App = App(
    name="sigmatau",
    help="Characterise the noise of inertial sensors at rest: noise coefficients with confidence intervals from a log.",
    help_epilogue=_EXIT_CODES,
    version=f"sigmatau {__version__}",
    version_flags=["--version"],
    suppress_keyboard_interrupt=False,  # `main` reports interruptions
)
app.register_install_completion_command(name="--install-completion")
for _name, (_summary, _examples) in _COMMANDS.items():
    app.command(
        f"sigmatau.cli.{_MODULES.get(_name, _name)}:{_name}_command",
        name=_name,
        help=_summary,
        help_epilogue=f"Examples:\n\n```\n{_examples}\n```\n\n{_EXIT_CODES}",
        help_format="markdown",
        usage=_usage(_name),
    )

_store = App(name="store", help="Keep results in a database: SQLite file or PostgreSQL.", help_epilogue=_EXIT_CODES)
for _name, (_summary, _examples) in _STORE.items():
    _store.command(
        f"sigmatau.cli.store:{_name}_command",
        name=_name,
        help=_summary,
        help_epilogue=f"Examples:\n\n```\n{_examples}\n```\n\n{_EXIT_CODES}",
        help_format="markdown",
        usage=_usage(f"store {_name}"),
    )
app.command(_store)
