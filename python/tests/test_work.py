"""Progress, cancelling, the interpreter's lock, and exceptions of one family."""

import os
import pickle
import signal
import subprocess
import sys
import threading

import chladni
import numpy as np
import pytest
import scipy.sparse

from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays


@pytest.fixture(scope="module")
def human():
    return chladni.read_mesh("sample:human")


def test_progress_is_told_and_what_it_raises_stops_the_work(human):
    seen = []
    chladni.Basis(*human, 100, progress=lambda *now: seen.append(now))
    assert any(stage == "harmonics" and total == 100 and 0 <= done <= total for stage, done, total in seen)

    def stop(stage, done, total):
        raise KeyError("enough")

    with pytest.raises(KeyError, match="enough"):
        chladni.Basis(*human, 100, progress=stop)
    with pytest.raises(chladni.InputError, match="progress"):
        chladni.Basis(*human, 100, progress=3)


def test_other_threads_run_meanwhile(human):
    count, over = [0], threading.Event()

    def other():
        while not over.is_set():
            count[0] += 1

    thread = threading.Thread(target=other)
    thread.start()
    before = count[0]
    chladni.Basis(*human, 100)
    during = count[0] - before
    over.set()
    thread.join()
    assert during > 0


@pytest.mark.skipif(os.name == "nt", reason="signals of one's own")
def test_ctrl_c_stops_the_work(human):
    def interrupt(stage, done, total):
        os.kill(os.getpid(), signal.SIGINT)

    # Where the tests are a job in the background, the shell has Ctrl-C ignored.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            chladni.Basis(*human, 200, progress=interrupt)
    finally:
        signal.signal(signal.SIGINT, before)
    # The next call begins anew.
    assert len(chladni.Basis(*human, 4).eigenvalues) == 4


@pytest.mark.skipif(os.name == "nt", reason="signals of one's own")
def test_ctrl_c_stops_what_reports_no_progress():
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(30000, 150)), rng.normal(size=(30000, 150))
    path = scipy.sparse.diags([2 * np.ones(3000), -np.ones(2999), -np.ones(2999)], [0, 1, -1])
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        for work in (lambda: chladni.FM_to_p2p(np.eye(150), a, b), lambda: chladni.eigsh(path, 2900, sigma=0)):
            timer = threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT))
            timer.start()
            with pytest.raises(KeyboardInterrupt):
                work()
            timer.join()
    finally:
        signal.signal(signal.SIGINT, before)


def wrong_types():
    V, F = np.eye(3), [[0, 1, 2]]
    H, w = np.ones((5, 4)), np.arange(4.0)
    return [
        lambda: chladni.Basis(V, F, 2, boundary=None),
        lambda: chladni.Basis(V, F, 2, engine=None),
        lambda: chladni.Basis(V, F, 2, whole_clusters="x"),
        lambda: chladni.Basis(V, F, 2, hosts=3, engine="slepc"),
        lambda: chladni.eigsh(np.eye(3), 2, sigma=0, progress=3),
        lambda: chladni.eigsh(np.eye(3), 2, sigma=0, tol="a"),
        lambda: chladni.caricature(V, F, k="a"),
        lambda: chladni.caricature(np.array(3.0), F),
        lambda: chladni.symmetry(np.array(3.0), F),
        lambda: chladni.caricature(V, F, k=2, model=3),
        lambda: chladni.caricature(V, F, k=2, template=[V, F, F]),
        lambda: chladni.match(V, F, V, F, method=None),
        lambda: chladni.match(V, F, V, F, rigid="x"),
        lambda: chladni.read_mesh(3),
        lambda: chladni.write_mesh(None, V, F),
        lambda: chladni.HKS(["a"] * 4, H, [1.0]),
        lambda: chladni.WKS(w, H, [1.0], None),
        lambda: chladni.auto_HKS(w, H, -1),
        lambda: chladni.auto_WKS(w, H, 2.5),
        lambda: chladni.FM_to_p2p(np.eye(2), H, H, use_adj="x"),
        lambda: chladni.zoomout_refine(np.eye(2), H, H, nit=1, A2="a"),
        lambda: chladni.zoomout_refine(np.eye(2), H, H, nit=1, subsample=100),
        lambda: chladni.zoomout_refine(np.eye(2), H, H, nit=1, subsample=([10**9], [0])),
        lambda: chladni.compute_distance_multisource(V, F, []),
        lambda: pickle.dumps(chladni.MeshHeatMethodDistanceSolver(V, F)),
    ]


