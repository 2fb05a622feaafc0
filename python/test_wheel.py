"""The installed wheel: `python test_wheel.py FIXTURES`, in an environment of its own and a folder in which fluxcal's sources are not."""
import json
import logging
import math
import os
import pty
import re
import shutil
import subprocess
import sys
import tempfile
import time
import unittest
from importlib import metadata
from inspect import signature
from pathlib import Path
from unittest import mock

import fluxcal

FIXTURES = Path(sys.argv.pop(1)).resolve() if len(sys.argv) > 1 else Path("fixtures").resolve()
STAGES = {
    "coilcal": "coilcal/uneven", "sensorcal": "sensorcal/small", "axescal": "axescal/magsat", "scalarcal": "scalarcal/meadow",
    "starcal": "starcal/day", "diffmag": "diffmag/turned-pair", "absolute": "absolute/weeks", "diagnose": "diagnose/warm",
}


def document(name: str, file: str = "input.json") -> dict:
    return json.loads((FIXTURES / name / file).read_text())


class Programs(unittest.TestCase):
    def test_the_programs_are_those_of_the_wheel(self) -> None:
        scripts = [file for file in metadata.files("fluxcal") if file.name in (*STAGES, "fluxcal", "simulate", "ingest", "series", "correct", "report")]
        self.assertEqual(len(scripts), 14)
        for script in scripts:
            self.assertTrue(os.access(script.locate(), os.X_OK), script)
        self.assertTrue(Path(fluxcal.__file__).is_relative_to(sys.prefix), fluxcal.__file__)
        said = subprocess.run([shutil.which("fluxcal"), "axescal", "--version"], capture_output=True, text=True)
        self.assertEqual(said.stdout, f"axescal {fluxcal.__version__}\n")
        self.assertEqual(metadata.version("fluxcal"), fluxcal.__version__)
        with mock.patch.dict(os.environ, PATH=""):
            self.assertIn("heat", fluxcal.effects("coil_heating"))

    def test_each_stage_of_a_dict_and_of_a_file(self) -> None:
        for name, fixture in STAGES.items():
            stage = getattr(fluxcal, name)
            of_dict, of_file = stage(document(fixture)), stage(FIXTURES / fixture / "input.json")
            self.assertEqual(of_dict["history"][-1]["stage"], name)
            of_dict.pop("history"), of_file.pop("history")
            self.assertEqual(of_dict, of_file, name)

    def test_every_option_of_a_stage_has_its_parameter(self) -> None:
        apart = {"output", "in_place", "quiet", "completions", "man", "help", "version", "plan"}
        for name in STAGES:
            help = subprocess.run([shutil.which(name), "--help"], capture_output=True, text=True).stdout
            options = {option.replace("-", "_") for option in re.findall(r"^ +(?:-\w, )?--([\w-]+)", help, re.M)} - apart
            parameters = {one.rstrip("_") for one in signature(getattr(fluxcal, name)).parameters} - {"document"}
            self.assertEqual(options, parameters, name)

    def test_options_reach_the_program(self) -> None:
        found = fluxcal.axescal(FIXTURES / "axescal/magsat-known-coils/input.json", known_coils=True, sensor="x")
        self.assertEqual(found["history"][-1]["arguments"], ["--known-coils", "--sensor=x"])
        budget = fluxcal.sensorcal(document("sensorcal/small"), budget_field_nt=[-50000.0, 0.0, 1e4])
        self.assertIn("--budget-field-nt=-50000,0,10000", budget["history"][-1]["arguments"])
        lean = fluxcal.scalarcal(document("scalarcal/meadow"), place=(48.1, 11.3, 573), date="2022-08-10", drop_recordings=True)
        self.assertIn("--place=48.1,11.3,573", lean["history"][-1]["arguments"])
        self.assertEqual(len(lean["recordings"][0]["dropped"]["sha256"]), 64)
        self.assertNotIn("columns", lean["recordings"][0])

    def test_the_other_programs(self) -> None:
        plan = json.loads((FIXTURES / "tutorial/campaign.json").read_text())
        campaign = fluxcal.simulate(plan, seed=3)
        self.assertEqual(campaign["history"][-1]["arguments"], ["campaign", "--seed=3"])
        calibrated = fluxcal.axescal(fluxcal.sensorcal(fluxcal.coilcal(campaign)))
        self.assertAlmostEqual(calibrated["calibration"]["sensors"]["x"]["sensitivity_nt_per_v"]["value"], 6401.2, delta=0.02)
        self.assertEqual(len(fluxcal.replay(calibrated)["recordings"]), 13)
        weeks = fluxcal.observatory(FIXTURES / "plans/observatory.json", seed=5)
        self.assertEqual((weeks["history"][-1]["arguments"], len(weeks["recordings"])), (["observatory", "--seed=5"], 17))
        self.assertEqual(len(fluxcal.sweep(plan, seeds="1..3")), 3)
        self.assertIn("heat", fluxcal.effects("coil_heating"))
        page = fluxcal.report(calibrated)
        self.assertIn("<html", page)
        self.assertIn("<iframe srcdoc=", page._repr_html_())
        certificate = fluxcal.certificate(document("specs/calibrated"), data={"number": "K-12"}, spec=FIXTURES / "specs/magsat.json", paper="a4")
        self.assertIn("Statement of conformity", certificate)
        self.assertNotIn("No statement of conformity", certificate)
        self.assertTrue("<title>Calibration certificate K-12</title>" in certificate)
        self.assertIn("design", fluxcal.design(number=3, table_to=4))
        guessed = fluxcal.guess(FIXTURES / "tutorial/rotation.csv")
        read = fluxcal.ingest(FIXTURES / "tutorial/rotation.csv", map=guessed, id="turned")
        cut = fluxcal.series(read, "cut", to=100)
        self.assertEqual(len(cut["recordings"][0]["columns"]["time_s"]), 100)
        self.assertIn("test_x_nt", fluxcal.series(read, "rename", "sensor=test")["recordings"][0]["columns"])
        both = fluxcal.ingest(FIXTURES / "tutorial/hut.csv", add=fluxcal.ingest(FIXTURES / "tutorial/pier.min"), id="hut", as_="test")
        self.assertEqual(len(both["recordings"]), 2)
        pieces = [fluxcal.diffmag_stream(FIXTURES / f"diffmag/pieces/{name}.csv", partial=True) for name in ("morning", "evening")]
        whole = fluxcal.diffmag_stream(*(FIXTURES / f"diffmag/pieces/{name}.csv" for name in ("morning", "evening")))
        self.assertEqual(fluxcal.diffmag_merge(pieces)["calibration"], whole["calibration"])
        self.assertIn("field_x_nt", fluxcal.correct(document("correct/flight"))["recordings"][0]["columns"])

    def test_words_go_to_the_log(self) -> None:
        with self.assertLogs("fluxcal", logging.INFO) as log:
            fluxcal.scalarcal(document("scalarcal/meadow"))
        self.assertIn("sensitivity of x: 6412.782 ± 0.013 nT/V", log.output[0])


