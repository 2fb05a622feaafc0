"""Recordings that others made: a page on what the programs make of them, and hosts for injected effects.

The recordings are not in the repository. `python3 -m fluxcal_proof.recordings` writes the page (docs/proof/real.md). Scores use the hosts:

    hosts(data, programs)    -> list[Host]: recordings at rest, read by `ingest`; of a missing folder one line is printed
        Host.name, .words, .source    which recording, how it was cut, where it comes from
        Host.kind                     "pair" (two vectors), "ambient" (a vector in a known field), "scalar" (a vector beside a scalar
                                      magnetometer) or "single"
        Host.document                 dict, as it came: calibration and one recording
        Host.rows, .scatter_nt        rms of what the basic model leaves of it, nT
    suits(host)              -> list[str]: the members of which it has the inputs
    inject(host, member, strength, rng) -> Injection | None: an effect whose residual under the basic model is `strength` times the scatter
                                of the host (rms); None where it cannot be reached, or does not show in this host
    injections(hosts, seed, number) -> list[Injection]: so many, if the hosts carry them: hosts by turns, members in a drawn order,
                                strengths by turns of `STRENGTHS`; the same seed gives the same injections
        Injection.document      dict for `diagnose`: the host's with the effect added to its readings
        Injection.truth         dict: host, kind, family, member, sensors (of "x", "y", "z"; empty for all), accepted (names that are
                                right, "member" or "member x"), parameters (in the catalogue's names), strength, left_nt, scatter_nt
        Injection.untouched     dict, the host's document as it came: right is to claim nothing

Which hosts answer `agrees` before anything is injected is for the scores to ask: others are told, and not used.
"""
from .hosts import STRENGTHS, Host, Injection, hosts, inject, injections, suits

__all__ = ["STRENGTHS", "Host", "Injection", "hosts", "inject", "injections", "suits"]
