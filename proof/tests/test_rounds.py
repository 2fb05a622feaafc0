"""Rounds: independence, determinism, seals, verdicts and goals."""
import ast
import hashlib
import json
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

from fluxcal_proof import cases, effects, folder, goals, groups, pairs, plan, rivals, score, verdict

PACKAGE = Path(folder.__file__).parent
ALLOWED = {"numpy", "scipy", "matplotlib", "pandas", "pysindy", "sklearn", "fluxcal_proof"}


class Package(unittest.TestCase):
    def test_it_imports_nothing_of_fluxcal(self) -> None:
        for path in PACKAGE.rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text())):
                names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
                names += [node.module or ""] if isinstance(node, ast.ImportFrom) and not node.level else []
                for name in names:
                    root = name.split(".")[0]
                    self.assertTrue(root in ALLOWED or root in sys.stdlib_module_names, f"{path.name} imports {name}")

    def test_each_group_has_kinds_of_every_sort(self) -> None:
        for of, least in (("develop", 30), ("score", 20)):
            self.assertGreaterEqual(len(groups.of_group(effects.KINDS, of, "single")), least, of)
            self.assertGreaterEqual(len(groups.of_group(effects.KINDS, of, "unnamed")), 4)
            self.assertGreaterEqual(len(groups.of_group(pairs.KINDS, of, "single")), 9)

    def test_a_round_has_its_shares(self) -> None:
        sorts = [plan.sort(number) for number in range(1000)]
        self.assertGreaterEqual(sum(sort == "pair" and index % plan.DAY_EVERY == 10 for sort, index in sorts), 20)
        self.assertGreaterEqual(sum(sort == "clean" for sort, _ in sorts), 100)
        self.assertAlmostEqual(sum(sort == "pair" for sort, _ in sorts) / 1000, 1 / 3, delta=0.01)


class Seals(unittest.TestCase):
    def test_the_same_seed_gives_the_same_bytes(self) -> None:
        for number in (0, 1, 2):
            one, other = (json.dumps(cases.make(9, number, "score").document) for _ in range(2))
            self.assertEqual(hashlib.sha256(one.encode()).digest(), hashlib.sha256(other.encode()).digest())

    def test_what_was_opened_takes_no_answers_and_a_changed_truth_is_found(self) -> None:
        with tempfile.TemporaryDirectory() as place:
            where = Path(place) / "round"
            folder.make(where, 5, 3, "develop", "all")
            with self.assertRaises(folder.Refused):
                folder.make(where, 5, 3, "develop", "all")
            folder.refuse_if_opened(where)
            score.read(where)
            with self.assertRaises(folder.Refused):
                folder.refuse_if_opened(where)
            truth = next((where / "truths").glob("*.json"))
            truth.write_text(truth.read_text().replace('"seed": 5', '"seed": 6'))
            with self.assertRaises(folder.Refused):
                folder.open_truths(where)


def effect(**more: object) -> dict:
    return {"kind": "delay", "form": "", "family": "late_response", "strength": 1.0, "right": [["delay", "x"], ["loop_bandwidth", "x"]], **more}


def judged(effects: list, entry: dict) -> verdict.Outcome:
    truth = {"sort": "single" if effects else "clean", "effects": effects, "noise_nt": 1.0, "rows": 9, "manners": [], "number": 0}
    return verdict.judge("a", truth, {"entry": entry, "seconds": 1.0})


class Verdicts(unittest.TestCase):
    def test_members(self) -> None:
        lag = {"effect": "delay", "sensor": "x", "family": "late_response", "probability": 0.97, "parameters": {"delay_s": {"value": 1.2, "std": 0.1}}}
        one = judged([effect(parameters={"delay_s": 1.0})], {"verdict": "explained", "effects": [lag]})
        self.assertEqual((one.members, one.families, one.wrong, one.right), (["right"], [True], [], True))
        self.assertAlmostEqual(one.intervals[0][1], 2.0, places=6)
        two = judged([effect()], {"verdict": "explained", "effects": [lag, {"effect": "spike", "sensor": "y", "family": "moments"}]})
        self.assertEqual((two.wrong, two.right), ([["spike y"]], False))
        of_set = judged([effect()], {"verdict": "ambiguous", "effects": [lag], "ambiguity": [["delay x"], ["eddy_currents z"]]})
        self.assertEqual((of_set.members, of_set.wrong), (["set"], []))
        family = [{"family": "late_response", "probability": 0.95, "share": 0.8, "members": [{"effect": "delay x", "probability": 0.6}]}]
        self.assertEqual(judged([effect()], {"verdict": "unexplained", "effects": [], "families": family}).members, ["set"])

    def test_nobody_can_tell(self) -> None:
        two = effect(undecidable=True)
        single = judged([two], {"verdict": "explained", "effects": [{"effect": "delay", "sensor": "x", "family": "late_response"}]})
        self.assertEqual((single.members, single.right), (["wrong"], False))

    def test_clean(self) -> None:
        self.assertTrue(judged([], {"verdict": "agrees", "effects": []}).right)
        self.assertFalse(judged([], {"verdict": "unexplained", "effects": []}).right)

    def test_goals_count(self) -> None:
        one = judged([effect()], {"verdict": "agrees", "effects": []})
        rows = {goal.title: own for goal, own, _ in goals.reached(score.Round("", 0, "score", [one], {}))}
        self.assertEqual(rows["campaigns, one effect of at least the noise: family"], (0, 1))

    def test_wilson(self) -> None:
        low, high = score.wilson(8, 10)
        self.assertAlmostEqual(low, 0.4902, places=4)
        self.assertAlmostEqual(high, 0.9433, places=4)


class Rivals(unittest.TestCase):
    def test_stepwise_finds_what_least_squares_shows(self) -> None:
        rng = np.random.default_rng(2)
        x = rng.normal(size=(400, 8))
        y = 0.5 * x[:, 2] - 0.3 * x[:, 5] + 0.2 * rng.normal(size=400)
        self.assertEqual(sorted(rivals.stepwise(y, x)), [2, 5])
