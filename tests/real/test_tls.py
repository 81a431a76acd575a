"""A Dask scheduler that speaks TLS alone, with certificates made here."""

import contextlib
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import dask
import pytest

import swarmcensus as sc
from swarmcensus.runs import clusters
from tests.support.clusters import LONG, study, until
from tests.support.results import same

SHORT = LONG.replace("trials = 200", "trials = 20")

pytest.importorskip("distributed")  # its defaults are merged with each configuration
pytestmark = pytest.mark.skipif(shutil.which("openssl") is None, reason="no openssl here, which makes the certificates")
ROLES = ("client", "scheduler", "worker")


def openssl(*options):
    subprocess.run(["openssl", *map(str, options)], check=True, capture_output=True)


def certificates(folder):
    """An authority, and a certificate of its own for each role: a configuration of Dask's that names them."""
    folder.mkdir()
    key = ("-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes")
    authority = folder / "authority.pem"
    openssl("req", "-x509", *key, "-days", 2, "-subj", "/CN=authority", "-out", authority, "-keyout", folder / "a.key")
    tls = {"ca-file": str(authority)}
    for role in ROLES:
        request, made, private = (folder / f"{role}.{ending}" for ending in ("csr", "pem", "key"))
        openssl("req", "-new", *key, "-subj", f"/CN={role}", "-out", request, "-keyout", private)
        openssl(
            "x509", "-req", "-in", request, "-CA", authority, "-CAkey", folder / "a.key", "-CAcreateserial",
            "-days", 2, "-out", made,
        )  # fmt: skip
        tls[role] = {"cert": str(made), "key": str(private)}
    return {"distributed": {"comm": {"require-encryption": True, "tls": tls}}}


@pytest.fixture(scope="module")
def right(tmp_path_factory):
    """Dask's configuration as a folder with a file, as a user keeps it."""
    folder = tmp_path_factory.mktemp("right")
    (folder / "tls.yaml").write_text(json.dumps(certificates(folder / "certificates")))  # JSON is YAML
    return folder


@pytest.fixture(scope="module")
def scheduler(right):
    """The address of a scheduler with a worker of two threads."""
    file = right / "scheduler.json"
    environment = os.environ | {"DASK_CONFIG": str(right), "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    with open(right / "log", "w") as log, contextlib.ExitStack() as stack:
        for program, *options in (
            ("dask_scheduler", "--protocol", "tls", "--host", "127.0.0.1", "--port", "0", "--no-dashboard"),
            ("dask_worker", "--no-nanny", "--nthreads", "2", "--no-dashboard", "--local-directory", str(right)),
        ):
            process = subprocess.Popen(
                [sys.executable, "-m", f"distributed.cli.{program}", *options, "--scheduler-file", str(file)],
                env=environment, stdin=subprocess.DEVNULL, stdout=log, stderr=log,
            )  # fmt: skip
            stack.callback(ended, process)
            until(file.exists, "the scheduler is there")
        yield json.loads(file.read_text())["address"]


def ended(process):
    process.terminate()
    try:
        process.wait(20)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


@pytest.mark.long
def test_scheduler_with_certificates(scheduler, right, here):
    Path("short.toml").write_text(SHORT)
    assert scheduler.startswith("tls://")
    done = subprocess.run(
        [sys.executable, "-m", "swarmcensus", "run", "short.toml", "--cluster", scheduler],
        env=os.environ | {"DASK_CONFIG": str(right)}, capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert same(sc.load("short.nc"), sc.run(study(SHORT), jobs=2))


def lost(folder):
    found = certificates(folder)
    (folder / "client.pem").unlink()
    return found


NEEDS = "{} needs certificates, which Dask's configuration should name (distributed.comm.tls)"
REFUSED = "no Dask scheduler answers at {}: "


@pytest.mark.long
@pytest.mark.parametrize(
    ("known", "protocol", "said"),
    [(certificates, "tls", REFUSED + "TLS certificate does not match"), (None, "tcp", REFUSED)],
)
def test_refused_certificate_is_one_clear_error(scheduler, here, monkeypatch, refused, known, protocol, said):
    address = scheduler.replace("tls", protocol)
    assert error_of(here, monkeypatch, refused, known, address).startswith(said.format(address))


@pytest.mark.parametrize(("known", "said"), [(lost, REFUSED + "[Errno 2] No such file or directory"), (None, NEEDS)])
def test_missing_certificate_is_found_first(here, monkeypatch, refused, known, said):
    address = "tls://127.0.0.1:1"
    assert error_of(here, monkeypatch, refused, known, address).startswith(said.format(address))


def error_of(here, monkeypatch, refused, known, address):
    monkeypatch.setattr(clusters, "CONNECT", "3s")
    Path("short.toml").write_text(SHORT)
    settings = known(here / "other") if known else {}
    with dask.config.set(dask.config.merge(dask.config.config, settings)):
        return refused("run", "short.toml", "--cluster", address).removeprefix("swarmcensus: ")
