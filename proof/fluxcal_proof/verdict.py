"""What an answer claims, held against the truth: family, member and form."""
from dataclasses import dataclass, field
from typing import Any

import numpy as np

# A family or a member has a word from these probabilities on; what a printed share below the last says is no claim.
NAMED, MENTIONED, SHARE = 0.9, 0.05, 0.01
# The rms with an answer may be so much larger than the rms with the truth.
FORM = 1.05


@dataclass
class Outcome:
    """One case: what was concealed and what was made of it."""

    name: str
    truth: dict[str, Any]
    verdict: str
    seconds: float
    claims: list[list[str]]
    # For each concealed effect: whether its family was told, and `right`, `set` or `none`.
    families: list[bool] = field(default_factory=list)
    members: list[str] = field(default_factory=list)
    # Names, alone or in a set, that are not right.
    wrong: list[list[str]] = field(default_factory=list)
    form: float | None = None
    empirical: float | None = None
    printed: list[tuple[float, bool]] = field(default_factory=list)
    intervals: list[tuple[str, float]] = field(default_factory=list)

    @property
    def sort(self) -> str:
        """What is concealed: single, several, clean, unnamed, undecidable, injected or recorded."""
        return str(self.truth.get("turn") or self.truth["sort"])

    @property
    def right(self) -> bool:
        """All that is concealed is told, alone or in a set, and nothing else."""
        if not self.truth["effects"]:
            return self.verdict == "agrees"
        if self.sort == "unnamed":
            return not self.wrong and self.verdict not in ("agrees", "failed")
        return not self.wrong and all(member != "none" for member in self.members)


def word(effect: dict[str, Any]) -> str:
    """An effect as the sets of an answer write it."""
    name = str(effect["effect"])
    sensor, column = effect.get("sensor") or effect.get("coil"), effect.get("column")
    if name == "dependence" and sensor:
        return f"dependence of {sensor} on {column}"
    return " ".join(str(part) for part in (name, column or sensor) if part)


def matches(name: str, right: list[list[str]]) -> bool:
    """Whether a name is one of those that are right; a target that is not given may be any."""
    words = name.split(' in "')[0].split()
    return any(words[0] == effect and (not target or target in words[1:]) for effect, target in right)


def claims(entry: dict[str, Any]) -> list[list[str]]:
    """For each effect the names that are indistinguishable: the list of sets goes through the effects in order."""
    out = [[word(effect)] for effect in entry.get("effects", [])]
    at = -1
    for members in entry.get("ambiguity", []):
        name = " with ".join(members)
        begins = next((i for i in range(at + 1, len(out)) if out[i] == name.split(' in "')[:1]), None)
        if begins is not None:
            at = begins
        elif at >= 0:
            out[at].append(name)
        else:
            out.append([name])
            at = len(out) - 1
    return out


def told_by_family(entry: dict[str, Any]) -> dict[str, list[str]]:
    """Members that are mentioned, by family that is named."""
    out: dict[str, list[str]] = {}
    for family in entry.get("families") or []:
        if family["probability"] >= NAMED and (family.get("share") or 0) >= SHARE:
            out[family["family"]] = [m["effect"] for m in family.get("members", []) if m["probability"] >= MENTIONED]
    for effect in entry.get("effects", []):
        if effect.get("family"):
            out.setdefault(effect["family"], []).append(word(effect))
    return out


def judge(name: str, truth: dict[str, Any], answer: dict[str, Any]) -> Outcome:
    entry, number = answer["entry"], len(truth["effects"])
    if entry is None:
        return Outcome(name, truth, "failed", answer["seconds"], [], [False] * number, ["none"] * number)
    told, named = claims(entry), told_by_family(entry)
    out = Outcome(name, truth, entry["verdict"], answer["seconds"], told)
    rights = [right for effect in truth["effects"] for right in effect["right"]]
    out.wrong = [names for names in told if not any(matches(one, rights) for one in names)]
    for effect in truth["effects"]:
        out.families.append(effect["family"] in named)
        out.members.append(member(effect, told, named.get(effect["family"], [])))
        if effect.get("undecidable") and out.members[-1] == "wrong":
            out.wrong.append([one for names in told for one in names])
    if "floor_nt" in truth and entry.get("fit"):
        out.form = entry["fit"]["held_out_after_nt"] / truth["floor_nt"]
    out.printed = [(e["probability"], matches(word(e), rights)) for e in entry.get("effects", []) if e.get("probability") is not None]
    out.intervals = [one for effect in truth["effects"] for one in departures(effect, entry)]
    return out


def of_names(names: list[str], families: dict[str, str]) -> dict[str, Any]:
    """An answer that consists of names, as a rival gives it."""
    effects = [{"effect": name.split()[0], "column": " ".join(name.split()[1:]) or None, "family": families.get(name.split()[0])} for name in names]
    return {"verdict": "explained" if names else "agrees", "effects": effects}


def of_diffmag(fit: dict[str, Any]) -> list[str]:
    """What `diffmag` claims, in the names of effects: columns, a clock off by four uncertainties, drift and steps."""
    names = {f"dependence {one['column']}" for axis in fit["axes"].values() for one in axis.get("follows", [])}
    names |= {"ageing" for axis in fit["axes"].values() if axis["drift"].get("demanded", "none") != "none"}
    names |= {"reading_step" for event in fit.get("kept_out", {}).get("events", []) if event["kind"] == "step"}
    clock = fit.get("clock") or {}
    off = clock.get("offset_s") or {}
    if off.get("value") is not None and off.get("std") and abs(off["value"]) > 4 * off["std"]:
        names.add("clock_offset")
    return sorted(names)


def member(effect: dict[str, Any], told: list[list[str]], of_family: list[str]) -> str:
    """`right`, `set`, `wrong` (one name where nobody can tell) or `none`."""
    own = [names for names in told if any(matches(name, effect["right"]) for name in names)]
    mentioned = [name for names in own for name in names] + of_family
    if effect.get("undecidable"):
        if all(any(matches(name, [right]) for name in mentioned) for right in effect["right"]):
            return "right"
        return "wrong" if own else "none"
    if any(all(matches(name, effect["right"]) for name in names) for names in own):
        return "right"
    return "set" if own or any(matches(name, effect["right"]) for name in of_family) else "none"


def departures(effect: dict[str, Any], entry: dict[str, Any]) -> list[tuple[str, float]]:
    """By how much parameters are off, half of each interval of 95 % being 1.96; not those that are lower bounds."""
    out = []
    for found in entry.get("effects", []):
        if not matches(word(found), effect["right"]):
            continue
        for key, true in effect.get("parameters", {}).items():
            quantity = (found.get("parameters") or {}).get(key)
            if not isinstance(quantity, dict) or quantity.get("at_least") or not quantity.get("std"):
                continue
            half = quantity["std"] * quantity.get("coverage_factor_95", 1.96)
            if quantity.get("interval_95"):
                half = abs((quantity["interval_95"][true > quantity["value"]] or np.inf) - quantity["value"])
            out.append((f"{found['effect']}.{key}", float((quantity["value"] - true) / half * 1.96)))
    return out