class Faults(unittest.TestCase):
    def test_a_fault_has_message_path_file_and_line(self) -> None:
        bad = FIXTURES / "bad/nan-as-text.json"
        with self.assertRaises(fluxcal.Refused) as caught:
            fluxcal.axescal(bad)
        fault = caught.exception
        self.assertEqual((fault.program, fault.exit_code, fault.file), ("axescal", 2, str(bad)))
        self.assertRegex(fault.path, r"^recordings\[\d+\]\.columns\.\w+\[\d+\]$")
        self.assertIn("NaN", bad.read_text().splitlines()[fault.line - 1])
        self.assertIn("expected a number, or null", fault.message)
        self.assertIn(fault.message, str(fault))

    def test_the_places_of_all_bad_documents(self) -> None:
        placed = 0
        for bad in sorted((FIXTURES / "bad").glob("*.json")):
            with self.assertRaises(fluxcal.Error) as caught:
                fluxcal.axescal(bad)
            fault = caught.exception
            if ", line " in fault.message.splitlines()[0] and str(bad) in fault.message:
                self.assertEqual(fault.file, str(bad), fault.message)
                self.assertGreater(fault.line, 0)
                placed += fault.path is not None
        self.assertGreater(placed, 10)

    def test_what_cannot_be_told(self) -> None:
        with self.assertRaises(fluxcal.Undetermined) as caught:
            fluxcal.coilcal(FIXTURES / "bad/coilcal/two-levels.json")
        self.assertEqual(caught.exception.exit_code, 1)
        with self.assertRaises(fluxcal.Refused):
            fluxcal.axescal(document("axescal/magsat"), start="nowhere")


