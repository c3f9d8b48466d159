"""Workers for all tests of a cluster, as they take seconds to start."""

import pytest

from tracer.cluster.crew import connected, own_cluster


@pytest.fixture(scope="session")
def two_workers():
    with own_cluster(2) as cluster, connected(cluster) as client:
        yield client
