"""Workers that speak TLS, as the documentation says: by settings of Dask, none of ours."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import dask
import numpy as np
import pytest
from distributed import Security

import tracer
from tracer import scenes
from tracer.cluster import connection
from tracer.errors import ClusterError

SCENE = Path(scenes.__file__).parent / "spheres_and_rods.xml"


@pytest.fixture
def certificate(tmp_path):
    """Return files of a certificate that vouches for itself, and its key."""
    made = Security.temporary()
    paths = {}
    for name, text in (("ca", made.tls_ca_file), ("cert", made.tls_client_cert), ("key", made.tls_client_key)):
        paths[name] = tmp_path / f"{name}.pem"
        paths[name].write_text(text)
    return {name: str(path) for name, path in paths.items()}


@pytest.mark.slow
def test_tls_is_a_matter_of_dasks_settings(certificate, tmp_path, monkeypatch):
    environment = {
        "DASK_DISTRIBUTED__COMM__REQUIRE_ENCRYPTION": "true",
        "DASK_DISTRIBUTED__COMM__TLS__CA_FILE": certificate["ca"],
    }
    for role in ("SCHEDULER", "WORKER", "CLIENT"):
        environment[f"DASK_DISTRIBUTED__COMM__TLS__{role}__CERT"] = certificate["cert"]
        environment[f"DASK_DISTRIBUTED__COMM__TLS__{role}__KEY"] = certificate["key"]
    told = tmp_path / "scheduler.json"
    own = ["--no-dashboard", "--scheduler-file", str(told)]
    commands = [
        ["dask_scheduler", "--protocol", "tls", "--host", "127.0.0.1", "--port", "0", *own],
        ["dask_worker", "--nthreads", "1", "--no-nanny", *own],
    ]
    processes = [
        subprocess.Popen(
            [sys.executable, "-m", f"distributed.cli.{name}", *options],
            env={**os.environ, **environment},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        for name, *options in commands
    ]
    try:
        while not told.exists():
            time.sleep(0.1)
        address = json.loads(told.read_text())["address"]
        assert address.startswith("tls://127.0.0.1:")
        with monkeypatch.context() as patch:
            patch.setattr(connection, "LONGEST_WAIT", 5.0)
            with pytest.raises(ClusterError, match="Cannot connect"):
                tracer.render(SCENE, size=32, spp=4, cluster=address)
        tls = "distributed.comm.tls"
        mine = {f"{tls}.ca-file": certificate["ca"], f"{tls}.client.cert": certificate["cert"]}
        with dask.config.set({**mine, f"{tls}.client.key": certificate["key"]}):
            found = tracer.render(SCENE, size=32, spp=4, cluster=address)
        assert np.array_equal(found.image, tracer.render(SCENE, size=32, spp=4).image)
    finally:
        for process in processes:
            process.kill()
            process.wait()