@pytest.mark.parametrize("call", wrong_types())
def test_arguments_of_a_wrong_type_are_refused_in_a_line(call):
    with pytest.raises(chladni.InputError) as error:
        call()
    assert 10 < len(str(error.value)) < 250 and "\n" not in str(error.value)


def test_where_no_thread_can_be_started_is_an_error():
    # More than any address space has.
    code = """
import chladni
try:
    chladni.mesh_laplacian([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
except chladni.InternalError as error:
    print(error)
"""
    environment = os.environ | {"RUST_MIN_STACK": str(2**60)}
    run = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert "no thread could be started" in run.stdout


def test_exceptions_are_one_family():
    kinds = (chladni.InputError, chladni.NotCertifiedError, chladni.RanksError, chladni.FileError, chladni.InternalError)
    for kind in kinds:
        assert issubclass(kind, chladni.Error)
    assert issubclass(chladni.InputError, ValueError)


numbers = arrays.arrays(
    st.sampled_from([np.float64, np.float32, np.int64, np.uint8, np.complex64, np.bool_, "U3", ">f4"]),
    arrays.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=5),
)
triples = arrays.arrays(
    np.float64,
    st.tuples(st.integers(0, 9), st.just(3)),
    elements=st.one_of(st.integers(-3, 3).map(float), st.floats()),
)
corners = arrays.arrays(np.int64, st.tuples(st.integers(0, 12), st.just(3)), elements=st.integers(-1, 9))
anything = st.one_of(numbers, triples, corners, st.none(), st.text(max_size=3), st.integers(), st.floats())


@given(V=st.one_of(triples, triples, anything), F=st.one_of(corners, corners, anything), k=st.one_of(st.integers(1, 6), anything))
@pytest.mark.filterwarnings("ignore")
def test_no_input_of_a_mesh_crashes(V, F, k):
    calls = [
        lambda: chladni.Basis(V, F, k),
        lambda: chladni.mesh_laplacian(V, F),
        lambda: chladni.compute_distance(V, F, k),
        lambda: chladni.match(V, F, V, F, method="icp"),
    ]
    for call in calls:
        try:
            call()
        except chladni.InternalError:
            raise
        except chladni.Error as error:
            assert str(error)


symmetric = st.integers(1, 8).flatmap(
    lambda n: arrays.arrays(np.float64, (n, n), elements=st.one_of(st.integers(-3, 3).map(float), st.floats()))
)


@given(A=st.one_of(symmetric, anything), M=st.one_of(st.none(), symmetric, anything), k=st.integers(-2, 10), gram=st.booleans())
@pytest.mark.filterwarnings("ignore")
def test_no_matrix_crashes_and_what_is_returned_is_right(A, M, k, gram):
    if gram and isinstance(A, np.ndarray) and A.ndim == 2 and A.dtype == np.float64 and np.abs(A).max(initial=0) < 1e3:
        A = A @ A.T
        M = np.eye(len(A)) * 2 + 0.5 if M is not None else None
    try:
        w, v = chladni.eigsh(A, k, M, sigma=0)
    except chladni.InternalError:
        raise
    except chladni.Error as error:
        assert str(error)
        return
    size = max(np.abs(A).max(), 1e-300)
    mass = np.eye(len(A)) if M is None else np.asarray(M, dtype=float)
    assert np.abs(A @ v - mass @ v * w).max() <= 1e-6 * size * max(np.abs(v).max(), 1)
    assert np.abs(v.T @ mass @ v - np.eye(k)).max() < 1e-6


@given(map_=anything, a=anything, b=anything)
@pytest.mark.filterwarnings("ignore")
def test_no_input_of_a_map_crashes(map_, a, b):
    for call in (lambda: chladni.FM_to_p2p(map_, a, b), lambda: chladni.p2p_to_FM(map_, a, b)):
        try:
            call()
        except chladni.InternalError:
            raise
        except chladni.Error as error:
            assert str(error)
