"""Runs every case, each program in a process of its own, and writes the tables."""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from cases import AIMS, CASES, PAPERS, lion4

sys.path.append(str(Path(__file__).resolve().parents[1]))
from section import machine, write_section

HERE = Path(__file__).resolve().parent
THREADS = 4
LIMIT = 1500
SLEPC = "/usr/lib/slepcdir/slepc3.18/x86_64-linux-gnu-real/lib/python3/dist-packages"
PETSC = "/usr/lib/petscdir/petsc3.18/x86_64-linux-gnu-real/lib/python3/dist-packages"


def timed(command, threads, extra=None, limit=LIMIT):
    """The JSON that a program printed, with the peak memory of its process in MB."""
    environment = dict(os.environ, **(extra or {}))
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        environment[name] = str(threads)
    # Idle BLAS threads must not spin where other programs run.
    environment["OMP_WAIT_POLICY"] = "passive"
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        process = subprocess.Popen(command, stdout=out, stderr=err, env=environment, cwd=HERE)
        start = time.monotonic()
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                break
            if time.monotonic() - start > limit:
                process.kill()
                os.wait4(process.pid, 0)
                return dict(error=f"over {limit} s")
            time.sleep(0.005)
        process.returncode = status
        out.seek(0), err.seek(0)
        if status != 0:
            lines = err.read().decode(errors="replace").strip().splitlines() or ["no message"]
            return dict(error=lines[-1])
        answer = json.loads(out.read())
    answer["memory_mb"] = usage.ru_maxrss / 1024
    return answer