class Frames(unittest.TestCase):
    def test_a_recording_as_a_frame_of_each_kind(self) -> None:
        read = fluxcal.ingest(FIXTURES / "tutorial/rotation.csv")
        values = read["recordings"][0]["columns"]
        pandas, polars, arrow = (fluxcal.frame(read, kind=kind) for kind in ("pandas", "polars", "arrow"))
        self.assertEqual((len(pandas), polars.height, arrow.num_rows), (300, 300, 300))
        self.assertEqual(str(pandas["time"].iloc[0]), "2026-06-12 09:30:00+00:00")
        self.assertEqual(int(pandas["reference_nt"].isna().sum()), 2)
        self.assertEqual(polars["reference_nt"].null_count(), 2)
        for name, column in values.items():
            self.assertEqual(polars[name].to_list(), column)

    def test_a_frame_becomes_the_recording_that_it_was(self) -> None:
        read = fluxcal.ingest(FIXTURES / "tutorial/rotation.csv")
        was = read["recordings"][0]
        for kind in ("pandas", "polars", "arrow"):
            again = fluxcal.recording(fluxcal.frame(read, kind=kind), was["id"], start=was["start"])
            self.assertEqual((again["columns"], again["start"]), (was["columns"], was["start"]), kind)
        found = fluxcal.scalarcal({"fluxcal": 1, "recordings": [again]})
        self.assertEqual(found["calibration"], fluxcal.scalarcal(read)["calibration"])

    def test_a_corrected_series(self) -> None:
        read = fluxcal.ingest(FIXTURES / "tutorial/rotation.csv")
        calibrated = fluxcal.scalarcal(read)
        for kind in ("pandas", "polars", "arrow"):
            readings = fluxcal.frame(read, kind=kind)
            field = fluxcal.corrected(readings, calibrated)
            self.assertIs(type(field), type(readings))
            column = lambda name: field[name].to_list() if kind != "arrow" else field[name].to_pylist()
            off = [math.hypot(x, y, z) - f for x, y, z, f in zip(*map(column, ("field_x_nt", "field_y_nt", "field_z_nt", "reference_nt")))
                   if f is not None and f == f]
            self.assertEqual(len(off), 298)
            self.assertLess(math.sqrt(sum(one * one for one in off) / len(off)), 0.7)
        of_file = fluxcal.corrected(FIXTURES / "tutorial/rotation.csv", calibrated, map=fluxcal.guess(FIXTURES / "tutorial/rotation.csv"))
        self.assertEqual(of_file["field_x_nt"].to_list(), fluxcal.corrected(fluxcal.frame(read), calibrated)["field_x_nt"].to_list())

    def test_a_plot(self) -> None:
        figure = fluxcal.plot(fluxcal.correct(document("correct/flight")), document("correct/flight")["recordings"][0]["id"])
        self.assertEqual(len(figure.axes), 3)
        labels = [line.get_label() for panel in figure.axes for line in panel.lines]
        self.assertTrue(any(label.startswith("field_x_nt") for label in labels), labels)
        with tempfile.TemporaryDirectory() as folder:
            figure.savefig(Path(folder) / "plot.png")
            self.assertGreater((Path(folder) / "plot.png").stat().st_size, 10_000)

    def test_results_are_frames_and_plots(self) -> None:
        answer = document("diagnose/warm", "expected.json")
        found = fluxcal.results(answer)
        series = answer["diagnosis"][0]["series"][0]
        self.assertEqual(list(found["diagnosis.0.series.0"]["before_nt"]), series["before_nt"])
        figure = fluxcal.plot(answer, result="diagnosis.0.series.0")
        self.assertGreaterEqual(len(figure.axes[0].lines), 2)
        with self.assertRaisesRegex(KeyError, "expected one of"):
            fluxcal.plot(answer, result="calibration")


class Terminal(unittest.TestCase):
    def shown(self, *arguments: str) -> str:
        """What a program that waits three seconds for its input shows on a terminal."""
        import fcntl
        import struct
        import termios

        ours, theirs = pty.openpty()
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
        run = subprocess.Popen([shutil.which("scalarcal"), *arguments], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=theirs,
                               env={**os.environ, "TERM": "xterm"})
        os.close(theirs)
        time.sleep(3)
        run.stdin.write((FIXTURES / "scalarcal/meadow/input.json").read_bytes())
        run.stdin.close()
        shown = b""
        try:
            while more := os.read(ours, 4096):
                shown += more
        except OSError:
            pass
        self.assertEqual(run.wait(), 0)
        return shown.decode()

    def test_progress_is_shown_on_a_terminal_and_not_with_quiet(self) -> None:
        shown = self.shown()
        self.assertIn("scalarcal: working (2s)", shown)
        self.assertIn("sensitivity of x", shown)
        self.assertEqual(self.shown("-q"), "")


if __name__ == "__main__":
    unittest.main()
