"""Recordings that others made: a page on what the programs make of them, and hosts for injected effects.

The recordings are not in the repository. `python3 -m fluxcal_proof.recordings` writes the page
(docs/proof/real.md). Scores use the hosts:

    hosts(data, programs) -> list[Host]
        Real recordings at rest, read by `ingest`; those whose folder is missing are left out.

    Host
        name, words, source           which recording, and how it was cut
        kind                          "pair" (two vectors), "ambient" (a vector in a known field),
                                      "scalar" (a vector beside a scalar magnetometer), "single"
        document                      dict, as it came: calibration and one recording
        rows, scatter_nt              rms of what the basic model leaves of it, nT

    suits(host) -> list[str]
        Names of the members of which a host has the inputs.

    inject(host, member, strength, rng) -> Injection | None
        An effect whose residual under the basic model is `strength` times the scatter of the host (rms);
        None where it cannot be reached, or does not show in this host.

    injections(hosts, seed, number) -> list[Injection]
        At least `number`, if the hosts carry them: hosts by turns, members in a drawn order, strengths by
        turns of `STRENGTHS`. The same seed gives the same injections.

    Injection
        document    dict, for `diagnose`: the host's with the effect added to its readings
        truth       dict: host, kind, family, member, sensors (list of "x", "y", "z"; empty for all),
                    accepted (list of the names that are right, "member" or "member x"), parameters
                    (in the catalogue's names, as far as they are known), strength, left_nt, scatter_nt
        untouched   dict, the host's document as it came: right is to claim nothing

Which hosts answer `agrees` before anything is injected is for the scores to ask: others are told, not used.
"""

from .hosts import Host, hosts
from .inject import STRENGTHS, Injection, inject, injections, suits

__all__ = ["STRENGTHS", "Host", "Injection", "hosts", "inject", "injections", "suits"]