class Bench:
    def __init__(self, folder, data):
        self.folder, self.data = folder, data
        self.program = os.environ["CHLADNI"]
        self.python = sys.executable
        self.slepc_python = os.environ.get("SLEPC_PYTHON", "/usr/bin/python3")
        self.spectra = folder / "spectra"
        subprocess.run(["g++", "-O3", "-march=native", "-DNDEBUG", "-I/usr/include/eigen3",
                        str(HERE / "peer_spectra.cpp"), "-o", str(self.spectra)], check=False)

    def mesh(self, name):
        if name != "lion4":
            return self.data / "meshes" / name
        path = self.folder / "lion4.off"
        if not path.exists():
            lion4(self.data / "meshes/animals/lion.off", path)
        return path

    def ours(self, mesh, k, threads, repeats, export=()):
        runs = []
        for repeat in range(repeats):
            answer = timed([self.program, "basis", str(self.mesh(mesh)), "-k", str(k), "--json", "--no-cache",
                            "--quiet", "--threads", str(threads), *(export if repeat == 0 else ())], threads)
            if "error" in answer:
                return answer
            runs.append(answer)
        # Memory of a run that exports nothing, where there is one.
        best = sorted(runs, key=lambda r: r["seconds"]["solve"])[len(runs) // 2]
        return dict(seconds=best["seconds"]["solve"], operator=best["seconds"]["operator"],
                    residual=best["max_relative_residual"], orthogonality=best["max_orthogonality_error"],
                    count=best["harmonics"], n=best["vertices"], memory_mb=runs[-1]["memory_mb"],
                    counts_match=best["inertia_counts_match"], profile=best["profile"])

    def peer(self, peer, stiffness, basis, k):
        """The peer with 1 and with 4 BLAS threads; the faster counts."""
        arguments = [str(stiffness), str(basis), str(k)]
        if peer == "spectra":
            return timed([str(self.spectra), str(self.raw(stiffness, basis)), str(k)], 1)
        python, extra = self.python, None
        if peer == "slepc":
            python, extra = self.slepc_python, dict(PYTHONPATH=f"{SLEPC}:{PETSC}")
        best = None
        # Minutes long runs are made once, with all threads.
        for threads in (1, THREADS) if k < 500 else (THREADS,):
            limit = LIMIT if best is None else 2 * best["seconds"] + 20
            answer = timed([python, f"peer_{peer}.py", *arguments], threads, extra, limit)
            if "error" in answer:
                if best is None and threads == THREADS:
                    return answer
                continue
            if best is None or answer["seconds"] < best["seconds"]:
                best = dict(answer, threads=threads)
        return best or dict(error=f"over {LIMIT} s")

    def raw(self, stiffness, basis):
        from measure import Operator
        path = Path(str(stiffness) + ".raw")
        if not path.exists():
            operator = Operator(stiffness, basis)
            with open(path, "wb") as out:
                np.array([operator.n, len(operator.data)], dtype=np.int64).tofile(out)
                operator.indptr.astype(np.int64).tofile(out)
                operator.indices.astype(np.int64).tofile(out)
                operator.data.tofile(out)
                operator.mass.tofile(out)
        return path

    def case(self, name, mesh, k, peers, quick):
        stem = f"{mesh.replace('/', '_')}"
        stiffness, basis = self.folder / f"{stem}.S.npz", self.folder / f"{stem}.B.npz"
        export = () if stiffness.exists() else ("--operator", str(stiffness))
        if export:
            # The areas travel in the basis file; a few harmonics are enough for that.
            timed([self.program, "basis", str(self.mesh(mesh)), "-k", "2", "--no-cache", "--quiet", "--json",
                   "-o", str(basis), *export], THREADS)
        repeats = 1 if quick or k > 1000 else 3
        rows = [("Chladni, 4 threads", self.ours(mesh, k, THREADS, repeats)),
                ("Chladni, 1 thread", self.ours(mesh, k, 1, 1 if k >= 500 else repeats))]
        for peer in peers:
            rows.append((peer, self.peer(peer, stiffness, basis, k)))
            print(json.dumps([name, k, *rows[-1]]), flush=True)
        return rows


TITLES = dict(scipy="SciPy eigsh + SuperLU", lapy="LaPy", slepc="SLEPc + MUMPS", spectra="Spectra + SimplicialLLT (1 thread)")


def tables(results, papers):
    lines = ["| case | program | seconds | × our 4 threads | residual | orthogonality | pairs | peak MB |",
             "|---|---|---|---|---|---|---|---|"]
    for (name, k), rows in results:
        ours = rows[0][1]
        for title, answer in rows:
            label = f"{name}, n = {ours.get('n', 0):,}, K = {k}" if title == rows[0][0] else ""
            title = TITLES.get(title, title) + (f" ({answer['threads']} threads)" if "threads" in answer else "")
            if "error" in answer:
                lines.append(f"| {label} | {title} | {answer['error']} | | | | | |")
                continue
            ratio = "" if "error" in ours else f"{answer['seconds'] / ours['seconds']:.1f}"
            lines.append(f"| {label} | {title} | {answer['seconds']:.3f} | {ratio} | {answer['residual']:.0e} "
                         f"| {answer['orthogonality']:.0e} | {answer['count']} | {answer['memory_mb']:.0f} |")
    reached = []
    for case, rows in results:
        ours, peers = rows[0][1], [answer["seconds"] for _, answer in rows[2:] if "error" not in answer]
        if case in AIMS and peers and "error" not in ours:
            times = min(peers) / ours["seconds"]
            reached.append(f"{case[0]}, K = {case[1]}: aim {AIMS[case]}, reached {times:.0f} ({'met' if times >= AIMS[case] else 'missed'})")
    if reached:
        lines += ["", f"Times as fast as the fastest of the others: {'; '.join(reached)}."]
    lines += ["", "Where our time goes (seconds of one thread summed over threads, but for the first two columns):", "",
              "| case | order, analysis (wall) | plan (wall) | factor | solve | orthogonalize | small eigenproblems | vectors | certificate, output (wall) | factors | solved columns |",
              "|---|---|---|---|---|---|---|---|---|---|---|"]
    for (name, k), rows in results:
        p = rows[0][1].get("profile")
        if p and p["factored"]:
            lines.append(f"| {name}, K = {k} | {p['analyze']:.3f} | {p['plan']:.3f} | {p['factor']:.2f} | {p['solve']:.2f} "
                         f"| {p['orthogonalize']:.2f} | {p['project']:.2f} | {p['vectors']:.2f} | {p['assemble']:.3f} "
                         f"| {p['factored']} | {p['solved_columns']} |")
    lines += floors(results)
    lines += ["", "The papers' own preprocessing times (machines of 2010 and 2012; the nearest mesh here):", "",
              "| paper's model | n | K | paper, s | mesh here | n | ours: operator + solve, s |", "|---|---|---|---|---|---|---|"]
    for (model, n, k, seconds, mesh), answer in papers:
        if "error" not in answer:
            lines.append(f"| {model} | {n:,} | {k} | {seconds} | {Path(mesh).stem} | {answer['n']:,} "
                         f"| {answer['operator'] + answer['seconds']:.2f} |")
    return "\n".join(lines)


def gemm_gflops():
    """What one thread reaches on products of the shapes that orthogonalization has."""
    code = """
import numpy, time
v, x = numpy.random.rand(33000, 256), numpy.random.rand(33000, 16)
best = 0
for _ in range(9):
    start = time.perf_counter(); c = v.T @ x; y = x - v @ c; took = time.perf_counter() - start
    best = max(best, 4 * v.size * 16 / took / 1e9)
print(best)
"""
    environment = dict(os.environ, OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")
    return float(subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, check=True).stdout)


def floors(results):
    """How far each case is from its solves and its orthogonalization alone."""
    gemm = gemm_gflops()
    lines = ["", f"The floor: the columns that were solved for, at the time per column of the one-thread run, and the flops of the "
             f"orthogonalization at what NumPy's GEMM reaches on one thread ({gemm:.0f} Gflop/s on 33,000 × 256 by 16 columns), shared by 4 threads:", "",
             "| case | solves, s | orthogonalization, Gflop | floor, s | ours, s | ours / floor |", "|---|---|---|---|---|---|"]
    for (name, k), rows in results:
        ours, one = rows[0][1], rows[1][1]
        if "error" in ours or "error" in one or not one["profile"]["solved_columns"]:
            continue
        per_column = one["profile"]["solve"] / one["profile"]["solved_columns"]
        solves = ours["profile"]["solved_columns"] * per_column
        flops = ours["profile"]["orthogonalize_flops"] / 1e9
        floor = (solves + flops / gemm) / THREADS
        lines.append(f"| {name}, K = {k} | {solves:.2f} | {flops:.1f} | {floor:.2f} | {ours['seconds']:.2f} | {ours['seconds'] / floor:.1f} |")
    return lines


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--quick", action="store_true", help="one run each, no peers beyond n = 15,000; prints its tables")
    parser.add_argument("--only", help="case numbers from 0, separated by commas; prints its tables")
    options = parser.parse_args()
    about = f"{machine()} at the start"
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(Path(folder), Path(os.environ["CHLADNI_DATA"]))
        results, papers = [], []
        chosen = [int(i) for i in options.only.split(",")] if options.only else range(len(CASES))
        for i in chosen:
            name, mesh, k, peers = CASES[i]
            if options.quick and i > 3:
                peers = ()
            rows = bench.case(name, mesh, k, peers, options.quick)
            print(json.dumps([name, k, rows[0][1]]), flush=True)
            results.append(((name, k), rows))
        for paper in PAPERS:
            papers.append((paper, bench.ours(paper[4], paper[2], THREADS, 1)))
    if options.quick or options.only:
        # Not all that is published.
        print(tables(results, papers))
        return
    note = (HERE / "NOTES.md").read_text()
    write_section("basis", f"## Harmonic basis\n\nMeasured by `bench/basis/run` on: {about}.\n\n{note}\n{tables(results, papers)}")


main()
